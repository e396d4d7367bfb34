"""The causes: in the summary, and as a section of the page.

Almost certainly: Air leak past the air meter.                  in the summary
The verdict in a sentence, the likeliest causes with what       in the section
speaks for them, and where the knowledge comes from

Both say the same of a car, with the same certainty.
"""

from __future__ import annotations

from typing import Final

from markupsafe import Markup

from mikas.causes.result import (
    LIKELIHOODS,
    CauseVerdict,
    Likelihood,
    NextMeasurement,
    RankedCause,
    Ranking,
)
from mikas.i18n import Language, Text, joined
from mikas.report.findings import Findings, Outcome
from mikas.report.sections.section import PageSection, items, paragraph

_TITLE: Final = Text("Causes", "Причины")
_NOT_SEEN: Final = Text("Not seen: {kinds}.", "Не видно: {kinds}.")
_NONE_SEEN: Final = Text(
    "The values speak for none of the known causes; what the report names above remains.",
    "Ни за одну из известных причин данные не говорят; сказанное в начале отчёта остаётся в силе.",
)
_NEXT: Final = Text("What to measure next", "Что измерить дальше")
_MOST: Final = 3  # causes
_EVIDENCE: Final = 3  # of each; the page prints on two sheets, or three


def cause_sentences(found: Findings) -> tuple[Text, ...]:
    """Return the sentence of the summary on the causes; none where the data decide nothing.

    A sound verdict is no sentence beside a fault or a value that needs attention.
    """
    ranking = found.subject.causes
    if ranking is None:
        return ()
    if ranking.verdict is CauseVerdict.CAUSES:
        return (_named(ranking),)
    sound = ranking.verdict is CauseVerdict.SOUND and found.outcome is not Outcome.ATTENTION
    return (ranking.text,) if sound or ranking.something_off else ()


def _named(ranking: Ranking) -> Text:
    """`Almost certainly: Air leak past the air meter.`: the leading cause, and all probable."""
    named = [
        joined(": ", (LIKELIHOODS[cause.likelihood], cause.text))
        for place, cause in enumerate(ranking.causes)
        if place == 0 or cause.likelihood is not Likelihood.POSSIBLE
    ]
    said = joined("; ", named)
    return Text(*(f"{each[:1].upper()}{each[1:]}." for each in said))


def cause_section(found: Findings, language: Language) -> PageSection | None:
    """Return the section of the causes; None where the data decide nothing, unless something needs
    attention: then it has the possible ones.
    """
    ranking = found.subject.causes
    if ranking is None:
        return None
    attention = found.outcome is Outcome.ATTENTION or ranking.something_off
    if ranking.verdict is CauseVerdict.CANNOT_TELL and not (attention and ranking.causes):
        return None
    beside = ranking.verdict is CauseVerdict.SOUND and attention
    parts = [paragraph((_NONE_SEEN if beside else ranking.text).to(language))]
    parts += [_cause(cause, language) for cause in ranking.causes[:_MOST]]
    if ranking.next and ranking.verdict is not CauseVerdict.SOUND:
        parts.append(Markup("<h3>{}</h3>").format(_NEXT.to(language)))
        parts += [_next(each, language) for each in ranking.next]
    doubts = [doubt.to(language) for doubt in ranking.doubts]
    if ranking.not_seen:
        kinds = ", ".join(kind.to(language) for kind in ranking.not_seen)
        doubts.insert(0, _NOT_SEEN.filled(kinds=kinds).to(language))
    parts.append(Markup("<p class='small quiet'>{}</p>").format(" ".join(doubts)))
    return PageSection(_TITLE.to(language), Markup("").join(parts))


def _next(measurement: NextMeasurement, language: Language) -> Markup:
    text = paragraph(f"{measurement.text.to(language)} {measurement.why.to(language)}")
    outcomes = [joined(": ", (it.text, it.means)).to(language) for it in measurement.outcomes]
    return text + items(outcomes) if outcomes else text


def _cause(cause: RankedCause, language: Language) -> Markup:
    likely = LIKELIHOODS[cause.likelihood].to(language)
    title = Markup("<p><strong>{}</strong>: {}</p>").format(
        cause.text.to(language), f"{likely}. {cause.check.to(language)}"
    )
    evidence = [each.text.to(language) for each in cause.evidence_for[:_EVIDENCE]]
    return title + items(evidence) if evidence else title
