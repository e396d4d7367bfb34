"""Setting CO: cars made by hypothesis, in which a step of RCOD does more, less, or the opposite."""

from __future__ import annotations

from math import exp

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.guided.co_setting import (
    FARTHEST,
    LONGEST_STEP,
    MOST_WRITES,
    CoOutcome,
    CoSetting,
    CoStep,
    MixtureMeter,
)


def co_of(lambda_):
    """About what an analyser shows; a rich mixture has 2.5 % more for each 0.1 of λ."""
    return (
        0.3 + 0.6 * exp((0.99 - lambda_) * 25) if lambda_ > 0.96 else 1.57 + (0.96 - lambda_) * 30
    )


def adjusted(setting, shown):
    """Every step until the end; `shown`: the meter's figure by the byte."""
    steps: list[CoStep] = []
    while not steps or steps[-1].outcome is CoOutcome.WRITE:
        steps.append(setting.next(shown(setting.raw)))
        assert len(steps) <= MOST_WRITES + 1
    return steps


@given(
    found=st.integers(40, 215),
    lambda_found=st.floats(0.94, 1.02),
    goal=st.floats(0.95, 1.01),
    strength=st.floats(0.5, 2.0),
    sign=st.sampled_from([1, -1]),
)
def test_a_lambda_meter_ends_in_the_band_whatever_a_step_does(
    found, lambda_found, goal, strength, sign
):
    def shown(raw):
        return round(lambda_found - sign * strength * (raw - found) / 256, 3)

    setting = CoSetting(found, goal, 0.015, MixtureMeter.LAMBDA)
    steps = adjusted(setting, shown)
    needed = abs(lambda_found - goal) * 256 / strength
    if needed < FARTHEST - 1:
        assert steps[-1].outcome is CoOutcome.SET
        assert abs(shown(setting.raw) - goal) <= 0.015
        assert sum(step.turned for step in steps) == (sign < 0 and len(steps) > 1)
    assert len(steps) <= 9


@given(st.floats(0.9, 1.0), st.floats(0.5, 4.0), st.integers(60, 200), st.sampled_from([1, -1]))
def test_an_analyser_ends_in_the_band_or_says_why_not(lambda_found, goal, found, sign):
    def shown(raw):
        return round(co_of(lambda_found - sign * (raw - found) / 256), 2)

    setting = CoSetting(found, goal, 0.2)
    last = adjusted(setting, shown)[-1]
    if last.outcome is CoOutcome.SET:
        assert abs(shown(setting.raw) - goal) <= 0.2
    else:
        assert (last.outcome, last.raw) == (CoOutcome.STOP, found)


@given(
    st.integers(0, 255),
    st.floats(0.1, 5.0),
    st.lists(st.floats(0, 15), min_size=MOST_WRITES + 2, max_size=MOST_WRITES + 2),
)
def test_whatever_the_meter_shows_the_byte_stays_near_and_it_ends(found, goal, figures):
    setting = CoSetting(found, goal, 0.1)
    raw = found
    for figure in figures:
        step = setting.next(figure)
        if step.outcome is not CoOutcome.WRITE:
            break
        assert 0 <= step.raw <= 255
        assert abs(step.raw - found) <= FARTHEST
        assert 1 <= abs(step.raw - raw) <= LONGEST_STEP
        raw = step.raw
    assert step.outcome is not CoOutcome.WRITE
    assert step.raw == (raw if step.outcome is CoOutcome.SET else found)


def test_a_figure_that_does_not_follow_stops_it_and_the_found_byte_comes_back():
    steps = adjusted(CoSetting(128, 1.0, 0.2), lambda raw: 3.0)
    assert [step.outcome for step in steps] == ["write", "write", "stop"]
    assert steps[-1].raw == 128
    assert "does not follow RCOD" in steps[-1].why.en


def test_a_figure_far_off_stops_at_the_bound():
    steps = adjusted(CoSetting(128, 0.5, 0.2), lambda raw: 12.0 - (128 - raw) * 0.11)
    assert steps[-1].outcome is CoOutcome.STOP
    assert "more than 32 steps" in steps[-1].why.en
    assert min(step.raw for step in steps) == 128 - FARTHEST


@pytest.mark.parametrize("found", [0, 255])
def test_the_end_of_the_byte_is_a_bound_too(found):
    goal = 0.5 if found == 0 else 5.0
    step = CoSetting(found, goal, 0.2).next(3.0)
    assert (step.outcome, step.raw) == (CoOutcome.STOP, found)


def test_a_figure_in_the_band_changes_nothing():
    step = CoSetting(128, 0.8, 0.2).next(0.95)
    assert (step.outcome, step.raw) == (CoOutcome.SET, 128)
