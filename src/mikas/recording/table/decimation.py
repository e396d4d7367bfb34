"""Decimation: fewer rows for a picture, with the extremes of each column kept.

Time is cut into equal pieces. Of each piece every column keeps its least and its greatest value, in
their order, at the piece's first and last time: a spike stays. A piece without rows is one row
without values: a gap stays, too.

Over the stand-in for numpy in a browser a loop does the same, piece by piece.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import pairwise
from math import isnan, nan
from typing import TYPE_CHECKING

from mikas.recording.exchanges import has_whole_numpy
from mikas.recording.table.channels import Rows

if TYPE_CHECKING:
    from mikas.recording.exchanges.arrays import Floats, Index


def decimated(rows: Rows, points: int) -> Rows:
    """Return at most about `points` rows; `rows` itself, if there are no more."""
    if len(rows.times) <= max(2, points):
        return rows
    import numpy as np

    times = np.asarray(rows.times)
    pieces = Pieces(float(times[0]), float(times[-1]), max(1, points // 2))
    starts = pieces.starts(times)
    return pieces.extremes(
        times, starts, starts, rows.values, lambda name: np.asarray(rows.values[name])
    )


def _ends(piece: list[float]) -> tuple[float, float]:
    """Return the least and the greatest value, the earlier one first; NaN without values."""
    total = sum(piece)
    if total - total:  # a value is NaN or infinite
        piece = [value for value in piece if not isnan(value)]
    if not piece:
        return nan, nan
    least, greatest = min(piece), max(piece)
    if least < greatest and piece.index(least) > piece.index(greatest):
        return greatest, least
    return least, greatest


class Pieces:
    """`count` equal pieces of the time from `begin` to `end`, by numpy."""

    def __init__(self, begin: float, end: float, count: int) -> None:
        import numpy as np

        self._edges: Floats = np.linspace(begin, end, count + 1)[1:-1]
        self._middles: Floats = begin + (end - begin) * (np.arange(count) + 0.5) / count

    def starts(self, times: Floats) -> Index:
        """Return the index of each piece's first row, and the number of rows at the end."""
        import numpy as np

        return np.concatenate(([0], times.searchsorted(self._edges), [times.size]))

    def extremes(
        self,
        times: Floats,
        starts: Index,
        rows: Index,
        names: Iterable[str] | Mapping[str, object],
        column: Callable[[str], Floats],
    ) -> Rows:
        """Return the decimated rows.

        `times` and the values of each `column` may be extremes themselves: `starts` indexes these,
        `rows` indexes their original rows, which decide whether a piece is empty.
        """
        import numpy as np

        filled = np.diff(starts) > 0
        silent = ~filled & (np.diff(rows) == 0)
        shown = filled.astype(np.int64) * 2 + silent  # rows of each piece
        at = shown.cumsum() - shown
        first, last = starts[:-1][filled], starts[1:][filled] - 1
        kept = np.empty(int(shown.sum()))
        kept[at[silent]] = self._middles[silent]
        kept[at[filled]], kept[at[filled] + 1] = times[first], times[last]
        columns = {}
        for name in names:
            ends = np.full(kept.size, np.nan)
            ends[at[filled]], ends[at[filled] + 1] = extremes(column(name), first)
            columns[name] = ends
        return Rows(kept, columns)


def extremes(values: Floats, starts: Index) -> tuple[Floats, Floats]:
    """Return the least and the greatest of each piece of `values`, the earlier one first."""
    import numpy as np

    if not has_whole_numpy():
        every, edges = values.tolist(), [*starts.tolist(), values.size]
        ends = [_ends(every[start:stop]) for start, stop in pairwise(edges)]
        return np.array([end[0] for end in ends]), np.array([end[1] for end in ends])

    least, greatest = np.fmin.reduceat(values, starts), np.fmax.reduceat(values, starts)
    lengths = np.diff(np.append(starts, values.size))
    later = _place(values, least, starts, lengths) > _place(values, greatest, starts, lengths)
    return np.where(later, greatest, least), np.where(later, least, greatest)


def _place(values: Floats, wanted: Floats, starts: Index, lengths: Index) -> Index:
    """Return the first place of each piece's wanted value; `values.size` if it is missing."""
    import numpy as np

    places = np.where(values == np.repeat(wanted, lengths), np.arange(values.size), values.size)
    found: Index = np.minimum.reduceat(places, starts)
    return found
