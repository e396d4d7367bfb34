"""The rules by which a car stands out, or changes. Pure; docs/how-to/fleet.md has them in words.

All are robust: medians instead of means, so that one bad drive or one bad car decides nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
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


def outlier(value: float, others: Sequence[float], least: float) -> Outlier | None:
    """Return how a value stands out from those of the other cars; None: it does not, or there are
    too few of them.
    """
    if len(others) < FEWEST_OTHERS:
        return None
    middle = median(others)
    spread = _NORMAL * median(abs(each - middle) for each in others)
    if abs(value - middle) <= max(DEVIATIONS * spread, least):
        return None
    return Outlier(value, middle, min(others), max(others), len(others))


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
    pairs = [(a, b) for at, a in enumerate(series) for b in series[at + 1 :]]
    score = sum((b > a) - (b < a) for a, b in pairs)
    ties = [series.count(each) for each in set(series)]
    variance = count * (count - 1) * (2 * count + 5)
    variance -= sum(each * (each - 1) * (2 * each + 5) for each in ties)
    if not score or variance <= 0:
        return 0.0
    return (score - (1 if score > 0 else -1)) / sqrt(variance / 18)
