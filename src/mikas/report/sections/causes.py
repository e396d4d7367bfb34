"""The section on causes: the verdict in a sentence, the likeliest causes with what speaks for them,
and where the knowledge comes from. Without enough data there is none.
"""

from __future__ import annotations

from typing import Final

from markupsafe import Markup

from mikas.causes.result import LIKELIHOODS, CauseVerdict, RankedCause
from mikas.i18n import Language, Text
from mikas.report.findings import Findings
from mikas.report.sections.section import PageSection, items, paragraph

_TITLE: Final = Text("Causes", "Причины")
_NOT_SEEN: Final = Text("Not seen: {kinds}.", "Не видно: {kinds}.")
_MOST: Final = 3  # causes
_EVIDENCE: Final = 3  # of each; the page prints on two sheets, or three


def cause_section(found: Findings, language: Language) -> PageSection | None:
    """Return the section of the causes; None where the data decide nothing."""
    ranking = found.subject.causes
    if ranking is None or ranking.verdict is CauseVerdict.CANNOT_TELL:
        return None
    parts = [paragraph(ranking.text.to(language))]
    parts += [_cause(cause, language) for cause in ranking.causes[:_MOST]]
    doubts = [doubt.to(language) for doubt in ranking.doubts]
    if ranking.not_seen:
        kinds = ", ".join(kind.to(language) for kind in ranking.not_seen)
        doubts.insert(0, _NOT_SEEN.filled(kinds=kinds).to(language))
    parts.append(Markup("<p class='small quiet'>{}</p>").format(" ".join(doubts)))
    return PageSection(_TITLE.to(language), Markup("").join(parts))


def _cause(cause: RankedCause, language: Language) -> Markup:
    likely = LIKELIHOODS[cause.likelihood].to(language)
    title = Markup("<p><strong>{}</strong>: {}</p>").format(
        cause.text.to(language), f"{likely}. {cause.check.to(language)}"
    )
    evidence = [each.text.to(language) for each in cause.evidence_for[:_EVIDENCE]]
    return title + items(evidence) if evidence else title
