"""A channel's course in a few hundred columns, each with the least and the greatest value in it.

A spike of one sample stays visible, and the recording may be of any length: when the columns do not
reach any more, two become one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Column = NDArray[np.float64]

COLUMNS: Final = 256
_FIRST_WIDTH: Final = 0.02  # s; less than two responses are apart


class Curve:
    """The course of one channel since `began`. Columns that nothing fell into are NaN."""

    def __init__(self, began: float) -> None:
        self.began = began
        self.width = _FIRST_WIDTH
        self.least: Column = np.full(COLUMNS, np.nan)
        self.most: Column = np.full(COLUMNS, np.nan)

    def add(self, times: Column, values: Column) -> None:
        """More of it; NaN is missing, and so is what was before `began`."""
        there = np.isfinite(values) & (times >= self.began)
        times, values = times[there], values[there]
        if not times.size:
            return
        while times.max() - self.began >= COLUMNS * self.width:
            self._halve()
        place = ((times - self.began) / self.width).astype(np.intp)
        place = np.minimum(place, COLUMNS - 1)  # what rounding may add
        np.fmin.at(self.least, place, values)
        np.fmax.at(self.most, place, values)

    def _halve(self) -> None:
        self.width *= 2
        rest = np.full(COLUMNS // 2, np.nan)
        self.least = np.concatenate((np.fmin(self.least[::2], self.least[1::2]), rest))
        self.most = np.concatenate((np.fmax(self.most[::2], self.most[1::2]), rest))

    @property
    def middles(self) -> Column:
        """The time of each column, in seconds since `began`."""
        return (np.arange(COLUMNS) + 0.5) * np.float64(self.width)
