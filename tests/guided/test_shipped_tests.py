"""Each shipped test on the virtual car: sound, with its fault, with another one, with bad data."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache
from typing import NamedTuple

import pytest
from guided_rig import Row, car_rows, run

from mikas.catalog import shipped
from mikas.catalog.ignition_only import DEAD
from mikas.guided.definition import VerdictKind, parameters_of
from mikas.guided.engine import TestEngine
from mikas.guided.loading import load
from mikas.guided.measuring import formulas_inputs
from mikas.guided.result import TestResult, read

TESTS = load(shipped()).tests

CONSUMERS = "consumers = [[0, 0], [41, 0], [42, 20]]"
PEDAL = "throttle = [[0, 0], [4, 0], [9, 100], [11, 100], [14, 0], [24, 0], [32, 9], [44, 9]]"
TOO_FAST = "throttle = [[0, 0], [4, 0], [4.3, 100], [11, 100], [14, 0], [24, 0], [32, 9], [44, 9]]"
SLIPPED = "throttle = [[0, 0], [4, 0], [9, 100], [11, 100], [11.1, 0], [24, 0], [32, 9], [44, 9]]"
RAISED = "throttle = [[0, 0], [36, 0], [38, 10], [70, 10]]"
RAISED_LATE = "throttle = [[0, 0], [128, 0], [130, 10], [170, 10]]"
RAISED_LITTLE = "throttle = [[0, 0], [36, 0], [38, 3], [70, 3]]"
RESTING = "throttle = [[0, 2], [8, 4], [16, 2], [24, 4], [36, 2], [38, 10], [70, 10]]"
ROAD = "speed = [[0, 0], [10, 0], [30, 70], [300, 70]]"

START = """
[start]
ambient = 15
{start}
[timeline]
key = 1
starter = [[0, 0], [12, 1], [30, 0]]
throttle = 0
gear = 0
{driver}
[condition]
{condition}
"""
SWEEP = """
[start]
ambient = 20
{start}
[timeline]
key = 1
gear = 0
starter = [[0, 0], [16, 1], [20, 0]]
{driver}
[condition]
{condition}
"""
WARM_UP = """
[start]
{start}
[timeline]
starter = [[0, 0], [1, 1], [8, 0]]
{driver}
[condition]
{condition}
"""
IDLE = """
[start]
running = true
{start}
[timeline]
gear = 0
{driver}
[condition]
{condition}
"""
PULL = """
[start]
coolant = 86
{start}
[timeline]
starter = [[0, 0], [1, 1], [8, 0]]
gear = [[0, 0], [16, 3]]
throttle = [[0, 0], [16, 0], [17, 15], [20, 15], [21, 80], [30, 80]]
speed = [[0, 0], [16, 0], [16.1, 60], [21, 60], [30, 95]]
{driver}
[condition]
{condition}
"""


class Drive(NamedTuple):
    """The scenario that performs a test, its seconds, readings a second, what a case may change."""

    scenario: str
    seconds: float
    rate: float
    start: str = ""
    driver: str = ""


DRIVES = {
    "charging": Drive(START, 56, 10, driver=CONSUMERS),
    "cranking": Drive(START, 22, 17),
    "idle": Drive(IDLE, 145, 4, "coolant = 86", RAISED),
    "knock": Drive(PULL, 27, 12),
    "sensors": Drive(START, 7, 6),
    "throttle": Drive(SWEEP, 37, 8, "coolant = 85", PEDAL),
    "warmup": Drive(WARM_UP, 220, 0.5, "ambient = 5\ncoolant = 68.7", ROAD),
}


class Case(NamedTuple):
    """A car and its driver, the verdict, and the rules that hold."""

    test: str
    outcome: VerdictKind
    found: set[str]
    condition: str = ""
    start: str = ""
    driver: str = ""
    faults: str = ""


GOOD, BAD, ATTENTION, UNKNOWN = (
    VerdictKind.GOOD,
    VerdictKind.BAD,
    VerdictKind.ATTENTION,
    VerdictKind.UNKNOWN,
)
CASES = [
    Case("charging", BAD, {"no_charge"}, "alternator = 0.3"),
    Case("charging", BAD, {"overcharge"}, "regulator = 15.6"),
    Case("charging", BAD, {"weak_battery"}, start="battery = 0.7"),
    Case("charging", ATTENTION, {"discharged"}, start="discharged = 25"),
    Case("charging", ATTENTION, {"weak_charge"}, "alternator = 0.8"),
    Case("charging", GOOD, {"good"}, "coolant_sensor = 15"),
    Case("cranking", BAD, {"slow_starter"}, "starter = 0.8"),
    Case("cranking", BAD, {"slow_battery"}, start="battery = 0.5"),
    Case("cranking", ATTENTION, {"dip"}, start="battery = 0.8"),
    Case("cranking", ATTENTION, {"long"}, "fuel_drained = 16"),
    Case("cranking", GOOD, {"good"}, "leak = 4"),
    Case("idle", BAD, {"hunting"}, "idle_valve = 12"),
    Case("idle", ATTENTION, {"uneasy"}, "idle_valve = 10"),
    Case("idle", BAD, {"leak"}, "leak = 4"),
    Case("idle", BAD, {"meter"}, "air_meter = 0.8"),
    Case("idle", ATTENTION, {"little_air"}, "air_meter = 0.9\nalternator = 0"),
    Case("idle", ATTENTION, {"slow_idle", "passage"}, "idle_passage = 0.3"),
    Case("idle", ATTENTION, {"passage"}, "idle_passage = 0.45"),
    Case("idle", BAD, {"throttle_open"}, "throttle_stops = [1.2, 100]"),
    Case("idle", BAD, {"throttle_open"}, "throttle_stops = [2, 100]"),
    Case("idle", BAD, {"throttle_open"}, "throttle_stops = [3, 100]"),
    Case("idle", BAD, {"throttle_open"}, "throttle_stops = [5, 100]"),
    Case("idle", UNKNOWN, {"pedal"}, driver=RESTING),
    Case("idle", ATTENTION, {"coolant_sensor"}, "coolant_sensor = -40", driver=RAISED_LATE),
    Case(
        "idle", ATTENTION, {"coolant_sensor"}, "coolant_sensor = -30", "coolant = 95", RAISED_LATE
    ),
    Case("idle", UNKNOWN, {"cold"}, start="coolant = 30", driver=RAISED_LATE),
    Case("idle", UNKNOWN, {"cold"}, start="ambient = -25\ncoolant = 58", driver=RAISED_LATE),
    Case("idle", BAD, {"fast_idle", "leak"}, "leak = 12", driver=RAISED_LITTLE),
    Case("idle", GOOD, {"good"}, "alternator = 0"),
    Case("idle", GOOD, {"good"}, "leak = 1\nair_meter = 0.92"),
    Case("idle", GOOD, {"good"}, "air_meter = 1.08\ncoolant_sensor = -3\nidle_valve = 4"),
    Case("idle", GOOD, {"good"}, "idle_passage = 0.8", driver="consumers = 25\n" + RAISED),
    Case("knock", BAD, {"knock"}, "knock = 6"),
    Case("knock", ATTENTION, {"some_knock"}, "knock = 2"),
    Case("knock", BAD, {"no_control"}, faults="faults = [41]"),
    Case("knock", ATTENTION, {"idle_advance"}, "idle_advance = 1"),
    Case("throttle", BAD, {"dead_spot"}, "throttle_dead = [30, 45]"),
    Case("throttle", ATTENTION, {"not_full"}, "throttle_stops = [0, 88]"),
    Case("throttle", ATTENTION, {"not_closed"}, "throttle_stops = [3, 100]"),
    Case("throttle", ATTENTION, {"jump_down"}, driver=SLIPPED),
    Case("throttle", UNKNOWN, {"too_fast"}, driver=TOO_FAST),
    Case("throttle", BAD, {"air_falls"}, "air_meter_loose = [4, 5]"),
    Case("throttle", ATTENTION, {"air_implausible"}, "air_meter_zero = 6", "coolant = 40"),
    Case("throttle", GOOD, {"good"}, "leak = 4"),
    Case("warmup", BAD, {"open"}, "thermostat = 1"),
    Case("warmup", ATTENTION, {"cool"}, "thermostat = 0.3"),
    Case("warmup", BAD, {"hot"}, "radiator = 0"),
    Case("sensors", ATTENTION, {"apart"}, "coolant_sensor = 15"),
    Case("sensors", ATTENTION, {"apart"}, "coolant_sensor = -12"),
    Case("sensors", ATTENTION, {"somewhat_apart"}, "coolant_sensor = 6"),
    Case("sensors", BAD, {"throttle_open"}, "throttle_stops = [5, 100]"),
    Case("sensors", ATTENTION, {"flow"}, "air_meter_zero = 4"),
    Case("sensors", UNKNOWN, {"warm"}, start="coolant = 60"),
    Case("sensors", GOOD, {"good"}, "alternator = 0", "battery = 0.7"),
]
STANDING = {"warmup": {"slow", "not_driven"}}
"""Rules of a car that stands for long: the test of a warm-up that takes too long, and the next."""


def rows_of(
    test: str, condition: str = "", start: str = "", driver: str = "", faults: str = ""
) -> Iterator[Row]:
    drive = DRIVES[test]
    text = drive.scenario.format(
        start=start or drive.start, condition=condition, driver=driver or drive.driver
    )
    names = TESTS[test].channels
    return car_rows(f"{faults}\n{text}", names, drive.seconds, drive.rate)


@cache
def sound(test: str) -> tuple[Row, ...]:
    return tuple(rows_of(test))


def judged(test: str, rows: Iterable[Row]) -> TestResult:
    result = run(TESTS[test], rows)
    assert result is not None, "the steps were not found"
    return result


def rules(result: TestResult) -> set[str]:
    """Return the rules that hold: findings, and the reasons why nothing can be told."""
    found = {finding.rule for finding in result.findings}
    for rule in TESTS[result.test].rules:
        beginning = rule.text.en.split("{")[0]
        if rule.outcome is UNKNOWN and any(it.en.startswith(beginning) for it in result.missing):
            found.add(rule.name)
    return found


def test_every_rule_of_every_test_is_proven_here() -> None:
    assert load(shipped()).errors == ()
    assert set(DRIVES) == set(TESTS)
    for name, test in TESTS.items():
        ignition = {rule.name for rule in test.rules if rule.ignition_only}
        assert ignition <= {"good_ignition"}  # proven below
        proven = {"good", *ignition}.union(*(case.found for case in CASES if case.test == name))
        assert proven | STANDING.get(name, set()) == {rule.name for rule in test.rules}, name


@pytest.mark.parametrize("test", DRIVES)
def test_a_sound_car_is_good(test: str) -> None:
    result = judged(test, sound(test))
    assert result.outcome is GOOD, result.as_text().en
    assert rules(result) == {"good"}
    assert all(number.value is not None for number in result.numbers)
    assert read(result.as_json()) == result
    for language in result.as_text():
        assert "{" not in language


@pytest.mark.parametrize(
    "case", CASES, ids=lambda case: f"{case.test}-{'-'.join(sorted(case.found))}"
)
def test_a_fault_is_found_and_no_other(case: Case) -> None:
    result = judged(case.test, rows_of(case.test, *case[3:]))
    assert (result.outcome, rules(result)) == (case.outcome, case.found), result.as_text().en


def standing(start: str, condition: str, seconds: float) -> Iterator[Row]:
    """Yield rows of a car that idles: 40 seconds, then the last ten of them again and again."""
    text = WARM_UP.format(start=start, condition=condition, driver="speed = 0")
    rows = list(car_rows(text, TESTS["warmup"].channels, 40, 0.5))
    yield from rows
    last = rows[-5:]
    heat = [values["TWAT"] for _, values in last]
    assert max(heat) - min(heat) <= 1, "the car is not in a steady state"
    for lap in range(1, int((seconds - 40) / 10) + 1):
        yield from ((time + 10 * lap, values) for time, values in last)


def test_a_warm_up_that_takes_too_long_needs_attention() -> None:
    """In frost, with a thermostat that stays open; the drive is left out."""
    engine = TestEngine(TESTS["warmup"], shipped())
    for time, values in standing("ambient = -35\ncoolant = 61", "thermostat = 1", 1230):
        engine.add_row(time, values)
    assert engine.progress().step == 1
    engine.skip()
    assert engine.result is not None
    assert (engine.result.outcome, rules(engine.result)) == (ATTENTION, {"slow"})


def test_a_warm_up_without_a_drive_decides_nothing() -> None:
    result = judged("warmup", standing("ambient = 5\ncoolant = 69", "", 300))
    assert (result.outcome, rules(result)) == (UNKNOWN, {"not_driven"})


def without(rows: Iterable[Row], began: float, ended: float) -> Iterator[Row]:
    return (row for row in rows if not began <= row[0] < ended)


def lacking(rows: Iterable[Row], name: str) -> Iterator[Row]:
    return ((time, {n: v for n, v in values.items() if n != name}) for time, values in rows)


def test_a_gap_while_the_starter_turns_decides_nothing() -> None:
    rows = rows_of("charging", start="battery = 0.7")
    result = judged("charging", without(rows, 12.2, 13.6))
    assert (result.outcome, result.findings) == (UNKNOWN, ())
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
    result = run(TESTS[test], sound(test)[::every])
    assert result is None or (result.outcome, result.findings) == (UNKNOWN, ())


@pytest.mark.parametrize("test", DRIVES)
def test_a_missing_channel_never_makes_a_verdict(test: str) -> None:
    known = TESTS[test]
    formulas = [step.until for step in known.steps]
    judging = {name for rule in known.rules for name in rule.when.inputs}
    formulas += [each for name in judging for each in known.measures[name].formulas]
    for name in parameters_of(shipped(), formulas_inputs(formulas)):
        result = run(known, lacking(sound(test), name))
        assert result is None or result.outcome is UNKNOWN, name


@pytest.mark.parametrize(
    ("test", "rule"), [("idle", "good_ignition"), ("throttle", "good_ignition")]
)
def test_an_ignition_only_unit_is_not_blamed_for_its_dead_channels(test: str, rule: str) -> None:
    zeros = {name: float(shipped().parameter(name).decode(b"\0\0"[: size(name)])) for name in DEAD}
    rows = [
        (time, values | {n: zeros[n] for n in DEAD & values.keys()}) for time, values in sound(test)
    ]
    result = judged(test, rows)
    assert (result.outcome, rules(result)) == (GOOD, {rule}), result.as_text().en
    assert "ignition alone" in result.verdict.en


def size(name: str) -> int:
    return shipped().parameter(name).size


def test_a_dead_air_meter_alone_is_no_ignition_only_unit() -> None:
    rows = ((time, values | {"JAIR": 0.0}) for time, values in sound("idle"))
    result = judged("idle", rows)
    assert result.outcome is not GOOD
