"""Each shipped test on the virtual car: sound, with its fault, with another one, with bad data."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache

import pytest
from guided_rig import Row, car_rows, run

from mikas.catalog import shipped
from mikas.guided.definition import VerdictKind, parameters_of
from mikas.guided.loading import load
from mikas.guided.measuring import formulas_inputs
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
SWEEP = """
[start]
ambient = 20
coolant = 85
{start}
[timeline]
key = 1
gear = 0
throttle = [[0, 0], [4, 0], [9, 100], [11, 100], [14, 0], [24, 0], [32, 9], [44, 9]]
starter = [[0, 0], [16, 1], [20, 0]]
[condition]
{condition}
"""
WARM_UP = """
[start]
ambient = 5
running = true
{start}
[timeline]
speed = [[0, 0], [10, 0], [30, 70], [300, 70]]
[condition]
{condition}
"""
IDLE = """
[start]
coolant = 86
running = true
{start}
[timeline]
gear = 0
throttle = [[0, 0], [36, 0], [38, 9], [70, 9]]
[condition]
{condition}
"""
PULL = """
[start]
coolant = 86
running = true
{start}
[timeline]
gear = [[0, 0], [10, 3]]
throttle = [[0, 0], [10, 0], [11, 15], [14, 15], [15, 80], [24, 80]]
speed = [[0, 0], [10, 0], [10.1, 60], [15, 60], [24, 95]]
[condition]
{condition}
"""
DRIVES = {
    "charging": (START, 70, 10),
    "cranking": (START, 24, 17),
    "idle": (IDLE, 58, 4),
    "knock": (PULL, 25, 12),
    "sensors": (START, 9, 6),
    "throttle": (SWEEP, 46, 8),
    "warmup": (WARM_UP, 225, 0.5),
}
COLD = "coolant = 68.7"
"""The scenario of each test, its length in seconds, and readings a second."""


@cache
def rows_of(test: str, start: str, condition: str) -> tuple[Row, ...]:
    scenario, seconds, rate = DRIVES[test]
    if scenario is WARM_UP and not start:
        start = COLD
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
    assert result.outcome is VerdictKind.GOOD, result.as_text().en
    assert rules(result) == {"good"}
    assert all(number.value is not None for number in result.numbers)
    assert read(result.as_json()) == result
    for language in result.as_text():
        assert "{" not in language


@pytest.mark.parametrize(
    ("test", "start", "condition", "outcome", "found"),
    [
        ("charging", "", "alternator = 0.3", VerdictKind.BAD, {"no_charge"}),
        ("charging", "", "regulator = 15.6", VerdictKind.BAD, {"overcharge"}),
        ("charging", "battery = 0.7", "", VerdictKind.BAD, {"weak_battery"}),
        ("charging", "", "coolant_sensor = 15", VerdictKind.GOOD, {"good"}),
        ("cranking", "", "starter = 0.8", VerdictKind.BAD, {"slow_starter"}),
        ("cranking", "battery = 0.5", "", VerdictKind.BAD, {"slow_battery"}),
        ("cranking", "", "leak = 4", VerdictKind.GOOD, {"good"}),
        ("idle", "", "idle_valve = 12", VerdictKind.BAD, {"hunting"}),
        ("idle", "", "leak = 4", VerdictKind.BAD, {"leak"}),
        ("idle", "", "air_meter = 0.8", VerdictKind.BAD, {"meter"}),
        ("idle", "", "alternator = 0", VerdictKind.GOOD, {"good"}),
        ("knock", "", "knock = 6", VerdictKind.BAD, {"knock"}),
        ("knock", "", "knock = 3", VerdictKind.ATTENTION, {"some_knock"}),
        ("throttle", "", "throttle_dead = [30, 45]", VerdictKind.BAD, {"dead_spot"}),
        ("throttle", "", "leak = 4", VerdictKind.GOOD, {"good"}),
        ("warmup", "", "thermostat = 1", VerdictKind.BAD, {"open"}),
        ("sensors", "", "coolant_sensor = 15", VerdictKind.ATTENTION, {"apart"}),
        ("sensors", "", "coolant_sensor = -12", VerdictKind.ATTENTION, {"apart"}),
        ("sensors", "coolant = 60", "", VerdictKind.UNKNOWN, set()),
        ("sensors", "battery = 0.7", "alternator = 0", VerdictKind.GOOD, {"good"}),
    ],
)
def test_a_fault_is_found_and_no_other(
    test: str, start: str, condition: str, outcome: VerdictKind, found: set[str]
) -> None:
    result = judged(test, rows_of(test, start, condition))
    assert (result.outcome, rules(result)) == (outcome, found), result.as_text().en


def test_an_air_flow_that_does_not_follow_the_throttle() -> None:
    """The model has no loose connector, so the values of the sound car are changed."""
    rows = rows_of("throttle", "", "")
    halved = ((time, v | {"JAIR": v["JAIR"] * 0.5}) for time, v in rows)
    assert rules(judged("throttle", halved)) == {"air_implausible"}
    loose = ((time, v | {"JAIR": 6.0 if 4 <= v["THR"] <= 6 else v["JAIR"]}) for time, v in rows)
    assert rules(judged("throttle", loose)) == {"air_falls"}


def test_an_engine_that_overheats() -> None:
    hot = (
        (t, v | {"TWAT": v["TWAT"] + (25 if t > 40 else 0)}) for t, v in rows_of("warmup", "", "")
    )
    assert rules(judged("warmup", hot)) == {"hot"}


def without(rows: Iterable[Row], began: float, ended: float) -> Iterator[Row]:
    return (row for row in rows if not began <= row[0] < ended)


def lacking(rows: Iterable[Row], name: str) -> Iterator[Row]:
    return ((time, {n: v for n, v in values.items() if n != name}) for time, values in rows)


def test_a_gap_while_the_starter_turns_decides_nothing() -> None:
    rows = rows_of("charging", "battery = 0.7", "")
    result = judged("charging", without(rows, 12.2, 13.6))
    assert (result.outcome, result.findings) == (VerdictKind.UNKNOWN, ())
    assert "no values of UACC came for 1.5 s" in result.missing[0].en


@pytest.mark.parametrize(
    ("test", "every"),
    [
        ("charging", 3),
        ("cranking", 3),
        ("idle", 3),
        ("knock", 2),
        ("sensors", 13),
        ("throttle", 2),
        ("warmup", 6),
    ],
)
def test_slow_sampling_decides_nothing(test: str, every: int) -> None:
    result = run(TESTS[test], rows_of(test, "", "")[::every])
    assert result is None or (result.outcome, result.findings) == (VerdictKind.UNKNOWN, ())


@pytest.mark.parametrize("test", DRIVES)
def test_a_missing_channel_never_makes_a_verdict(test: str) -> None:
    known = TESTS[test]
    formulas = [step.until for step in known.steps]
    judging = {name for rule in known.rules for name in rule.when.inputs}
    formulas += [each for name in judging for each in known.measures[name].formulas]
    for name in parameters_of(shipped(), formulas_inputs(formulas)):
        result = run(known, lacking(rows_of(test, "", ""), name))
        assert result is None or result.outcome is VerdictKind.UNKNOWN, name
