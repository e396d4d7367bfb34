"""Order and places: sorting, searching, inserting, differences, sets, parts."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import Counter
from itertools import chain, pairwise
from math import nan
from typing import Any

from mikas.browser.arrays import kernels
from mikas.browser.arrays.creation import asarray, concatenate, is_scalar
from mikas.browser.arrays.dtypes import bool_, float64, int64, uint8
from mikas.browser.arrays.elementwise import equal, isnan, subtract
from mikas.browser.arrays.ndarray import ndarray, outside


def sort(values: Any) -> ndarray:  # noqa: ANN401  (an array)
    """Return the values, rising, NaN last."""
    source = asarray(values)
    found: ndarray = source.take(ndarray(kernels.rising(source.data), int64))
    return found


def searchsorted(values: Any, wanted: Any, side: str = "left") -> Any:  # noqa: ANN401  (as `wanted`)
    """Return where wanted values belong in rising ones: before equal ones, `right`: after them."""
    if side not in ("left", "right"):
        raise ValueError(f"side {side!r}")
    find, data = bisect_left if side == "left" else bisect_right, asarray(values).data
    if len(data) and data[-1] != data[-1]:
        outside("search among NaN")
    if is_scalar(wanted):
        if wanted != wanted:  # noqa: PLR0124
            outside("search for NaN")
        return find(data, wanted)
    others = asarray(wanted)
    if others.dtype is float64 and isnan(others).any():
        outside("search for NaN")
    return ndarray([find(data, each) for each in others.data], int64)


# numpy has it as a method, too; it is joined on here, as this module builds on `ndarray`.
ndarray.searchsorted = searchsorted  # type: ignore[attr-defined]


def diff(values: Any, prepend: Any = None) -> ndarray:  # noqa: ANN401  (an array, a number)
    """Return the differences of neighbours. `prepend`: a number before the first value."""
    source = asarray(values)
    if prepend is not None:
        source = concatenate([[prepend], source])
    data = source.data
    if source.dtype is bool_:
        later, before = ndarray(bytes(data[1:]), bool_), ndarray(bytes(data[:-1]), bool_)
        return later ^ before
    found: ndarray = subtract(ndarray(data[1:], source.dtype), ndarray(data[:-1], source.dtype))
    return found


def insert(values: Any, places: Any, more: Any) -> ndarray:  # noqa: ANN401  (arrays and numbers)
    """Return the values with others put before the places, which count in `values`."""
    source = asarray(values)
    at = [places] if is_scalar(places) else asarray(places).tolist()
    new = source.copy()._values(asarray(more), len(at))  # noqa: SLF001  (its own array)
    size = len(source)
    if any(not -size <= place <= size for place in at):
        raise IndexError("a place outside of the array")
    at = [place + size if place < 0 else place for place in at]
    pieces, done = [], 0
    for number in sorted(range(len(at)), key=at.__getitem__):
        pieces += [source.data[done : at[number]], new[number : number + 1]]
        done = at[number]
    merged = chain(*pieces, source.data[done:])
    return ndarray(bytes(merged) if source.dtype in (bool_, uint8) else list(merged), source.dtype)


def flatnonzero(values: Any) -> ndarray:  # noqa: ANN401  (an array)
    """Return the places of all values but zero."""
    found: ndarray = asarray(values).nonzero()[0]
    return found


def count_nonzero(values: Any) -> int:  # noqa: ANN401  (an array)
    """Return the number of values but zero."""
    return len(flatnonzero(values))


def unique(
    values: Any,  # noqa: ANN401  (an array)
    return_inverse: bool = False,
    return_counts: bool = False,
) -> Any:  # noqa: ANN401  (an array, or two)
    """Return the different values, rising, NaN once at the end; with the place of each value among
    them, or with how often they occur.
    """
    source = asarray(values)
    if source.dtype not in (float64, int64) or (return_inverse and return_counts):
        outside("unique of these")
    data = source.data
    counts: dict[Any, int] = Counter(data)
    lone = [each for each in counts if each != each]  # noqa: PLR0124  (each NaN object)
    missing = sum(counts.pop(each) for each in lone)
    different = sorted(counts)
    found = ndarray([*different, nan] if missing else different, source.dtype)
    if return_counts:
        often = [counts[each] for each in different] + ([missing] if missing else [])
        return found, ndarray(often, int64)
    if not return_inverse:
        return found
    places, last = {each: place for place, each in enumerate(different)}, len(different)
    return found, ndarray([places.get(each, last) for each in data], int64)  # NaN is the last


def bincount(values: Any, weights: Any = None) -> ndarray:  # noqa: ANN401  (arrays)
    """Return how often each whole number from 0 on occurs, or the sum of its weights."""
    numbers = asarray(values)
    if len(numbers) and numbers.dtype is not int64:
        raise TypeError("only whole numbers are counted")
    if len(numbers) and numbers.min() < 0:
        raise ValueError("a number below zero")
    size = numbers.max() + 1 if len(numbers) else 0
    if weights is None or not size:
        counts = Counter(numbers.data)
        return ndarray([counts[number] for number in range(size)], int64)
    sums = [0.0] * size
    for number, weight in zip(numbers.data, asarray(weights).data, strict=True):
        sums[number] += weight
    return ndarray(sums, float64)


def isin(values: Any, wanted: Any) -> ndarray:  # noqa: ANN401  (arrays)
    """Return which values are among the wanted ones."""
    source, known = asarray(values), asarray(wanted)
    if source.dtype is not int64 or (len(known) and known.dtype is not int64):
        outside("isin but of whole numbers")
    among = set(known.data)
    if not among:
        return ndarray(bytes(len(source)), bool_)  # the usual case, quick
    return ndarray(bytes([each in among for each in source.data]), bool_)


def setdiff1d(values: Any, without: Any) -> ndarray:  # noqa: ANN401  (arrays)
    """Return the different values that are not among the others, rising."""
    source = asarray(values)
    if source.dtype is not int64:
        outside("setdiff1d but of whole numbers")
    return ndarray(sorted(set(source.data).difference(asarray(without).data)), int64)


def array_equal(one: Any, other: Any, equal_nan: bool = False) -> bool:  # noqa: ANN401  (numpy's)
    """Return whether two arrays have the same values; `equal_nan`: NaN equals NaN."""
    a, b = asarray(one), asarray(other)
    if len(a) != len(b):
        return False
    same = equal(a, b)
    if equal_nan and a.dtype is float64 and b.dtype is float64:
        same = same | (isnan(a) & isnan(b))
    return bool(same.all())


def split(values: Any, places: Any) -> list[ndarray]:  # noqa: ANN401  (arrays)
    """Return the parts between the places."""
    source, edges = asarray(values), [0, *asarray(places).tolist(), len(values)]
    return [source[begin:end] for begin, end in pairwise(edges)]
