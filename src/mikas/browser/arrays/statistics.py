"""Numbers that describe an array: the middle, quantiles, extremes without NaN."""

from __future__ import annotations

from math import nan
from typing import Any

from mikas.browser.arrays import kernels
from mikas.browser.arrays.creation import asarray
from mikas.browser.arrays.dtypes import float64
from mikas.browser.arrays.ndarray import ndarray, outside


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


def mean(values: Any) -> float:  # noqa: ANN401  (an array)
    """Return the mean; NaN without values."""
    found: float = asarray(values).mean()
    return found


def greatest(values: Any) -> Any:  # noqa: ANN401  (an array, a number)
    """Return the greatest value; NaN if there is one."""
    return asarray(values).max()


def cumsum(values: Any) -> ndarray:  # noqa: ANN401  (an array)
    """Return the sums so far."""
    found: ndarray = asarray(values).cumsum()
    return found


def nanmin(values: Any) -> float:  # noqa: ANN401  (an array)
    """Return the least value but NaN; NaN if there is no other."""
    place = _extreme(values, least=True)
    return nan if place is None else asarray(values)[place]


def nanmax(values: Any) -> float:  # noqa: ANN401  (an array)
    """Return the greatest value but NaN; NaN if there is no other."""
    place = _extreme(values, least=False)
    return nan if place is None else asarray(values)[place]


def nanargmin(values: Any) -> int:  # noqa: ANN401  (an array)
    """Return the place of the least value but NaN."""
    return _place(values, least=True)


def nanargmax(values: Any) -> int:  # noqa: ANN401  (an array)
    """Return the place of the greatest value but NaN."""
    return _place(values, least=False)


def _place(values: Any, *, least: bool) -> int:  # noqa: ANN401  (an array)
    place = _extreme(values, least=least)
    if place is None:
        raise ValueError("All-NaN slice encountered")
    return place


def _extreme(values: Any, *, least: bool) -> int | None:  # noqa: ANN401  (an array)
    source = asarray(values)
    if not len(source):
        raise ValueError("no extreme of no values")
    if source.dtype is not float64:
        outside(f"NaN in {source.dtype}")
    present = [x for x in source.data if x == x]  # noqa: PLR0124
    if not present:
        return None
    extreme = min(present) if least else max(present)
    place: int = source.data.index(extreme)
    return place
