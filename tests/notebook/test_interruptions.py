"""Where a line is interrupted: gaps, missing values, and neither between two usual values."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mikas.i18n import Text
from mikas.notebook.interruptions import (
    broken,
    interruptions,
    longest_interval,
    reasons_of_gaps,
)
from mikas.sampling.events import SLEPT, Gap, LineState, StateChanged

WHY, SILENT = Text("why", "почему"), Text("silent", "молчит")

times = st.lists(st.integers(0, 4000), unique=True, max_size=40).map(
    lambda all_: np.array(sorted(all_), dtype=float) / 4
)
spans = st.lists(st.tuples(st.integers(0, 1000), st.integers(0, 40)), max_size=8).map(
    lambda all_: [(float(begin), float(begin + length)) for begin, length in all_]
)


def test_a_line_is_interrupted_after_a_few_of_its_usual_intervals():
    assert longest_interval(np.arange(10) / 10) == 0.5  # never less: short pauses of the line
    assert longest_interval(np.arange(10) * 2.0) == 10
    assert longest_interval(np.array([0.0, 1.0])) == 3
    steady = np.concatenate([np.arange(20.0), 60 + np.arange(20.0)])
    assert interruptions(steady) == [(19.0, 60.0)]
    assert interruptions(np.arange(20.0)) == []


def test_spans_that_overlap_are_one():
    assert interruptions(np.arange(4.0), [(1.2, 1.4), (1.3, 2.6), (5, 6)]) == [(1.2, 2.6), (5, 6)]


@given(times, spans)
def test_a_line_is_broken_exactly_where_a_span_lies_between_two_points(times, gaps):
    values = np.arange(times.size, dtype=float)
    united = interruptions(times, gaps)
    assert all(one[1] < two[0] for one, two in pairwise(united))
    at, shown = broken(times, values, united)
    assert (np.diff(at) >= 0).all()
    np.testing.assert_array_equal(at[np.isfinite(shown)], times)
    for place in range(times.size - 1):
        begin, end = times[place], times[place + 1]
        is_cut = any(span[1] > begin and span[0] < end for span in united)
        between = shown[(at >= begin) & (at <= end)]
        assert np.isnan(between).any() >= is_cut
        after = int(np.flatnonzero(shown == place)[0]) + 1
        assert np.isnan(shown[after]) == is_cut


def test_a_gap_has_the_state_of_the_line_in_it_or_else_its_own_reason():
    events = [
        StateChanged(1.5, LineState.ECHO_ONLY, reason=SILENT),
        Gap(1.0, 1.0, 2.0, WHY),
        StateChanged(2.5, LineState.SAMPLING),
        Gap(4.0, 4.0, 5.0, WHY),
        StateChanged(5.2, LineState.ECHO_ONLY, reason=SILENT),
        Gap(5.1, 5.1, 5.5, SLEPT),
        Gap(6.0, 6.0, None, None),
    ]
    found = [reason for _, reason in reasons_of_gaps(events)]
    assert found == [LineState.ECHO_ONLY.text, WHY, SLEPT, None]


def test_a_gap_that_a_session_ended_in_has_no_reason_of_the_next_session():
    lost = StateChanged(50.0, LineState.NO_PORT, reason=SILENT, recording=1)
    silent = StateChanged(5.0, LineState.ECHO_ONLY, reason=SILENT)
    first, second = Gap(4.0, 4.0, None), Gap(49.0, 49.0, None, recording=1)
    found = [reason for _, reason in reasons_of_gaps([first, silent, second, lost])]
    assert found == [LineState.ECHO_ONLY.text, LineState.NO_PORT.text]
    assert [reason for _, reason in reasons_of_gaps([first, lost])] == [None]
