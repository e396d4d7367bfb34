"""Alarm limits as values: an existing one is a sound one."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.catalog import AlarmLimits, Confidence, Level
from mikas.errors import UsageError


def test_limits_are_listed_mildest_first() -> None:
    limits = AlarmLimits(1, 2, 3, 4)
    assert limits.lows == ((Level.WARNING, 2), (Level.DANGER, 1))
    assert limits.highs == ((Level.WARNING, 3), (Level.DANGER, 4))
    assert (limits.for_number, limits.for_flag) == (True, False)
    assert limits.confidence is Confidence.UNCONFIRMED


def test_limits_know_whether_they_fit_a_number_or_a_flag() -> None:
    assert not AlarmLimits().for_number
    assert not AlarmLimits().for_flag
    assert AlarmLimits(warning_low=1).for_number
    assert AlarmLimits(when_true=Level.DANGER).for_flag
    assert [str(level) for level in Level] == ["none", "warning", "danger"]


@pytest.mark.parametrize(
    ("limits", "problem"),
    [
        ({"warning_high": math.nan}, "warning_high is no finite number"),
        ({"danger_low": -math.inf}, "danger_low is no finite number"),
        ({"hysteresis": math.nan}, "hysteresis is no finite number"),
        ({"hysteresis": -0.1}, "hysteresis is below 0"),
        ({"warning_high": 2, "danger_high": 1}, "danger_high 1 must be above warning_high 2"),
        ({"danger_low": 2, "warning_low": 1}, "warning_low 1 must be above danger_low 2"),
        ({"danger_low": 2, "danger_high": 2},
         "danger_high 2 must be above danger_low 2 and the hysteresis"),
        ({"warning_low": 1, "danger_high": 2, "hysteresis": 1},
         "danger_high 2 must be above warning_low 1 and the hysteresis"),
    ],
)  # fmt: skip
def test_limits_out_of_order_are_refused(limits: dict[str, Any], problem: str) -> None:
    with pytest.raises(UsageError) as caught:
        AlarmLimits(**limits)
    assert caught.value.reason.en == problem
    assert caught.value.reason.ru.endswith(" с учётом hysteresis") == (
        problem.endswith(" and the hysteresis")
    )


def test_limits_of_one_side_may_be_equal() -> None:
    """Then danger comes at once; the hysteresis keeps low and high ones apart only."""
    assert AlarmLimits(warning_high=2, danger_high=2, hysteresis=1).highs[1] == (Level.DANGER, 2)
    assert AlarmLimits(danger_low=2, warning_low=2, hysteresis=1).lows[1] == (Level.DANGER, 2)


numbers = st.none() | st.integers(-5, 5).map(float)


@given(numbers, numbers, numbers, numbers, st.integers(0, 3))
def test_any_limits_are_in_order_or_refused(
    danger_low: float | None,
    warning_low: float | None,
    warning_high: float | None,
    danger_high: float | None,
    hysteresis: int,
) -> None:
    lows = [limit for limit in (danger_low, warning_low) if limit is not None]
    highs = [limit for limit in (warning_high, danger_high) if limit is not None]
    sound = [*lows, *highs] == sorted([*lows, *highs]) and (
        not lows or not highs or lows[-1] + hysteresis < highs[0]
    )
    try:
        AlarmLimits(danger_low, warning_low, warning_high, danger_high, hysteresis)
    except UsageError:
        assert not sound
    else:
        assert sound
