"""Statistics of one channel, exact for any number of values, and its envelope over time.

Values of one or two bytes repeat, so each is stored once with its count: ten hours need no more
memory than ten minutes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Column = NDArray[np.float64]

COLUMNS: Final = 256
_FIRST_WIDTH: Final = 0.02  # s; less than two responses are apart
_INSIDE: Final = 1e-9  # rounding error allowed at the edges of a band


@dataclass(frozen=True, slots=True)
class ChannelStatistics:
    """All but `mean` are values that occurred; 90 % lie between `low` and `high`. `inside`: the
    share of values within the reference; None without one.
    """

    count: int
    mean: float
    median: float
    low: float
    high: float
    least: float
    most: float
    inside: float | None = None


class ValueCounts:
    """Counts of the values of one channel, rounded to `places` (computed values have no steps)."""

    def __init__(self, places: int) -> None:
        self._places = places
        self.values: Column = np.empty(0)
        self.counts: NDArray[np.int64] = np.empty(0, np.int64)

    def add(self, column: Column) -> None:
        """Add values; NaN means missing."""
        if column.size:
            values, counts = np.unique(column[np.isfinite(column)], return_counts=True)
            self._merge(np.round(values, self._places), counts)

    def with_others(self, others: ValueCounts) -> ValueCounts:
        """Return the counts of both together."""
        both = ValueCounts(self._places)
        for each in (self, others):
            both._merge(each.values, each.counts)
        return both

    def _merge(self, values: Column, counts: NDArray[np.int64]) -> None:
        if values.size:
            both = np.concatenate((self.values, values))
            self.values, place = np.unique(both, return_inverse=True)
            weights = np.concatenate((self.counts, counts))
            self.counts = np.bincount(place, weights).astype(np.int64)

    def stats(self, reference: tuple[float, float] | None = None) -> ChannelStatistics | None:
        """Return the statistics; None without values."""
        count = int(self.counts.sum())
        if not count:
            return None
        return ChannelStatistics(
            count=count,
            mean=float((self.values * self.counts).sum() / count),
            median=self._ranked(0.5),
            low=self._ranked(0.05),
            high=self._ranked(0.95),
            least=float(self.values[0]),
            most=float(self.values[-1]),
            inside=None if reference is None else self._inside(*reference) / count,
        )

    def _ranked(self, share: float) -> float:
        """Return the quantile: the least value that `share` of all values do not exceed."""
        upto = np.cumsum(self.counts)
        rank = max(1, int(np.ceil(share * upto[-1])))
        return float(self.values[np.searchsorted(upto, rank)])

    def _inside(self, low: float, high: float) -> int:
        inside = (self.values >= low - _INSIDE) & (self.values <= high + _INSIDE)
        return int(self.counts[inside].sum())


def is_inside(value: float, band: tuple[float, float]) -> bool:
    """Return whether the value is in the band, edges included."""
    return band[0] - _INSIDE <= value <= band[1] + _INSIDE


class BlockTimes:
    """The times of a block of rows, for the envelopes of its channels: since `began`, and the
    columns that they are in, computed once for a width. Those before it are not `is_inside`.
    """

    def __init__(self, times: Column, began: float) -> None:
        self.is_inside: NDArray[np.bool_] = times >= began
        self.since: Column = np.maximum(times - began, 0.0)
        self._runs: dict[float, tuple[NDArray[np.intp], NDArray[np.intp]]] = {}

    def runs(self, width: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return where rows of one column begin, and in which column; they are far fewer."""
        if width not in self._runs:
            place = np.minimum((self.since / width).astype(np.intp), COLUMNS - 1)  # rounding
            begins = np.flatnonzero(np.diff(place, prepend=-1))
            self._runs[width] = begins, place[begins]
        return self._runs[width]


class Envelope:
    """Lowest and highest value of one channel per column of time; NaN: no values.

    A spike of one sample stays visible. When the columns are full, pairs of them are merged.
    """

    def __init__(self) -> None:
        self.width: float = _FIRST_WIDTH
        self.least: Column = np.full(COLUMNS, np.nan)
        self.most: Column = np.full(COLUMNS, np.nan)

    def add(self, times: BlockTimes, values: Column) -> None:
        """Add values; NaN and times before the beginning are ignored."""
        valid = np.isfinite(values) & times.is_inside
        if not valid.any():
            return
        last = times.since[valid].max()
        while last >= COLUMNS * self.width:
            self._halve()
        begins, place = times.runs(self.width)
        if not valid.all():
            values = np.where(valid, values, np.nan)
        np.fmin.at(self.least, place, np.fmin.reduceat(values, begins))
        np.fmax.at(self.most, place, np.fmax.reduceat(values, begins))

    def _halve(self) -> None:
        self.width *= 2
        rest = np.full(COLUMNS // 2, np.nan)
        self.least = np.concatenate((np.fmin(self.least[::2], self.least[1::2]), rest))
        self.most = np.concatenate((np.fmax(self.most[::2], self.most[1::2]), rest))

    @property
    def middles(self) -> Column:
        """The time of each column, in seconds since the beginning."""
        return (np.arange(COLUMNS) + 0.5) * np.float64(self.width)
