"""How the values of one channel are spread: exactly, however many there are.

Values come from one or two bytes, so that few of them differ: each is kept once, with how often it
came. Ten hours need no more memory than ten minutes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Column = NDArray[np.float64]

_INSIDE: Final = 1e-9  # what rounding may add to a value that lies on the edge of its band


@dataclass(frozen=True, slots=True)
class Stats:
    """What a channel did. Save `mean`, each is a value that came; `low` to `high` holds 90 % of
    them. `inside`: the share of the values within the reference; None without one.
    """

    count: int
    mean: float
    median: float
    low: float
    high: float
    least: float
    most: float
    inside: float | None = None


class Spread:
    """The values of one channel so far, rounded to `places` (what is computed has no steps)."""

    def __init__(self, places: int) -> None:
        self._places = places
        self._values: Column = np.empty(0)
        self._counts: NDArray[np.int64] = np.empty(0, np.int64)

    def add(self, column: Column) -> None:
        """More values; NaN is missing."""
        came, counts = np.unique(
            np.round(column[np.isfinite(column)], self._places), return_counts=True
        )
        if came.size:
            both = np.concatenate((self._values, came))
            self._values, place = np.unique(both, return_inverse=True)
            weights = np.concatenate((self._counts, counts))
            self._counts = np.bincount(place, weights).astype(np.int64)

    def stats(self, reference: tuple[float, float] | None = None) -> Stats | None:
        """What is known of them; None if none came."""
        count = int(self._counts.sum())
        if not count:
            return None
        return Stats(
            count=count,
            mean=float((self._values * self._counts).sum() / count),
            median=self._ranked(0.5),
            low=self._ranked(0.05),
            high=self._ranked(0.95),
            least=float(self._values[0]),
            most=float(self._values[-1]),
            inside=None if reference is None else self._inside(*reference) / count,
        )

    def _ranked(self, share: float) -> float:
        """The least value that at least so large a share of all does not exceed."""
        upto = np.cumsum(self._counts)
        rank = max(1, int(np.ceil(share * upto[-1])))
        return float(self._values[np.searchsorted(upto, rank)])

    def _inside(self, low: float, high: float) -> int:
        there = (self._values >= low - _INSIDE) & (self._values <= high + _INSIDE)
        return int(self._counts[there].sum())


def is_inside(value: float, band: tuple[float, float]) -> bool:
    """Whether it is in the band, the edges included."""
    return band[0] - _INSIDE <= value <= band[1] + _INSIDE
