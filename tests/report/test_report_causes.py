"""The causes in the report: its summary and its section say the same, as certainly."""

from __future__ import annotations

from dataclasses import replace

import pytest
from report_harness import found, rows

from mikas.causes.result import (
    CauseVerdict,
    Likelihood,
    MeasurementOutcome,
    NextMeasurement,
    RankedCause,
    Ranking,
)
from mikas.i18n import Text
from mikas.report.findings import Findings, Outcome, find
from mikas.report.page import render
from mikas.report.sections.summary import headline, summary_sentence

SPEAKS = Text("What was seen speaks for: Air leak.", "Данные говорят за: Подсос.")
NOTHING = Text("Nothing speaks against this engine.", "Ничто не говорит о неисправности.")
SEVERAL = Text("Something is off; several causes.", "Что-то не так; причин несколько.")
UNDECIDED = Text("These data don't decide.", "По этим данным нельзя решить.")


def cause(likelihood: Likelihood, en: str = "Air leak", ru: str = "Подсос") -> RankedCause:
    check = Text("Spray cleaner.", "Брызгайте очистителем.")
    name = en.lower().replace(" ", "_")
    return RankedCause(name, "", likelihood, 0.9, Text(en, ru), check, (), (), "unconfirmed", "")


def with_causes(
    of: Findings, verdict: CauseVerdict, text: Text, *causes: RankedCause, off: bool = False
) -> Findings:
    """The findings with a ranking; `off`: no sound car has such values."""
    ranking = Ranking(verdict, text, causes, (), (), (), 60.0, off)
    return find(replace(of.subject, causes=ranking), of.measured)


def leaking(likelihood: Likelihood = Likelihood.ALMOST_CERTAIN, **how) -> Findings:
    return with_causes(found(**how), CauseVerdict.CAUSES, SPEAKS, cause(likelihood), off=True)


@pytest.mark.parametrize(
    ("likelihood", "en", "ru"),
    [
        (Likelihood.ALMOST_CERTAIN, "Almost certainly: Air leak. ", "Почти наверняка: Подсос. "),
        (Likelihood.PROBABLE, "Probably: Air leak. ", "Вероятно: Подсос. "),
        (Likelihood.POSSIBLE, "Possibly: Air leak. ", "Возможно: Подсос. "),
    ],
)
def test_a_cause_is_named_first_as_certainly_as_in_its_section(likelihood, en, ru) -> None:
    findings = leaking(likelihood)
    said = summary_sentence(findings)
    assert said.en.startswith(en)
    assert said.ru.startswith(ru)
    assert "No faults are stored; all 8 values" in said.en
    assert (findings.outcome, headline(findings).en) == (Outcome.ATTENTION, "Attention needed")
    page = render(findings, "en")
    assert "<strong>Air leak</strong>: " + en.partition(":")[0].lower() in page
    assert "No problems found" not in page


def test_without_faults_read_and_without_idle_a_cause_needs_attention_still() -> None:
    of = found(rows(8), faults=None)
    findings = with_causes(of, CauseVerdict.CAUSES, SPEAKS, cause(Likelihood.PROBABLE), off=True)
    page = render(findings, "en")
    assert "Not enough data" not in page
    assert summary_sentence(findings).en.startswith(
        "Probably: Air leak. The stored faults were not read; warm idle lasted only"
    )


def test_two_probable_causes_are_both_named_and_a_possible_one_is_not() -> None:
    findings = with_causes(
        found(),
        CauseVerdict.CAUSES,
        SPEAKS,
        cause(Likelihood.ALMOST_CERTAIN),
        cause(Likelihood.PROBABLE, "Dirty passage", "Канал закоксован"),
        cause(Likelihood.POSSIBLE, "Weak starter", "Стартер слабый"),
        off=True,
    )
    said = summary_sentence(findings)
    assert said.en.startswith("Almost certainly: Air leak; probably: Dirty passage. No faults")
    assert said.ru.startswith("Почти наверняка: Подсос; вероятно: Канал закоксован. Ошибок")


def test_what_no_known_cause_explains_needs_attention() -> None:
    unknown = Text("Something is off, unexplained.", "Что-то не так, необъяснимо.")
    findings = with_causes(found(), CauseVerdict.UNKNOWN, unknown, off=True)
    assert findings.outcome is Outcome.ATTENTION
    assert summary_sentence(findings).en.startswith("Something is off, unexplained. No faults")


def test_where_several_causes_are_possible_nothing_is_called_in_order() -> None:
    findings = with_causes(
        found(), CauseVerdict.CANNOT_TELL, SEVERAL, cause(Likelihood.POSSIBLE), off=True
    )
    assert findings.outcome is Outcome.OPEN
    assert summary_sentence(findings).en.startswith("Something is off; several causes. No faults")
    assert "<strong>Air leak</strong>: possibly" in render(findings, "en")


def test_possible_causes_stand_beside_a_value_that_is_off_and_not_beside_sound_ones() -> None:
    possible = cause(Likelihood.POSSIBLE)
    low = with_causes(found(rows(UACC=12.9)), CauseVerdict.CANNOT_TELL, UNDECIDED, possible)
    assert low.outcome is Outcome.ATTENTION
    assert "<strong>Air leak</strong>: possibly" in render(low, "en")
    well = with_causes(found(), CauseVerdict.CANNOT_TELL, UNDECIDED, possible)
    assert well.outcome is Outcome.GOOD
    assert "Air leak" not in render(well, "en")


def test_the_next_measurement_stands_with_its_outcomes_but_not_for_a_sound_car() -> None:
    outcome = MeasurementOutcome(Text("more than 13 V", "больше 13 В"), "leak", Text("Leak", "П"))
    why = Text("It separates.", "Различит.")
    hand = NextMeasurement("by-hand", False, Text("A voltmeter.", "Вольтметр."), why, (outcome,))
    of = leaking()
    assert of.subject.causes is not None
    ranking = replace(of.subject.causes, next=(hand,))
    page = render(find(replace(of.subject, causes=ranking), of.measured), "en")
    assert "<p>A voltmeter. It separates.</p><ul><li>more than 13 V: Leak</li></ul>" in page
    sound = replace(ranking, verdict=CauseVerdict.SOUND, causes=())
    assert "A voltmeter." not in render(find(replace(of.subject, causes=sound), of.measured), "en")


def test_a_sound_car_is_called_sound_and_what_was_not_checked_is_named() -> None:
    sound = with_causes(found(), CauseVerdict.SOUND, NOTHING)
    assert headline(sound).en == "No problems found"
    assert summary_sentence(sound).en.startswith("Nothing speaks against this engine. No faults")
    unread = with_causes(found(faults=None), CauseVerdict.SOUND, NOTHING)
    assert unread.outcome is Outcome.OPEN
    assert headline(unread).en == "Nothing found, but not everything was checked"
    assert "The stored faults were not read" in summary_sentence(unread).en


def test_beside_a_fault_the_car_is_not_called_sound() -> None:
    findings = with_causes(found(faults=(13,)), CauseVerdict.SOUND, NOTHING)
    for language, words in (("en", NOTHING.en), ("ru", NOTHING.ru)):
        page = render(findings, language)
        assert words not in page
    assert "The values speak for none of the known causes" in render(findings, "en")
