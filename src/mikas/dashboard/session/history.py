"""The last hours of live values, for whoever looks later: a reload, a phone, the report.

Blocks of rows by time, a column a channel, 64-bit numbers: an hour at 35 sets a second of 30
channels is 30 MB. NaN is a value that did not come in that row; flags are 0 and 1. A block has the
channels of its time: a changed plan begins a new one.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isnan

import numpy as np
from numpy.typing import NDArray

Column = NDArray[np.float64]

_ROWS = 2048
LONGEST = 2 * 3600.0
_MOST_VALUES = 16_000_000  # 128 MB, whatever the rate: strokes at 6000 rpm with all channels


@dataclass(frozen=True, slots=True)
class Rows:
    """Columns over time."""

    times: Column
    values: dict[str, Column]

    def json_columns(self) -> dict[str, object]:
        """`{"names", "times", "values"}` as the API has it."""
        return {
            "names": list(self.values),
            "times": np.round(self.times, 6).tolist(),
            "values": [plain(column) for column in self.values.values()],
        }


class _Block:
    def __init__(self, names: tuple[str, ...]) -> None:
        self.names = names
        self.times = np.empty(_ROWS)
        self.values = np.empty((_ROWS, len(names)))
        self.count = 0

    def trim(self) -> int:
        """Lets go of the rows that were not used; returns how many values that is."""
        before = self.values.size
        if self.count < len(self.times):
            self.times = self.times[: self.count].copy()
            self.values = self.values[: self.count].copy()
        return before - self.values.size


class History:
    """Rows of the last `seconds`. Any thread may add or ask."""

    def __init__(self, seconds: float = LONGEST) -> None:
        self._seconds = seconds
        self._lock = threading.Lock()
        self._blocks: deque[_Block] = deque()
        self._held = 0

    def add(self, time: float, names: tuple[str, ...], row: Sequence[float]) -> None:
        """One row; `row` has a number or NaN for each of `names`."""
        with self._lock:
            block = self._blocks[-1] if self._blocks else None
            if block is None or block.names != names or block.count == _ROWS:
                if block is not None:
                    self._held -= block.trim()
                block = _Block(names)
                self._blocks.append(block)
                self._held += block.values.size
                self._forget(time)
            block.times[block.count] = time
            block.values[block.count] = row
            block.count += 1

    def rows(self, seconds: float, names: Sequence[str] | None = None) -> Rows:
        """The rows of the last `seconds`, of `names` or of every channel that had a turn."""
        with self._lock:
            blocks = [(b.names, b.times[: b.count], b.values[: b.count]) for b in self._blocks]
        if not blocks:
            return Rows(np.empty(0), {name: np.empty(0) for name in names or ()})
        since = blocks[-1][1][-1] - seconds
        kept = [
            (own, times[at:], values[at:])
            for own, times, values in blocks
            if (at := int(np.searchsorted(times, since))) < len(times)
        ]
        wanted = (
            tuple(names)
            if names is not None
            else tuple(dict.fromkeys(name for own, _, _ in reversed(kept) for name in own))
        )
        times = np.concatenate([times for _, times, _ in kept])
        columns = {name: np.full(len(times), np.nan) for name in wanted}
        start = 0
        for own, part, values in kept:
            for index, name in enumerate(own):
                if name in columns:
                    columns[name][start : start + len(part)] = values[:, index]
            start += len(part)
        return Rows(times, columns)

    def _forget(self, now: float) -> None:
        blocks = self._blocks
        while len(blocks) > 1 and (
            blocks[0].times[blocks[0].count - 1] < now - self._seconds or self._held > _MOST_VALUES
        ):
            self._held -= blocks.popleft().values.size


def decimated(rows: Rows, points: int) -> Rows:
    """At most about `points` rows, with each column's lowest and highest of every stretch kept.

    A stretch of rows becomes two, at its first and last time; in each column they hold the
    stretch's minimum and maximum, in the order in which they came. So a spike is never lost.
    """
    count, pairs = len(rows.times), max(1, points // 2)
    if count <= max(2, points):
        return rows
    edges = np.linspace(0, count, pairs + 1).astype(np.intp)
    starts = edges[:-1]
    times = np.empty(2 * pairs)
    times[0::2], times[1::2] = rows.times[starts], rows.times[edges[1:] - 1]
    return Rows(times, {name: _ends(column, starts) for name, column in rows.values.items()})


def _ends(column: Column, starts: NDArray[np.intp]) -> Column:
    missing = np.isnan(column)
    low = np.minimum.reduceat(np.where(missing, np.inf, column), starts)
    high = np.maximum.reduceat(np.where(missing, -np.inf, column), starts)
    stretch = np.repeat(np.arange(len(starts)), np.diff([*starts, len(column)]))
    first = np.full(len(starts), len(column))
    last = first.copy()
    for extreme, place in ((low, first), (high, last)):
        hits = np.flatnonzero(column == extreme[stretch])
        np.minimum.at(place, stretch[hits], hits)
    falls = last < first  # the highest came before the lowest
    ends = np.empty(2 * len(starts))
    ends[0::2], ends[1::2] = np.where(falls, high, low), np.where(falls, low, high)
    ends[~np.isfinite(ends)] = np.nan
    return ends


def plain(column: Column) -> list[float | int | None]:
    """For JSON: whole numbers as such, null for what did not come."""
    return [
        None if isnan(value) else int(value) if value.is_integer() else value
        for value in column.tolist()
    ]


def row_of(names: Sequence[str], values: Mapping[str, float]) -> list[float]:
    """`values` in the order of `names`, NaN where there is none."""
    nan = float("nan")
    return [values.get(name, nan) for name in names]
