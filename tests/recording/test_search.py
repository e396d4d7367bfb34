"""Search in a recording, against the same rule written row by row."""

from __future__ import annotations

from itertools import pairwise
from math import isnan, nan
from statistics import median

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.catalog import shipped
from mikas.errors import UnknownParameter, UsageError
from mikas.recording.search import PAUSE, Hit, SearchCondition
from mikas.recording.table.channels import Rows

CATALOG = shipped()


def condition(expression: str) -> SearchCondition:
    return SearchCondition(CATALOG, expression)


def rows(times, holds, peaks=None) -> Rows:
    columns = {"?": np.array(holds, float)}
    if peaks is not None:
        columns["?PEAK"] = np.array(peaks, float)
    return Rows(np.array(times, float), columns)


def row_by_row(table: list[tuple[float, float, float]], *, lowest: bool) -> list[Hit]:
    known = [row for row in table if not isnan(row[1])]
    steps = [later[0] - row[0] for row, later in pairwise(known)]
    usual = median([step for step in steps if step > 0] or [0.0])
    hits: list[list[tuple[float, float, float]]] = []
    before = None
    for row in known:
        is_next = (
            before is not None and before[1] and 0 <= row[0] - before[0] <= max(PAUSE, 2.5 * usual)
        )
        if row[1]:
            if is_next:
                hits[-1].append(row)
            else:
                hits.append([row])
        before = row
    found = []
    for hit in hits:
        peaks = [row for row in hit if not isnan(row[2])]
        best = (min if lowest else max)(peaks, key=lambda row: row[2], default=None)
        peak = (best[2], best[0]) if best else (None, None)
        found.append(Hit(hit[0][0], hit[-1][0], len(hit), *peak))
    return found


STEPS = st.sampled_from([0.03, 0.5, 1.9, 2.0, 2.1, 6.0, 0.0, -1000.0])
CELLS = st.sampled_from([nan, 0.0, 1.0, 1.0])
PEAKS = st.sampled_from([nan, -3.0, 0.0, 7.5])


@given(st.lists(st.tuples(STEPS, CELLS, PEAKS), max_size=40), st.integers(1, 40), st.booleans())
def test_hits_are_those_of_the_rule_row_by_row_however_the_table_is_cut(drawn, size, lowest):
    time, table = 1e6, []
    for step, holds, peak in drawn:
        time += step
        table.append((time, holds, peak))
    pieces = [table[at : at + size] for at in range(0, len(table), size)]
    found = condition("FREQ < 1" if lowest else "FREQ > 1").find(
        rows(*zip(*piece, strict=True)) for piece in pieces
    )
    assert found.hits == row_by_row(table, lowest=lowest)
    times = [row[0] for row in table]
    assert (found.begin, found.end) == (min(times, default=None), max(times, default=None))


@pytest.mark.parametrize(
    ("expression", "peak_of", "lowest"),
    [
        ("freq > 3000 and DET", "FREQ", False),
        ("DET or 3000 > Freq", "FREQ", True),
        ("Обороты > 3000 and детонация", "FREQ", False),
        ("max(JAIR, UGB) / FREQ <= 0.01", "max(JAIR, UGB) / FREQ", True),
        ("3 < 4 and TWAT != 85", "TWAT", False),
        ("not RXX", "", False),
        (f"max({','.join(['FREQ'] * 190)})>0", "", False),  # with its spaces over the limit
    ],
)
def test_the_peak_is_of_what_is_compared_first(expression, peak_of, lowest):
    it = condition(expression)
    assert it.peak_of == peak_of
    found = it.find([rows([1, 2], [1, 1], [5, 6])]) if peak_of else it.find([rows([1, 2], [1, 1])])
    assert [hit.peak for hit in found.hits] == [(5 if lowest else 6) if peak_of else None]


@pytest.mark.parametrize(
    "expression",
    ["FREQ >", "", "2 > 1", "FREQ > 3000 & DET", "__import__('os')", "1if FREQ else 0"],
)
def test_what_is_no_condition_is_said_with_its_subject(expression):
    with pytest.raises(UsageError, match="The condition "):
        condition(expression)


def test_a_name_that_does_not_exist_is_said_with_the_nearest():
    with pytest.raises(UnknownParameter, match="FREQ"):
        condition("FREK > 3000")
