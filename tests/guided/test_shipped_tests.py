"""Each shipped test on the virtual car: sound, with its fault, with another one, with bad data."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache

import pytest
from guided_rig import Row, car_rows, run

from mikas.catalog import shipped
from mikas.guided.definition import Outcome
from mikas.guided.loading import load
from mikas.guided.result import TestResult, read

TESTS = load(shipped()).tests

START = """
[start]
ambient = 15
{start}
[timeline]
key = 1
starter = [[0, 0], [12, 1], [30, 0]]
throttle = 0
gear = 0
[condition]
{condition}
"""
DRIVES = {
    "charging": (START, 70, 10),
    "sensors": (START, 9, 6),
}
"""The scenario of each test, its length in seconds, and readings a second."""


@cache
def rows_of(test: str, start: str, condition: str) -> tuple[Row, ...]:
    scenario, seconds, rate = DRIVES[test]
    text = scenario.format(start=start, condition=condition)
    return tuple(car_rows(text, TESTS[test].channels, seconds, rate))


def judged(test: str, rows: Iterable[Row]) -> TestResult:
    result = run(TESTS[test], rows)
    assert result is not None, "the steps were not found"
    return result


def rules(result: TestResult) -> set[str]:
    return {finding.rule for finding in result.findings}


def test_every_test_is_proven_here() -> None:
    assert load(shipped()).errors == ()
    assert set(DRIVES) == set(TESTS)


@pytest.mark.parametrize("test", DRIVES)
def test_a_sound_car_is_good(test: str) -> None:
    result = judged(test, rows_of(test, "", ""))
    assert result.outcome is Outcome.GOOD, result.as_text().en
    assert rules(result) == {"good"}
    assert all(number.value is not None for number in result.numbers)
    assert read(result.as_json()) == result
    for language in result.as_text():
        assert "{" not in language


@pytest.mark.parametrize(
    ("test", "start", "condition", "outcome", "found"),
    [
        ("charging", "", "alternator = 0.3", Outcome.BAD, {"no_charge"}),
        ("charging", "", "regulator = 15.6", Outcome.BAD, {"overcharge"}),
        ("charging", "battery = 0.7", "", Outcome.BAD, {"weak_battery"}),
        ("charging", "battery = 0.7", "alternator = 0", Outcome.BAD, {"weak_battery", "no_charge"}),
        ("charging", "", "coolant_sensor = 15", Outcome.GOOD, {"good"}),
        ("sensors", "", "coolant_sensor = 15", Outcome.ATTENTION, {"apart"}),
        ("sensors", "", "coolant_sensor = -12", Outcome.ATTENTION, {"apart"}),
        ("sensors", "coolant = 60", "", Outcome.UNKNOWN, set()),
        ("sensors", "battery = 0.7", "alternator = 0", Outcome.GOOD, {"good"}),
    ],
)
def test_a_fault_is_found_and_no_other(
    test: str, start: str, condition: str, outcome: Outcome, found: set[str]
) -> None:
    result = judged(test, rows_of(test, start, condition))
    assert (result.outcome, rules(result)) == (outcome, found), result.as_text().en


def without(rows: Iterable[Row], began: float, ended: float) -> Iterator[Row]:
    return (row for row in rows if not began <= row[0] < ended)


def lacking(rows: Iterable[Row], name: str) -> Iterator[Row]:
    return ((time, {n: v for n, v in values.items() if n != name}) for time, values in rows)


def test_a_gap_while_the_starter_turns_decides_nothing() -> None:
    rows = rows_of("charging", "battery = 0.7", "")
    result = judged("charging", without(rows, 12.2, 13.6))
    assert (result.outcome, result.findings) == (Outcome.UNKNOWN, ())
    assert "no values of UACC came for 1.5 s" in result.missing[0].en


def test_slow_sampling_decides_nothing() -> None:
    rows = rows_of("charging", "battery = 0.7", "")[::3]
    result = judged("charging", rows)
    assert result.outcome is Outcome.UNKNOWN
    assert "5.0 are needed" in result.missing[0].en


@pytest.mark.parametrize("test", DRIVES)
def test_a_missing_channel_never_makes_a_verdict(test: str) -> None:
    for name in TESTS[test].channels:
        result = run(TESTS[test], lacking(rows_of(test, "", ""), name))
        watched = {each for step in TESTS[test].steps for each in step.watch}
        assert result is None or result.outcome is Outcome.UNKNOWN or name in watched
