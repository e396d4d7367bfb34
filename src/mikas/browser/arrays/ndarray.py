"""An array of one dimension: what mikas uses of `numpy.ndarray`.

Floats and integers are in lists, indexes that follow each other in ranges, masks and bytes in
bytes. A slice is a copy here, in numpy a view: so neither the slice nor its source can be changed
any more, which is an error and never a wrong number. Whatever else is missing is one, too.
"""

from __future__ import annotations

from array import array as machine_array
from collections.abc import Iterator
from itertools import accumulate, compress
from math import fsum
from operator import and_, or_, xor
from typing import Any, NoReturn

from mikas.browser.arrays import kernels
from mikas.browser.arrays.dtypes import (
    STORED,
    bool_,
    converted,
    dtype,
    dtype_of,
    float64,
    int64,
    kept,
    object_,
    one,
    uint8,
)

_BYTES = (bool_, uint8)


def outside(what: str) -> NoReturn:
    """Raise the error of what the arrays here do not do."""
    raise NotImplementedError(f"the arrays of the browser have no {what}")


class ndarray:  # noqa: N801  (numpy's name; it has no hash; many operators)
    """Values of one type. `data`: a list, a range, or bytes; not to be changed from outside."""

    __slots__ = ("_shared", "_viewed", "data", "dtype")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, data: Any, of: dtype) -> None:  # noqa: ANN401  (as the type is kept)
        self.data = data
        self.dtype = of
        self._shared = False  # `data` is another array's as well: it is copied before a change
        self._viewed = False  # numpy would show a change in another array, too

    # What it is

    @property
    def size(self) -> int:
        """The number of values."""
        return len(self.data)

    @property
    def shape(self) -> tuple[int]:
        """The number of values, as a tuple."""
        return (len(self.data),)

    def __len__(self) -> int:
        return len(self.data)

    def __iter__(self) -> Iterator[Any]:
        return iter(self.tolist() if self.dtype is bool_ else self.data)

    def __bool__(self) -> bool:
        if len(self.data) != 1:
            raise ValueError("the truth value of an array is ambiguous; use any() or all()")
        return bool(self.data[0])

    def __repr__(self) -> str:
        return f"array({self.tolist()}, {self.dtype})"

    def tolist(self) -> list[Any]:
        """Return the values as a list."""
        if self.dtype is bool_:
            return [x != 0 for x in self.data]
        return list(self.data)

    def tobytes(self) -> bytes:
        """Return the values as they are in memory."""
        if self.dtype in _BYTES:
            return bytes(self.data)
        if self.dtype is object_:
            outside("bytes of objects")
        values = machine_array(self.dtype.code, self.data)
        if self.dtype.swapped:
            values.byteswap()
        return values.tobytes()

    def copy(self) -> ndarray:
        """Return a copy."""
        copied = ndarray(self.data, self.dtype)
        self._shared = copied._shared = True
        return copied

    def astype(self, to: object) -> ndarray:
        """Return the values in another type."""
        wanted = dtype_of(to)
        if wanted is self.dtype:
            return self.copy()
        if wanted is int64 and self.dtype.kind in "bui":
            return ndarray(list(self.data), wanted)
        return ndarray(converted(self.data, wanted), wanted)

    # Parts of it

    def __getitem__(self, key: Any) -> Any:  # noqa: ANN401  (a number, or an array)
        if isinstance(key, slice):
            part = ndarray(self.data[key], self.dtype)
            self._viewed = part._viewed = True
            return part
        if isinstance(key, int) and not isinstance(key, bool):
            value = self.data[key]
            return value != 0 if self.dtype is bool_ else value
        index = _index(key)
        if index.dtype is bool_:
            return self._compressed(index.data)
        return self.take(index)

    def _compressed(self, mask: bytes) -> ndarray:
        if len(mask) != len(self.data):
            raise IndexError(f"a mask of {len(mask)} values for {len(self.data)}")
        if mask.count(1) == len(mask):
            return self.copy()
        kept = compress(self.data, mask)
        return ndarray(bytes(kept) if self.dtype in _BYTES else list(kept), self.dtype)

    def take(self, index: Any) -> ndarray:  # noqa: ANN401  (an array or a list)
        """Return the values at the indexes."""
        places, data = _index(index).data, self.data
        run = isinstance(places, range) and len(places) > 0 and places.step > 0
        if run and places.start >= 0:
            data[places[-1]]  # an index beyond the end is an error
            return ndarray(data[places.start : places.stop : places.step], self.dtype)
        taken = [data[place] for place in places]
        return ndarray(bytes(taken) if self.dtype in _BYTES else taken, self.dtype)

    def __setitem__(self, key: Any, value: Any) -> None:  # noqa: ANN401  (numbers and arrays)
        data = self._writable()
        if isinstance(key, int) and not isinstance(key, bool):
            data[key] = one(value, self.dtype)
            return
        if isinstance(key, slice):
            places = range(*key.indices(len(data)))
            data[key] = self._values(value, len(places))
            return
        index = _index(key)
        if index.dtype is bool_:
            if len(index.data) != len(data):
                raise IndexError(f"a mask of {len(index.data)} values for {len(data)}")
            index = index.nonzero()[0]
        values = self._values(value, len(index.data))
        for place, each in zip(index.data, values, strict=True):
            data[place] = each

    def _writable(self) -> Any:  # noqa: ANN401  (a list or a bytearray)
        if self._viewed:
            outside("change of an array that has slices, or is one")
        kind = bytearray if self.dtype in _BYTES else list
        if self._shared or not isinstance(self.data, kind):
            self.data, self._shared = kind(self.data), False
        return self.data

    def _values(self, given: Any, count: int) -> Any:  # noqa: ANN401  (values as they are kept)
        """Return `count` values in this array's type: those given, or one of them repeated."""
        if isinstance(given, (list, tuple)) and self.dtype is not object_:
            given = _array(given)
        if isinstance(given, ndarray):
            data = given.data if given.dtype is self.dtype else converted(given.data, self.dtype)
        else:
            data = given if isinstance(given, (list, tuple)) else converted([given], self.dtype)
        if len(data) == count:
            return data
        if len(data) != 1:
            raise ValueError(f"{len(data)} values for {count} places")
        return (bytes(data) if self.dtype in _BYTES else list(data)) * count

    def nonzero(self) -> tuple[ndarray]:
        """Return the places of all values but zero."""
        mask = self.data if self.dtype is bool_ else bytes([x != 0 for x in self.data])
        places = range(len(mask))
        if mask.count(1) == len(mask):
            return (ndarray(places, int64),)
        return (ndarray(list(compress(places, mask)), int64),)

    def argsort(self, *, kind: str) -> ndarray:
        """Return the places of the values, rising; equal ones in their order."""
        if kind != "stable":
            outside(f"order {kind!r}")
        return ndarray(kernels.rising(self.data), int64)

    # One number of all

    def sum(self) -> Any:  # noqa: ANN401  (a number)
        """Return the sum; of floats, the one that is nearest to the exact sum."""
        if self.dtype is bool_:
            return self.data.count(1)
        if self.dtype is not float64:
            return sum(self.data)
        try:
            return fsum(self.data)
        except (OverflowError, ValueError):
            return sum(self.data, 0.0)

    def mean(self) -> float:
        """Return the mean; NaN without values."""
        return kernels.quotient(float(self.sum()), float(len(self.data)))

    def cumsum(self) -> ndarray:
        """Return the sums so far."""
        of = float64 if self.dtype is float64 else int64
        return ndarray(list(accumulate(self.data)), of)

    def any(self) -> bool:
        """Return whether a value is not zero."""
        return any(self.data)

    def all(self) -> bool:
        """Return whether no value is zero."""
        return all(self.data)

    def min(self) -> Any:  # noqa: ANN401  (a number)
        """Return the least value; NaN if there is one."""
        return self._extreme(min)

    def max(self) -> Any:  # noqa: ANN401  (a number)
        """Return the greatest value; NaN if there is one."""
        return self._extreme(max)

    def argmin(self) -> int:
        """Return the place of the least value, or of the first NaN."""
        return self._place_of(min)

    def argmax(self) -> int:
        """Return the place of the greatest value, or of the first NaN."""
        return self._place_of(max)

    def _extreme(self, extreme: Any) -> Any:  # noqa: ANN401  (min or max; a number)
        if self.dtype.kind == "f" and not kernels.all_finite(self.data):
            return self[self._place_of(extreme)]
        if not len(self.data):
            raise ValueError("no extreme of no values")
        return extreme(self.tolist() if self.dtype is bool_ else self.data)

    def _place_of(self, extreme: Any) -> int:  # noqa: ANN401  (min or max)
        if not len(self.data):
            raise ValueError("no extreme of no values")
        if self.dtype.kind == "f":
            nan = kernels.missing(self.data).find(1)
            if nan >= 0:
                return nan
        found: int = self.data.index(extreme(self.data))
        return found

    # Operators

    def __invert__(self) -> ndarray:
        if self.dtype is not bool_:
            outside("~ but of masks")
        return ndarray(kernels.inverted(bytes(self.data)), bool_)

    def _masks(self, other: Any, operation: Any) -> ndarray:  # noqa: ANN401  (an array)
        if not isinstance(other, ndarray):
            other = ndarray(bytes([bool(other)]) * len(self.data), bool_)
        if self.dtype is not bool_ or other.dtype is not bool_:
            outside("& | ^ but of masks")
        if len(self.data) != len(other.data):
            raise ValueError(f"masks of {len(self.data)} and {len(other.data)} values")
        return ndarray(kernels.masked(self.data, other.data, operation), bool_)

    def __or__(self, other: object) -> ndarray:
        return self._masks(other, or_)

    def __xor__(self, other: object) -> ndarray:
        return self._masks(other, xor)

    def _become(self, other: ndarray) -> ndarray:
        self._writable()
        if other.dtype is not self.dtype:
            outside(f"change of {self.dtype} to {other.dtype} in place")
        self.data, self._shared = other.data, False
        return self

    def __and__(self, other: object) -> ndarray:
        if self.dtype is int64 and type(other) is int:
            return ndarray([x & other for x in self.data], int64)
        return self._masks(other, and_)

    def __iand__(self, other: object) -> ndarray:
        return self._become(self & other)

    def __ior__(self, other: object) -> ndarray:
        return self._become(self | other)

    def __array__(self, *_: object, **__: object) -> NoReturn:
        outside("way to become an array of another library")


def _index(key: Any) -> ndarray:  # noqa: ANN401  (what stands in brackets)
    index = key if isinstance(key, ndarray) else _array(key)
    if index.dtype is not bool_ and index.dtype is not int64:
        if not len(index.data) and not isinstance(key, ndarray):
            return ndarray([], int64)
        if index.dtype in STORED and index.dtype.kind in "ui":
            return ndarray(index.data, int64)
        raise IndexError(f"an index of {index.dtype}")
    return index


def _array(values: Any) -> ndarray:  # noqa: ANN401  (a list of numbers)
    if not isinstance(values, (list, tuple)) or (isinstance(values, tuple) and values):
        outside(f"index {values!r}")
    return ndarray(*kept(values))
