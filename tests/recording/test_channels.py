"""Rows without values in gaps: where they stand, and that nothing else changes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.recording.table.channels import Rows, calendar, with_gaps
from mikas.sampling.events import Gap


def rows(*times: float) -> Rows:
    return Rows(np.array(times, float), {"TWAT": np.array(times, float) + 100})


def gap(began: float, ended: float | None) -> Gap:
    return Gap(began, began=began, ended=ended)


def reported(stretches, events) -> list[tuple[float, float | None]]:
    return [
        (float(time), None if np.isnan(value) else float(value))
        for each in with_gaps(stretches, events)
        for time, value in zip(each.times, each.values["TWAT"], strict=True)
    ]


@pytest.mark.parametrize("stretches", [[rows(1, 2, 5, 6)], [rows(1, 2), rows(5, 6)]])
@pytest.mark.parametrize(("ended", "at"), [(5.0, 3.5), (4.0, 3.0), (9.0, 3.5), (None, 2.0)])
def test_a_gap_is_a_row_without_values_between_its_neighbours(stretches, ended, at):
    assert reported(stretches, [gap(2.0, ended)]) == [
        (1.0, 101.0), (2.0, 102.0), (at, None), (5.0, 105.0), (6.0, 106.0),
    ]  # fmt: skip


def test_a_gap_to_the_end_has_its_row_and_one_before_everything_has_none():
    assert reported([rows(1, 2)], [gap(0.0, 0.5), gap(2.0, 4.0)])[2:] == [(3.0, None)]
    assert reported([], [gap(0.0, 0.5)]) == []


def test_another_session_whose_times_run_back_keeps_its_own_gaps():
    came = reported([rows(10, 20), rows(1, 5)], [gap(1.0, 5.0), gap(10.0, 20.0)])
    assert [time for time, value in came if value is None] == [15.0, 3.0]


times = st.lists(st.integers(0, 200), max_size=30).map(sorted)


@given(st.lists(times, max_size=4), st.lists(st.tuples(st.integers(0, 200), st.integers(0, 50))))
def test_nothing_is_lost_and_times_rise_in_a_stretch(stretches, spans):
    given_rows = [rows(*each) for each in stretches]
    events = [gap(began, began + length) for began, length in spans]
    came = list(with_gaps(given_rows, events))
    for each in came:
        assert (np.diff(each.times) >= 0).all()
    kept = [time for each in came for time in each.times[~np.isnan(each.values["TWAT"])]]
    assert kept == [time for each in stretches for time in each]


@pytest.mark.parametrize("time", [0.0, 5.0, 1e15, 1.8e19, float("inf")])
def test_no_calendar_says_a_time_that_is_simulated_or_damaged(time):
    assert calendar(time) is None


def test_a_calendar_says_a_real_clocks_time():
    assert calendar(1_795_000_000.0).year == 2026
