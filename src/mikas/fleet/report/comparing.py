"""The rules by which a car stands out, or changes. Pure; docs/how-to/fleet.md has them in words.

All are robust: medians instead of means, so that one bad drive or one bad car decides nothing.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right, insort
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import sqrt
from statistics import median
from typing import Final

LATEST: Final = 5  # drives whose median is the car's value
FEWEST_DRIVES: Final = 3  # with a value, for the car to have one
FEWEST_OTHERS: Final = 4  # cars with a value, to compare one with
DEVIATIONS: Final = 3.5  # standard deviations from the others, by their MAD
FEWEST_OF_TREND: Final = 8  # drives with a value
CERTAIN: Final = 3.29  # of Mann and Kendall's Z: chance does that once in a thousand
ENDS: Final = 3  # drives at each end of a trend
_NORMAL: Final = 1.4826  # standard deviations in a MAD, of normally distributed values


@dataclass(frozen=True, slots=True)
class Outlier:
    """A car's value against those of the others: their median, lowest and highest, their number."""

    value: float
    others: float
    low: float
    high: float
    count: int


@dataclass(frozen=True, slots=True)
class Trend:
    """A change over the drives: the median of the first three and of the last three."""

    first: float
    last: float
    count: int


def value_of(series: Sequence[float]) -> float | None:
    """Return a car's value: the median of its latest drives; None of too few drives."""
    return median(series[-LATEST:]) if len(series) >= FEWEST_DRIVES else None


class Peers:
    """The values of all cars. Any number of them are compared, each with the others."""

    def __init__(self, values: Iterable[float]) -> None:
        self._values = sorted(values)
        self._deviations: dict[float, list[float]] = {}  # by the others' median: few are different

    def outlier(self, value: float, least: float) -> Outlier | None:
        """Return how one of the values stands out from the others; None: it does not, or there are
        too few of them.
        """
        values, count = self._values, len(self._values) - 1
        if count < FEWEST_OTHERS:
            return None
        middle = _median_without(values, value)
        if middle not in self._deviations:
            self._deviations[middle] = sorted(abs(each - middle) for each in values)
        spread = _NORMAL * _median_without(self._deviations[middle], abs(value - middle))
        if abs(value - middle) <= max(DEVIATIONS * spread, least):
            return None
        low, high = values[value == values[0]], values[-2 if value == values[-1] else -1]
        return Outlier(value, middle, low, high, count)


def _median_without(values: Sequence[float], value: float) -> float:
    """Return the median of sorted values without one of them."""
    place, count = bisect_left(values, value), len(values) - 1
    low, high = ((count - 1) // 2, count // 2)
    return (values[low + (low >= place)] + values[high + (high >= place)]) / 2


def trend(series: Sequence[float], least: float) -> Trend | None:
    """Return a lasting change over the drives, in their order; None: none is certain."""
    count = len(series)
    if count < FEWEST_OF_TREND:
        return None
    first, last = median(series[:ENDS]), median(series[-ENDS:])
    if abs(last - first) < least or abs(_mann_kendall(series)) < CERTAIN:
        return None
    return Trend(first, last, count)


def _mann_kendall(series: Sequence[float]) -> float:
    """Return Z of the test of Mann and Kendall, with its correction for equal values."""
    count = len(series)
    score, before = 0, list[float]()  # sorted, so a car of many years takes no time
    for value in series:
        score += bisect_left(before, value) - (len(before) - bisect_right(before, value))
        insort(before, value)
    ties = Counter(series).values()
    variance = count * (count - 1) * (2 * count + 5)
    variance -= sum(each * (each - 1) * (2 * each + 5) for each in ties)
    if not score or variance <= 0:
        return 0.0
    return (score - (1 if score > 0 else -1)) / sqrt(variance / 18)
