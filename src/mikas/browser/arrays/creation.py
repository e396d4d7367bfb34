"""New arrays: of values, of one value, of several arrays."""

from __future__ import annotations

from array import array as machine_array
from collections.abc import Sequence
from itertools import chain
from itertools import repeat as repeated
from math import ceil
from typing import Any, Final

from mikas.browser.arrays.dtypes import (
    bool_,
    dtype_of,
    float64,
    int16,
    int32,
    int64,
    kept,
    object_,
    one,
    promoted,
    scalar_type,
    uint8,
)
from mikas.browser.arrays.ndarray import ndarray, outside

_OF_MACHINE: Final = {"d": float64, "q": int64, "B": uint8, "h": int16, "i": int32}
_BYTES: Final = (bool_, uint8)


def is_scalar(given: object) -> bool:
    """Return whether `given` is a single number."""
    return isinstance(given, (int, float))


def asarray(given: Any, dtype: object = None) -> Any:  # noqa: ANN401  (an array; a number of one)
    """Return `given` as an array; itself if it is one of that type. A number stays one."""
    wanted = None if dtype is None else dtype_of(dtype)
    if isinstance(given, ndarray):
        return given if wanted in (None, given.dtype) else given.astype(wanted)
    if is_scalar(given):
        return given if wanted is None else one(given, wanted)
    return array(given, wanted)


def array(given: Any, dtype: object = None) -> ndarray:  # noqa: ANN401  (a sequence of numbers)
    """Return a new array of the values."""
    wanted = None if dtype is None else dtype_of(dtype)
    if isinstance(given, ndarray):
        return given.copy() if wanted is None else given.astype(wanted)
    if isinstance(given, machine_array):
        of = _OF_MACHINE[given.typecode]
        values = ndarray(given.tobytes() if of is uint8 else given.tolist(), of)
        return values if wanted in (None, of) else values.astype(wanted)
    if not isinstance(given, (list, tuple, range)):
        outside(f"array of {type(given).__name__}")
    return ndarray(*kept(given, wanted))


def frombuffer(given: Any, dtype: object) -> ndarray:  # noqa: ANN401  (bytes)
    """Return bytes as an array."""
    if dtype_of(dtype) is not uint8:
        outside("frombuffer but of bytes")
    return ndarray(bytes(given), uint8)


def full(count: int, value: Any, dtype: object = None) -> ndarray:  # noqa: ANN401  (a number)
    """Return `count` times the value."""
    of = scalar_type(value) if dtype is None else dtype_of(dtype)
    single = one(value, of)
    return ndarray(bytes([single]) * count if of in _BYTES else [single] * count, of)


def zeros(count: int, dtype: object = float64) -> ndarray:
    """Return `count` zeros."""
    return full(count, 0, dtype)


def ones(count: int, dtype: object = float64) -> ndarray:
    """Return `count` ones."""
    return full(count, 1, dtype)


def empty(count: int, dtype: object = float64) -> ndarray:
    """Return `count` values to be set; zeros."""
    return ndarray([None] * count, object_) if dtype_of(dtype) is object_ else zeros(count, dtype)


def arange(start: float, stop: float | None = None) -> ndarray:
    """Return the numbers from `start` to before `stop` in steps of 1, or from 0 to `start`."""
    if stop is None:
        start, stop = type(start)(0), start
    if isinstance(start, int) and isinstance(stop, int):
        return ndarray(range(start, stop), int64)
    count = ceil(stop - start)
    return ndarray([start + float(number) for number in range(count)], float64)


def linspace(start: float, stop: float, count: int) -> ndarray:
    """Return `count` floats at equal distances, both ends included."""
    if count < 2:
        outside("linspace of less than two values")
    delta = stop - start
    step = delta / (count - 1)
    if step:
        values = [number * step + start for number in range(count)]
    else:
        values = [number / (count - 1) * delta + start for number in range(count)]
    values[-1] = float(stop)
    return ndarray(values, float64)


def concatenate(pieces: Sequence[Any]) -> ndarray:
    """Return the values of all pieces."""
    arrays = [piece if isinstance(piece, ndarray) else array(piece) for piece in pieces]
    if not arrays:
        raise ValueError("nothing to concatenate")
    of = arrays[0].dtype
    for each in arrays[1:]:
        of = promoted(of, each.dtype)
    data = [each.data if each.dtype is of else each.astype(of).data for each in arrays]
    if of in _BYTES:
        return ndarray(b"".join(data), of)
    return ndarray(list(chain.from_iterable(data)), of)


def append(values: Any, more: Any) -> ndarray:  # noqa: ANN401  (an array, a number)
    """Return the values with one more."""
    return concatenate([asarray(values), [more] if is_scalar(more) else more])


def repeat(values: Any, counts: Any) -> ndarray:  # noqa: ANN401  (arrays)
    """Return each value as often as its count says."""
    source, times = asarray(values), asarray(counts)
    if is_scalar(times):
        times = full(len(source), times)
    if len(source) != len(times):
        raise ValueError(f"{len(times)} counts for {len(source)} values")
    if len(times) and times.min() < 0:
        raise ValueError("a count below zero")
    found = chain.from_iterable(map(repeated, source.data, times.data))
    return ndarray(bytes(found) if source.dtype in _BYTES else list(found), source.dtype)
