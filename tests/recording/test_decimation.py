"""Fewer rows for a picture: every extreme and every gap stays, as piece by piece in a loop."""

from __future__ import annotations

from bisect import bisect_left
from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mikas.recording.table.channels import Rows
from mikas.recording.table.decimation import decimated

NAN = float("nan")
COLUMN = st.lists(st.one_of(st.just(NAN), st.integers(-1000, 1000).map(float)), min_size=1)


@given(COLUMN, st.integers(2, 40))
def test_decimation_keeps_every_extreme_and_invents_nothing(values, points):
    rows = Rows(np.arange(len(values), dtype=float), {"A": np.array(values)})
    shown = decimated(rows, points)
    assert len(shown.times) <= max(points, 2)
    assert (np.diff(shown.times) >= 0).all()
    there = [value for value in values if value == value]
    kept = [value for value in shown.values["A"].tolist() if value == value]
    assert set(kept) <= set(there)
    if there:
        assert (min(kept), max(kept)) == (min(there), max(there))
        assert all(np.diff([shown.times[0], shown.times[-1]]) <= len(values))


def test_the_order_of_a_rise_and_a_fall_stays():
    rows = Rows(np.arange(8.0), {"A": np.array([0, 9, 1, 1, 9, 0, 5, 5.0])})
    assert decimated(rows, 4).values["A"].tolist() == [0, 9, 9, 0]


def test_a_column_without_values_stays_empty():
    rows = Rows(np.arange(100.0), {"A": np.full(100, NAN), "B": np.arange(100.0)})
    shown = decimated(rows, 10)
    assert np.isnan(shown.values["A"]).all()
    assert shown.values["B"][-1] == 99


def test_few_rows_are_shown_as_they_are():
    rows = Rows(np.arange(3.0), {"A": np.array([1, NAN, 2.5])})
    assert decimated(rows, 3) is rows


def test_a_piece_of_time_without_rows_is_a_row_without_values():
    times = np.concatenate((np.arange(50.0), 200 + np.arange(50.0)))
    shown = decimated(Rows(times, {"A": np.ones(100)}), 20)
    silent = np.isnan(shown.values["A"])
    assert ((shown.times[silent] > 49) & (shown.times[silent] < 200)).all()
    assert silent.any()


def decimated_in_a_loop(rows, points):
    times, count = rows.times, max(1, points // 2)
    begin, end = float(times[0]), float(times[-1])
    edges = (begin + number * ((end - begin) / count) for number in range(1, count))
    starts = [0, *(bisect_left(times, edge) for edge in edges), len(times)]
    kept, values = [], {name: [] for name in rows.values}
    for number, (start, stop) in enumerate(pairwise(starts)):
        if start == stop:
            kept.append(begin + (end - begin) * (number + 0.5) / count)
        else:
            kept += [float(times[start]), float(times[stop - 1])]
        for name, column in rows.values.items():
            piece = [float(value) for value in column[start:stop]]
            values[name] += ends(piece) if piece else [NAN]
    return Rows(kept, values)


def ends(piece):
    """The least and the greatest value, the earlier one first; NaN without values."""
    piece = [value for value in piece if value == value]
    if not piece:
        return [NAN, NAN]
    least, greatest = min(piece), max(piece)
    both = [least, greatest]
    return both if piece.index(least) <= piece.index(greatest) else both[::-1]


@given(COLUMN, st.integers(2, 40), st.randoms())
def test_a_loop_over_the_pieces_comes_to_the_same(column, points, random):
    times = np.cumsum([random.choice([0.0, 0.03, 0.03, 5.0]) for _ in column])
    rows = Rows(times, {"A": np.array(column), "B": np.array(column[::-1])})
    if len(column) <= max(2, points):
        return
    fast, plain = decimated(rows, points), decimated_in_a_loop(rows, points)
    np.testing.assert_array_equal(fast.times, plain.times)
    for name in ("A", "B"):
        np.testing.assert_array_equal(fast.values[name], plain.values[name])
