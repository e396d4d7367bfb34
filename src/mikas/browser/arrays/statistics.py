"""Numbers that describe an array: the middle, quantiles, extremes without NaN."""

from __future__ import annotations

from collections.abc import Callable
from math import isnan, nan
from typing import Any

from mikas.browser.arrays import kernels
from mikas.browser.arrays.creation import asarray
from mikas.browser.arrays.dtypes import float64
from mikas.browser.arrays.ndarray import outside


def median(values: Any) -> float:  # noqa: ANN401  (an array)
    """Return the middle value, or the mean of the two in the middle; NaN if there is one."""
    data = _sorted(values)
    if not data:
        return nan
    middle = len(data) // 2
    return data[middle] if len(data) % 2 else (data[middle - 1] + data[middle]) / 2


def percentile(values: Any, share: float) -> float:  # noqa: ANN401  (an array)
    """Return the value that `share` percent do not exceed, between two values in proportion."""
    if not 0 <= share <= 100:
        raise ValueError("percentiles must be in the range [0, 100]")
    data = _sorted(values)
    if not data:
        raise IndexError("no percentile of no values")
    place = (len(data) - 1) * (share / 100)
    before = min(int(place), len(data) - 1)
    low, high, part = data[before], data[min(before + 1, len(data) - 1)], place - before
    return low + (high - low) * part if part < 0.5 else high - (high - low) * (1 - part)


def _sorted(values: Any) -> list[float]:  # noqa: ANN401  (an array)
    """Return the values, rising, as floats; only NaN if there is one."""
    data = asarray(values).astype(float64).data
    return [nan] if any(kernels.missing(data)) else sorted(data)


def _by_method(name: str) -> Callable[[Any], Any]:
    """Return the function of numpy that is a method of arrays as well."""
    return lambda values: getattr(asarray(values), name)()


mean, greatest, cumsum = map(_by_method, ("mean", "max", "cumsum"))


def nanmin(values: Any) -> float:  # noqa: ANN401  (an array)
    """Return the least value but NaN; NaN if there is no other."""
    return _extreme(values, min)


def nanmax(values: Any) -> float:  # noqa: ANN401  (an array)
    """Return the greatest value but NaN; NaN if there is no other."""
    return _extreme(values, max)


def nanargmin(values: Any) -> int:  # noqa: ANN401  (an array)
    """Return the place of the least value but NaN."""
    return _place(values, min)


def nanargmax(values: Any) -> int:  # noqa: ANN401  (an array)
    """Return the place of the greatest value but NaN."""
    return _place(values, max)


def _place(values: object, extreme: Callable[..., float]) -> int:
    found = _extreme(values, extreme)
    if isnan(found):
        raise ValueError("All-NaN slice encountered")
    place: int = asarray(values).data.index(found)
    return place


def _extreme(values: object, extreme: Callable[..., float]) -> float:
    source = asarray(values)
    if not len(source):
        raise ValueError("no extreme of no values")
    if source.dtype is not float64:
        outside(f"NaN in {source.dtype}")
    return extreme((x for x in source.data if x == x), default=nan)  # noqa: PLR0124  (all but NaN)
