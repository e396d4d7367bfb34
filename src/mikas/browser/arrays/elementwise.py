"""Operations value by value, and the operators of arrays that are made of them.

A single number applies to each value of an array; two numbers give a number.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import reduce
from itertools import accumulate, pairwise
from typing import Any, Final

from mikas.browser.arrays import kernels
from mikas.browser.arrays.creation import asarray, full, is_scalar
from mikas.browser.arrays.dtypes import (
    STORED,
    bool_,
    converted,
    dtype,
    float64,
    int64,
    object_,
    promoted,
    scalar_type,
    with_scalar,
)
from mikas.browser.arrays.kernels import Kernel, kernel
from mikas.browser.arrays.ndarray import ndarray, outside

_MOST: Final = (1 << 63) - 1


class ufunc:  # noqa: N801  (numpy's name)
    """An operation on two operands. `gives`: the type of its results; None: that of the operands.

    `running`: the loop of `accumulate`.
    """

    def __init__(
        self,
        name: str,
        loops: Kernel,
        gives: dtype | None = None,
        running: Callable[[Any], list[Any]] | None = None,
    ) -> None:
        self.__name__ = name
        self._loops = loops
        self._gives = gives
        self._running = running

    def __call__(self, one: Any, other: Any) -> Any:  # noqa: ANN401  (numbers and arrays)
        """Return the results; a number for two numbers. One value applies to each of many."""
        a, b = _operand(one), _operand(other)
        common = _common(a, b)
        if (moved := self._moved(a, b)) is not None:
            return moved
        xs, ys = self._typed(a, common), self._typed(b, common)
        if len(xs) == len(ys):
            found = self._loops.arrays(xs, ys)
        elif len(ys) == 1:
            found = self._loops.right(xs, ys[0])
        elif len(xs) == 1:
            found = self._loops.left(xs[0], ys)
        else:
            raise ValueError(f"operands of {len(xs)} and {len(ys)} values")
        result = self._result(found, common)
        return result if isinstance(a, ndarray) or isinstance(b, ndarray) else result[0]

    def _typed(self, operand: object, common: dtype) -> kernels.Values:
        """Return the values in the type in which numpy computes; a number as the only one."""
        if common is object_ or (self._gives is not bool_ and common in STORED):
            outside(f"{self.__name__} of {common}")
        if self._gives is None and common is bool_:
            outside(f"{self.__name__} of masks")
        data: kernels.Values = [operand]
        if isinstance(operand, ndarray):
            data, of = operand.data, operand.dtype
        else:
            of = scalar_type(operand)
        if of is not float64 and float64 in (common, self._gives):
            data = converted(data, float64)
        return data

    def _moved(self, a: object, b: object) -> ndarray | None:
        """Return indexes that follow each other, moved by `b`; None if it is another case."""
        if self.__name__ not in ("add", "subtract") or type(b) is not int:
            return None
        if isinstance(a, ndarray) and isinstance(was := a.data, range):
            by = b if self.__name__ == "add" else -b
            return ndarray(range(was.start + by, was.stop + by, was.step), int64)
        return None

    def _result(self, values: list[Any], common: dtype) -> ndarray:
        gives = self._gives or common
        if gives is bool_:
            return ndarray(bytes(values), bool_)
        if gives is int64 and values and (min(values) < -_MOST - 1 or max(values) > _MOST):
            outside("whole numbers of more than 64 bits")
        return ndarray(values, gives)

    # numpy's methods of an operation

    def accumulate(self, values: Any) -> ndarray:  # noqa: ANN401  (an array)
        """Return the results so far: of the first value, the first two …"""
        array = asarray(values)
        if self._running is None or array.dtype not in (float64, int64):
            outside(f"{self.__name__}.accumulate of {array.dtype}")
        return self._result(self._running(array.data), array.dtype)

    def reduceat(self, values: Any, starts: Any) -> ndarray:  # noqa: ANN401  (arrays)
        """Return the result of each part; a part without values has its first value, as numpy."""
        if self.__name__ not in _LEAST_OR_GREATEST:
            outside(f"{self.__name__}.reduceat")
        array, extreme, ignores = asarray(values), *_LEAST_OR_GREATEST[self.__name__]
        data, places = array.data, asarray(starts).data
        count = len(data)
        if len(places) and not (min(places) >= 0 and max(places) < count):
            raise IndexError("a part begins outside of the array")
        found = []
        is_finite = array.dtype is int64 or kernels.all_finite(data)
        for start, stop in pairwise([*places, count]):
            part = data[start:stop] or [data[start]]
            if not is_finite:
                present = [x for x in part if x == x]  # noqa: PLR0124
                if len(present) < len(part) and not (ignores and present):
                    found.append(math.nan)
                    continue
                part = present
            found.append(extreme(part))
        return ndarray(found, array.dtype)

    def at(self, target: ndarray, places: ndarray, values: ndarray) -> None:
        """Put the result of target and value at each place, one after the other."""
        if self.__name__ not in ("fmin", "fmax") or target.dtype is not float64:
            outside(f"{self.__name__}.at")
        data = target._writable()  # noqa: SLF001  (its own array)
        count, extreme = len(data), _LEAST_OR_GREATEST[self.__name__][0]
        if len(places) and not (-count <= places.min() and places.max() < count):
            raise IndexError("a place outside of the array")
        pairs: Iterable[tuple[int, float]] = zip(places.data, values.data, strict=True)
        if kernels.all_finite(values.data) and places.data == sorted(places.data):
            pairs = kernels.of_runs(places.data, values.data, extreme)
        if extreme is min:
            for place, value in pairs:
                if not data[place] <= value and value == value:  # noqa: PLR0124
                    data[place] = value
        else:
            for place, value in pairs:
                if not data[place] >= value and value == value:  # noqa: PLR0124
                    data[place] = value

    def reduce(self, arrays: Any) -> Any:  # noqa: ANN401  (a list of masks)
        """Return the result of all masks: True of none."""
        if self.__name__ != "logical_and":
            outside(f"{self.__name__}.reduce")
        masks = list(arrays)
        return reduce(self, masks) if masks else True


_LEAST_OR_GREATEST: Final[dict[str, tuple[Callable[[Any], Any], bool]]] = {
    "minimum": (min, False), "maximum": (max, False), "fmin": (min, True), "fmax": (max, True),
}  # fmt: skip


def _operand(given: Any) -> Any:  # noqa: ANN401  (a number or an array)
    return given if isinstance(given, ndarray) or is_scalar(given) else asarray(given)


def _common(a: object, b: object) -> dtype:
    """Return the type that has the values of both operands."""
    if isinstance(a, ndarray) and isinstance(b, ndarray):
        return promoted(a.dtype, b.dtype)
    if isinstance(a, ndarray):
        return with_scalar(a.dtype, b)
    if isinstance(b, ndarray):
        return with_scalar(b.dtype, a)
    return promoted(scalar_type(a), scalar_type(b))


add = ufunc("add", kernel("x + y"), running=lambda a: list(accumulate(a)))
subtract = ufunc("subtract", kernel("x - y"))
multiply = ufunc("multiply", kernel("x * y"))
divide = ufunc("divide", kernels.DIVISION, float64)
minimum = ufunc(
    "minimum",
    kernel("x if x <= y or x != x else y"),
    running=kernels.running("x if x < m or x != x else m"),
)
maximum = ufunc(
    "maximum",
    kernel("x if x >= y or x != x else y"),
    running=kernels.running("x if x > m or x != x else m"),
)
fmin = ufunc("fmin", kernel("y if y < x or x != x else x"))
fmax = ufunc("fmax", kernel("y if y > x or x != x else x"))
less = ufunc("less", kernel("x < y"), bool_)
less_equal = ufunc("less_equal", kernel("x <= y"), bool_)
greater = ufunc("greater", kernel("x > y"), bool_)
greater_equal = ufunc("greater_equal", kernel("x >= y"), bool_)
equal = ufunc("equal", kernel("x == y"), bool_)
not_equal = ufunc("not_equal", kernel("x != y"), bool_)
logical_and = ufunc("logical_and", kernel("bool(x and y)"), bool_)


def remainder(values: ndarray, by: int) -> ndarray:
    """Return the remainder of whole numbers by a positive one."""
    if values.dtype is not int64 or type(by) is not int or by <= 0:
        outside(f"remainder of {values.dtype} by {by!r}")
    return ndarray([x % by for x in values.data], int64)


def _of_one(
    loop: Callable[[Any], Any], gives: dtype | None, *, floats: bool
) -> Callable[[Any], Any]:
    """Return an operation on one operand; `floats`: it computes with floats only."""

    def operation(given: Any) -> Any:  # noqa: ANN401  (a number or an array)
        operand = _operand(given)
        array = operand if isinstance(operand, ndarray) else asarray([operand])
        if array.dtype not in (float64, int64, bool_) or (
            array.dtype is bool_ and gives is not bool_
        ):
            outside(f"this operation on {array.dtype}")
        data = array.data
        if floats and array.dtype is not float64:
            data = converted(data, float64)
        found = ndarray(loop(data), gives or (float64 if floats else array.dtype))
        return found if isinstance(operand, ndarray) else found[0]

    return operation


negative = _of_one(lambda data: [-x for x in data], None, floats=False)
absolute = _of_one(lambda data: [abs(x) for x in data], None, floats=False)
sqrt = _of_one(
    lambda data: [math.sqrt(x) if x >= 0 else math.nan for x in data], float64, floats=True
)
rint = _of_one(kernels.rounded, float64, floats=True)
floor = _of_one(kernels.rounded_down, float64, floats=True)
ceil = _of_one(kernels.rounded_up, float64, floats=True)
isnan = _of_one(kernels.missing, bool_, floats=True)
isfinite = _of_one(kernels.finite, bool_, floats=True)


def rounded(values: Any, decimals: int = 0) -> Any:  # noqa: ANN401  (numbers and arrays)
    """Return floats rounded to a number of decimals, as numpy does: by a power of ten."""
    if decimals < 0:
        outside("rounding to tens")
    return divide(rint(multiply(values, 10.0**decimals)), 10.0**decimals)


def where(mask: Any, one: Any, other: Any) -> Any:  # noqa: ANN401  (numbers and arrays)
    """Return `one` where the mask is true, else `other`."""
    a, b = _operand(one), _operand(other)
    common = _common(a, b)
    if is_scalar(mask):
        if is_scalar(a) and is_scalar(b):
            return common(a if mask else b)
        mask = full(len(b if is_scalar(a) else a), bool(mask))
    mask = asarray(mask)
    flags = (mask if mask.dtype is bool_ else not_equal(mask, 0)).data
    for each in (a, b):
        if isinstance(each, ndarray) and len(each) != len(flags):
            raise ValueError(f"{len(flags)} conditions for {len(each)} values")
    ones = flags.count(1)
    for each, is_all in ((a, ones == len(flags)), (b, not ones)):
        if is_all and len(flags):
            return full(len(flags), each, common) if is_scalar(each) else each.astype(common)
    xs, ys = (common(it) if is_scalar(it) else it.astype(common).data for it in (a, b))
    found = kernels.chosen(flags, xs, ys)
    return ndarray(bytes(found) if common is bool_ else found, common)


def clip(values: Any, least: Any, most: Any) -> Any:  # noqa: ANN401  (numbers and arrays)
    """Return the values, none below `least` or above `most`."""
    return minimum(maximum(values, least), most)


def frompyfunc(function: Callable[[Any, Any], Any], operands: int, results: int) -> ufunc:
    """Return a function for numbers as one for arrays, which gives objects."""
    if (operands, results) != (2, 1):
        outside("such functions")
    return ufunc("function", kernel("f(x, y)", f=function), object_)


_OPERATORS: Final = {
    "add": add, "sub": subtract, "mul": multiply, "truediv": divide,
    "lt": less, "le": less_equal, "gt": greater, "ge": greater_equal,
    "eq": equal, "ne": not_equal, "mod": remainder,
}  # fmt: skip
_OUTSIDE: Final = ("floordiv", "pow", "matmul", "lshift", "rshift", "divmod")
_IN_PLACE: Final = ("add", "sub", "mul", "truediv")


def _put_operators() -> None:
    def refused(*_: object) -> Any:  # noqa: ANN401  (it never returns)
        return outside("such an operator")

    for name, operation in _OPERATORS.items():
        setattr(ndarray, f"__{name}__", lambda a, b, f=operation: f(a, b))
        if name in _IN_PLACE:
            setattr(ndarray, f"__r{name}__", lambda a, b, f=operation: f(b, a))
            setattr(ndarray, f"__i{name}__", lambda a, b, f=operation: a._become(f(a, b)))  # noqa: SLF001
    for name in _OUTSIDE:
        for prefix in ("", "r", "i"):
            setattr(ndarray, f"__{prefix}{name}__", refused)
    for name in ("and", "or", "xor"):
        setattr(ndarray, f"__r{name}__", getattr(ndarray, f"__{name}__"))
    for name, of_one in (("rmod", refused), ("neg", negative), ("abs", absolute)):
        setattr(ndarray, f"__{name}__", lambda *operands, f=of_one: f(*operands))


_put_operators()
