"""The engine over rows made by hand: phases, holds and gaps, skipping, measures, doubt."""

from __future__ import annotations

from math import sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.catalog import shipped
from mikas.catalog.loading.source import parse_source
from mikas.guided.definition import Certainty, GuidedTest, VerdictKind
from mikas.guided.engine import ProgressPhase, TestEngine
from mikas.guided.loading import from_source
from mikas.guided.result import TestResult, read

FORM = """
title = "T"
finds = "F"
needs = "engine off"
start = "FREQ < 40"
minutes = 1
chart = ["UACC"]
[step.one]
text = "wait"
until = "UACC > 12"
hold = 2
timeout = 10
advice = "charge it"
watch = ["UACC"]
[step.two]
text = "rev"
until = "FREQ > 500"
whole = true
rate = 4
[measure.LOW]
step = "one"
of = "UACC"
statistic = "min"
text = "low"
{measures}
[rule.bad]
when = "LOW < 12.5"
verdict = "bad"
confidence = "high"
text = "only {{LOW}}"
[rule.good]
when = "LOW >= 12.5"
verdict = "good"
confidence = "high"
text = "fine"
"""


def made(measures: str = "", text: str = FORM) -> GuidedTest:
    return from_source(
        parse_source("t.toml", text.format(measures=measures).encode()), shipped(), own=True
    )


def measure(statistic: str, of: str = "FREQ", **keys: str) -> str:
    more = "\n".join(f"{key} = {value}" for key, value in keys.items())
    return f'[measure.M]\nstep="two"\nof="{of}"\nstatistic="{statistic}"\ntext="m"\n{more}\n'


def feed(engine: TestEngine, began: float, ended: float, rate: float = 10, **values: float) -> None:
    for number in range(round((ended - began) * rate)):
        engine.add_row(began + number / rate, values)


def finished(test: GuidedTest, voltage: float) -> TestResult:
    engine = TestEngine(test, shipped())
    feed(engine, 0, 4, UACC=voltage, FREQ=0)
    feed(engine, 4, 6, UACC=voltage, FREQ=800)
    assert engine.result is not None
    return engine.result


def test_a_step_waits_for_its_start_then_holds_and_ends() -> None:
    engine = TestEngine(made(), shipped())
    assert engine.progress().lacking == ("FREQ",)
    feed(engine, 0, 1, UACC=11, FREQ=800)
    assert (engine.progress().phase, engine.progress().step) == (ProgressPhase.START, None)
    feed(engine, 1, 3, UACC=11, FREQ=0)
    progress = engine.progress()
    assert (progress.phase, progress.step, progress.values) == (
        ProgressPhase.UNTIL,
        0,
        {"UACC": 11},
    )
    assert not progress.late
    feed(engine, 3, 14, UACC=11, FREQ=0)
    assert engine.progress().late
    feed(engine, 14, 15.5, UACC=12.6, FREQ=0)
    progress = engine.progress()
    assert (progress.phase, progress.hold) == (ProgressPhase.HOLD, 2)
    assert progress.held == pytest.approx(1.4)
    assert engine.progress(18.0).lacking == ("UACC",)
    feed(engine, 15.5, 17, UACC=12.6, FREQ=0)
    assert engine.progress().step == 1
    engine.add_row(17.0, {"UACC": 12.6, "FREQ": 800})
    result = engine.result
    assert result is not None
    assert (result.outcome, [step.name for step in result.steps]) == (
        VerdictKind.GOOD,
        ["one", "two"],
    )
    assert engine.progress().phase is ProgressPhase.DONE
    assert (result.began, result.ended) == (1.5, 17.0)


def test_a_gap_begins_the_hold_anew() -> None:
    engine = TestEngine(made(), shipped())
    feed(engine, 0, 2, UACC=12.1, FREQ=0)  # a low value before the gap is not measured
    feed(engine, 4, 5, UACC=12.8, FREQ=0)
    assert engine.progress().step == 0
    feed(engine, 5, 7, UACC=12.8, FREQ=0)
    assert engine.progress().step == 1
    engine.add_row(7, {"FREQ": 800})
    assert engine.result is not None
    assert engine.result.numbers[0].value == 12.8


def test_one_channel_a_row_is_enough() -> None:
    engine = TestEngine(made(), shipped())
    for number in range(60):
        time = number / 10
        engine.add_row(time, {"UACC": 12.8} if number % 2 else {"FREQ": 0.0 if time < 4 else 800.0})
    assert engine.result is not None
    assert engine.result.outcome is VerdictKind.GOOD


def test_a_clock_that_runs_back_ends_no_step() -> None:
    engine = TestEngine(made(), shipped())
    feed(engine, 100, 102, UACC=12.8, FREQ=0)
    feed(engine, 50, 51.5, UACC=12.8, FREQ=0)
    progress = engine.progress()
    assert (progress.step, progress.phase) == (0, ProgressPhase.HOLD)
    assert progress.held <= 1.5
    feed(engine, 51.6, 54, UACC=12.8, FREQ=0)
    feed(engine, 54.1, 56, UACC=12.9, FREQ=800)
    assert engine.result is not None
    assert (engine.result.began, engine.result.ended) == (50, pytest.approx(54.1))
    (curve,) = engine.result.curves
    assert curve.times == tuple(sorted(curve.times))


def test_a_skipped_step_can_not_be_good() -> None:
    test = made()
    engine = TestEngine(test, shipped())
    engine.skip()  # before the first step: nothing
    feed(engine, 0, 1, UACC=12.8, FREQ=0)
    engine.skip()
    assert engine.progress().step == 1
    engine.skip()
    assert engine.result is not None
    assert engine.result.outcome is VerdictKind.UNKNOWN
    assert [text.en for text in engine.result.missing] == ["low: the step was skipped"]
    assert engine.result.verdict.en.startswith("Can't tell")


@pytest.mark.parametrize(
    ("voltage", "outcome", "confidence"),
    [
        (12.0, None, None),
        (12.2, VerdictKind.BAD, Certainty.HIGH),
        (12.5, VerdictKind.GOOD, Certainty.MEDIUM),
        (12.8, VerdictKind.GOOD, Certainty.HIGH),
    ],
)
def test_a_value_beside_the_limit_is_less_sure(
    voltage: float, outcome: VerdictKind | None, confidence: Certainty | None
) -> None:
    if outcome is None:
        engine = TestEngine(made(), shipped())
        feed(engine, 0, 9, UACC=voltage, FREQ=0)
        assert engine.result is None
        return
    result = finished(made(), voltage)
    (finding,) = result.findings
    assert (result.outcome, finding.confidence) == (outcome, confidence)
    assert ("within one step of its channel (0.1 V)" in finding.doubt.en) is (voltage == 12.5)
    assert outcome is VerdictKind.GOOD or finding.text == ("only 12.2 V", "only 12,2 В")


@pytest.mark.parametrize(
    ("statistic", "of", "keys", "expected"),
    [
        ("min", "FREQ", {}, 0),
        ("max", "FREQ", {}, 520),
        ("max", "FREQ", {"last": "0.45"}, 520),
        ("min", "FREQ", {"last": "0.45"}, 360),
        ("mean", "FREQ", {}, 260),
        ("median", "FREQ", {"when": '"FREQ > 400"'}, 480),
        ("first", "FREQ + UACC * 0", {}, 0),
        ("last", "FREQ", {}, 520),
        ("slope", "FREQ", {}, 24_000),
        ("spread", "FREQ", {}, 520),
        ("percentile", "FREQ", {"percentile": "10"}, 52),
        ("jump", "FREQ", {}, 40),
        ("jump", "FREQ", {"when": '"FREQ < 200 or FREQ > 300"'}, 160),
        ("fall", "FREQ", {}, 0),
        ("fall", "0 - FREQ", {}, 520),
        ("fall", "FREQ", {"by": '"0 - FREQ"'}, 520),
        ("seconds", "FREQ > 120", {}, 0.9),
        ("share", "FREQ > 240", {}, 50),
        ("max", "SECONDS + FREQ * 0", {}, 1.4),
        ("max", "AIR_STROKE", {"when": '"FREQ > 500"', "fewest": "1"}, 12e6 / (520 * 120)),
        ("max", "FREQ", {"fewest": "15"}, None),
        ("max", "TWAT", {}, None),
    ],
)
def test_each_statistic_is_computed_over_the_step(
    statistic: str, of: str, keys: dict[str, str], expected: float | None
) -> None:
    engine = TestEngine(made(measure(statistic, of, **keys)), shipped())
    feed(engine, 0, 2.6, UACC=12.8, FREQ=0)
    assert engine.progress().step == 1
    for number in range(14):
        engine.add_row(2.6 + number / 10, {"FREQ": 40.0 * number, "UACC": 12.8, "JAIR": 12.0})
    assert engine.result is not None
    found = next(it for it in engine.result.numbers if it.name == "M")
    assert found.value == (None if expected is None else pytest.approx(expected))
    assert bool(found.why.en) is (expected is None)


@settings(max_examples=25)
@given(st.lists(st.floats(0, 30), max_size=60), st.floats(0.05, 3))
def test_any_rows_end_in_no_wrong_state(voltages: list[float], step: float) -> None:
    engine = TestEngine(made(), shipped())
    for number, voltage in enumerate(voltages):
        speed = 300 + 300 * sin(number)
        engine.add_row(number * step, {"UACC": voltage, "FREQ": speed if number > 20 else 0.0})
        progress = engine.progress()
        assert 0 <= progress.held <= progress.hold
    if engine.result is not None:
        assert read(engine.result.as_json()) == engine.result
        if engine.result.outcome is VerdictKind.GOOD:
            assert step <= 1.0


@pytest.mark.parametrize(
    ("until", "values", "unmet"),
    [
        ("FREQ > 500 and THR <= 5", {"FREQ": 800, "THR": 6}, [("THR", 6, "<=", 5)]),
        (
            "FREQ > 500 and 5 >= THR",
            {"FREQ": 400, "THR": 6},
            [("FREQ", 400, ">", 500), ("THR", 6, "<=", 5)],
        ),
        (
            "FREQ > 500 and THR <= 5 and RXX",
            {"FREQ": 800, "THR": 0, "RXX": 0},
            [("RXX", 0, "!=", 0)],
        ),
        ("not RXX", {"RXX": 1}, [("RXX", 1, "", None)]),
        ("TWAT >= 75 or SECONDS > 90", {"TWAT": 47}, [("TWAT", 47, ">=", 75)]),
        (
            "FREQ > 900 or (THR > 50 and FREQ > 400)",
            {"FREQ": 800, "THR": 6},
            [("FREQ", 800, ">", 900), ("THR", 6, ">", 50)],
        ),
        (
            "TWAT - TAIR < 3",
            {"TWAT": 30, "TAIR": 20},
            [("TWAT", 30, "", None), ("TAIR", 20, "", None)],
        ),
        ("FREQ > 500 and THR <= 5", {"FREQ": 800}, [("THR", None, "<=", 5)]),
    ],
)
def test_a_waiting_step_shows_the_unmet_conditions(until, values, unmet) -> None:
    text = FORM.replace('until = "UACC > 12"', f'until = "{until}"').replace(
        "FREQ < 40", "UACC > 0"
    )
    engine = TestEngine(made(text=text), shipped())
    feed(engine, 0, 2, UACC=12, **values)
    found = engine.progress().unmet
    assert [(it.name, it.value, it.sign, it.limit) for it in found] == unmet
    for it in found:
        for words in it.text:
            assert words
            assert "{" not in words


def test_the_wait_for_the_start_shows_value_and_limit() -> None:
    engine = TestEngine(made(), shipped())
    feed(engine, 0, 5, UACC=12, FREQ=840)
    progress = engine.progress()
    (unmet,) = progress.unmet
    assert progress.seconds == pytest.approx(4.9)
    assert (
        unmet.text.en.replace("\u00a0", " ")
        == "Crankshaft speed 840 rpm: less than 40 rpm is needed"
    )
    assert unmet.text.ru.replace("\u00a0", " ") == "Обороты 840 об/мин: нужно меньше 40 об/мин"
    feed(engine, 5, 6.5, UACC=12.6, FREQ=0)
    assert (engine.progress().phase, engine.progress().unmet) == (ProgressPhase.HOLD, ())
