"""What follows from what was measured: judged by the catalog, or not at all."""

from __future__ import annotations

import re

import numpy as np
import pytest
from report_harness import found, rows

from mikas.catalog import shipped
from mikas.report.findings import BandPosition, Outcome
from mikas.report.measurements.warm_idle import ENOUGH, SETTLING
from mikas.report.sections.limitations import unknowns
from mikas.report.sections.summary import idle_sentence, summary_sentence

WITH_REFERENCE = ("TWAT", "FREQ", "FREQX", "UOZ", "UACC", "INJ", "JAIR", "THR")


def marks(findings):
    return {value.channel.name: value.mark for value in findings.rated}


def all_texts(findings):
    texts = [summary_sentence(findings), idle_sentence(findings), *unknowns(findings)]
    for text in texts:
        assert text.en
        assert not re.search("[А-яЁё]", text.en), text.en
        assert re.search("[А-яЁё]", text.ru), text.ru
        assert not re.search("None|nan|inf|[{}]", text.en + text.ru), text
    return " ".join(text.en for text in texts)


def test_a_sound_engine_is_good_in_every_value() -> None:
    findings = found()
    assert marks(findings) == dict.fromkeys(WITH_REFERENCE, BandPosition.INSIDE)
    assert findings.outcome is Outcome.GOOD
    assert findings.abnormal == ()
    assert summary_sentence(findings).en == (
        "No faults are stored; all 8 values that can be rated are normal at warm idle."
    )
    assert summary_sentence(findings).ru == (
        "Ошибок в памяти блока нет; все значения, которые можно оценить (8), на прогретом "
        "холостом ходу в норме."
    )
    assert "commonly printed" in all_texts(findings)


@pytest.mark.parametrize("name", WITH_REFERENCE)
def test_each_value_is_judged_by_its_reference(name) -> None:
    parameter = shipped().parameter(name)
    assert parameter.reference is not None
    assert parameter.meaning is not None
    low, high = parameter.reference
    step = float(parameter.conversion.scale)
    sides = [
        (high, BandPosition.INSIDE),
        (low, BandPosition.INSIDE),
        (high + step, BandPosition.HIGH),
    ]
    if name != "THR":
        sides.append((low - step, BandPosition.LOW))
    for value, mark in sides:
        (judged,) = [v for v in found(rows(**{name: value})).rated if v.channel.name == name]
        assert judged.mark is mark, value
        expected = {
            BandPosition.LOW: parameter.meaning.low,
            BandPosition.HIGH: parameter.meaning.high,
        }
        assert judged.meaning == expected.get(mark, ("", ""))


def test_values_without_a_reference_are_never_judged() -> None:
    findings = found(rows(TAIR=99, RCOK=-0.9, SSM=255, FUEL_FLOW=30))
    assert marks(findings) == dict.fromkeys(WITH_REFERENCE, BandPosition.INSIDE)
    assert {value.channel.name for value in findings.values if value.unrated} == {
        "TAIR", "RCOK", "SSM", "FUEL_FLOW", "RXX",
    }  # fmt: skip
    assert findings.outcome is Outcome.GOOD


def test_what_is_off_is_in_the_sentence() -> None:
    findings = found(rows(JAIR=11.2, UACC=12.9), faults=(41,))
    assert findings.outcome is Outcome.ATTENTION
    assert summary_sentence(findings).en == (
        "1 fault is stored: 41; at warm idle 2 of the 8 values that can be rated are outside the "
        "normal range: battery voltage (low), air flow (low)."
    )
    assert summary_sentence(findings).ru == (
        "В памяти блока 1 ошибка: 41; на прогретом холостом ходу вне нормы 2 значения из 8: "
        "напряжение бортсети (ниже нормы), расход воздуха (ниже нормы)."
    )
    all_texts(findings)


def test_a_throttle_read_for_a_part_of_the_time_leaves_the_rest_undecided() -> None:
    def part(times):
        return np.where(times < 20, 0.0, np.nan)

    findings = found(rows(THR=part, RXX=None))
    assert (
        "For 37 s of 1 min the throttle position (THR) was not read" in idle_sentence(findings).en
    )
    assert "37 с из 1 мин не опрашивалось: положение дроссельной" in idle_sentence(findings).ru
    all_texts(findings)
    findings = found(rows(THR=part))
    assert "was not asked, and" not in idle_sentence(findings).en
    assert "the unit's idle flag" in idle_sentence(findings).en
    all_texts(findings)


def test_a_median_inside_is_inside_however_it_trembles() -> None:
    def trembling(times):
        return np.where(np.arange(times.size) % 10 < 3, 700, 850)

    (value,) = [v for v in found(rows(FREQX=trembling)).rated if v.channel.name == "FREQX"]
    assert value.mark is BandPosition.INSIDE
    assert (value.stats.low, value.stats.inside) == (700, pytest.approx(0.7, abs=0.01))


def test_nothing_is_judged_that_was_not_at_warm_idle() -> None:
    findings = found(rows(TWAT=45, UACC=11.0, JAIR=200.0))
    assert findings.rated == ()
    assert not findings.measured.idle.enough
    assert findings.outcome is Outcome.OPEN
    assert summary_sentence(findings).en == (
        "No faults are stored; there was no warm idle, so no value is rated."
    )
    assert "coolant temperature was 45 °C" in idle_sentence(findings).en
    assert "температура охлаждающей жидкости (ДТОЖ) — 45 °C" in idle_sentence(findings).ru
    all_texts(findings)


def test_an_idle_too_fast_to_be_one_is_named() -> None:
    findings = found(rows(FREQ=1520))
    assert not findings.measured.idle.enough
    assert findings.outcome is Outcome.OPEN
    summary = summary_sentence(findings)
    assert "the speed was never below 1520 rpm, so no value is rated" in summary.en
    assert "обороты не опускались ниже 1520 об/мин" in summary.ru
    all_texts(findings)
    for other in (rows(FREQ=1520, TWAT=45), rows(FREQ=1520, THR=30, RXX=0), rows(FREQ=0)):
        assert "never below" not in summary_sentence(found(other)).en


def test_only_values_at_warm_idle_count() -> None:
    def driving(times):
        return np.where(times < 40, 2400, 840)

    def load(times):
        return np.where(times < 40, 90.0, 14.5)

    findings = found(rows(60, FREQ=driving, JAIR=load))
    assert marks(findings)["JAIR"] is BandPosition.INSIDE
    assert findings.measured.at_idle["JAIR"].most == 14.5
    assert findings.measured.whole["JAIR"].most == 90


def test_too_little_warm_idle_judges_nothing_and_says_so() -> None:
    findings = found(rows(SETTLING + ENOUGH - 2))
    assert findings.rated == ()
    assert "Only 8 s found; 10 s are needed" in idle_sentence(findings).en
    assert "Найдено только 8 с" in idle_sentence(findings).ru


def test_a_parameter_with_too_few_values_is_not_judged() -> None:
    def seldom(times):
        return np.where(np.isin(np.arange(times.size), (100, 200, 300, 400)), 9.9, np.nan)

    findings = found(rows(60, UACC=seldom))
    assert "UACC" not in marks(findings)
    assert "UACC" in {value.channel.name for value in findings.values if value.unrated}


def test_without_its_parameters_warm_idle_can_not_be_determined() -> None:
    findings = found(rows(THR=None, RXX=None))
    assert findings.rated == ()
    assert (
        "Can't be determined, as this was not recorded: throttle at 5 % or less"
        in idle_sentence(findings).en
    )
    assert "Not measured: throttle position." in all_texts(findings)


def test_without_values_and_faults_the_outcome_is_open() -> None:
    findings = found(rows(0), faults=None)
    assert findings.outcome is Outcome.OPEN
    texts = all_texts(findings)
    assert "the data contain none" in texts
    assert "faults were not read" in texts.lower()


@pytest.mark.parametrize(
    ("faults", "en", "ru"),
    [
        (None, "The stored faults were not read;", "Ошибки не считывались;"),
        ((), "No faults are stored;", "Ошибок в памяти блока нет;"),
        ((12,), "No faults are stored;", "Ошибок в памяти блока нет;"),
        ((12, 53), "1 fault is stored: 53;", "В памяти блока 1 ошибка: 53;"),
        ((13, 53, 99), "3 faults are stored: 13, 53, 99;", "В памяти блока 3 ошибки: 13, 53, 99;"),
        (tuple(range(80, 91)), "11 faults are stored: 80,", "В памяти блока 11 ошибок: 80,"),
    ],
)
def test_the_sentence_begins_with_the_stored_faults(faults, en, ru) -> None:
    findings = found(faults=faults)
    assert summary_sentence(findings).en.startswith(en)
    assert summary_sentence(findings).ru.startswith(ru)
    outcome = {None: Outcome.OPEN, (): Outcome.GOOD, (12,): Outcome.GOOD}
    assert findings.outcome is outcome.get(faults, Outcome.ATTENTION)
    all_texts(findings)


def test_a_fault_and_its_values_know_of_each_other() -> None:
    findings = found(faults=(13, 14, 21))
    assert findings.subject.faults is not None
    related = map(findings.values_of, findings.subject.faults)
    assert [[v.channel.name for v in each] for each in related] == [
        ["JAIR"], ["JAIR"], ["TWAT"],
    ]  # fmt: skip
    bearing = {value.channel.name: value.sensor for value in findings.suspended}
    assert bearing == {"JAIR": (13, 14), "TWAT": (21,)}
    assert {"JAIR", "TWAT"}.isdisjoint(marks(findings))
    texts = all_texts(findings)
    assert "Whether the engine was at warm idle: the coolant temperature shows it" in texts
    assert "the sensor's fault 21" in texts
    assert "whether that was warm idle is not certain" in texts


def test_sessions_damage_and_unknown_faults_are_mentioned() -> None:
    texts = all_texts(found(faults=(99,), sessions=3, damaged=1))
    assert "The file holds 3 sessions; this report covers the last one." in texts
    assert "1 damaged place of the file" in texts
    assert "the unknown fault numbers" in texts
    assert "damaged" not in all_texts(found())


def test_a_passport_that_is_not_reported_is_told_from_an_unidentified_unit() -> None:
    from dataclasses import replace

    from mikas.report.subject import ReportedUnit

    findings = found()
    silent = ReportedUnit(shipped().model(9), (None, None, None), (None,) * 5)
    reported = unknowns(replace(findings, subject=replace(findings.subject, unit=silent)))
    assert reported[0].en == "The unit's passports: it does not report them."
    reported = unknowns(replace(findings, subject=replace(findings.subject, unit=None)))
    assert "it was not identified" in reported[0].en
