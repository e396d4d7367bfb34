"""The loops over values: list comprehensions, in which each operation is one of the interpreter.

In WebAssembly a call for each value (`map` with a function) takes twice as long as the expression
in a comprehension. Nothing here knows arrays: values are lists, ranges, or bytes of 0 and 1.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from math import ceil, copysign, floor, inf, isnan, nan
from typing import Any, Final, NamedTuple

Values = Sequence[Any]
_ROUNDER: Final = 6755399441055744.0
"""1.5 · 2⁵²: a number to which it is added has no bits left for a fraction."""
_FRACTIONS: Final = float(1 << 51)


class Kernel(NamedTuple):
    """One operation on two arrays, an array and a number, a number and an array."""

    arrays: Callable[[Values, Values], list[Any]]
    right: Callable[[Values, Any], list[Any]]
    left: Callable[[Any, Values], list[Any]]


def kernel(expression: str) -> Kernel:
    """Return the loops of an expression of `x` and `y`."""
    names = {"abs": abs}
    return Kernel(
        eval(f"lambda a, b: [{expression} for x, y in zip(a, b)]", names),
        eval(f"lambda a, y: [{expression} for x in a]", names),
        eval(f"lambda x, b: [{expression} for y in b]", names),
    )


def quotient(x: float, y: float) -> float:
    """Return x / y as IEEE 754 has it."""
    if y:
        return x / y
    return nan if isnan(x) or x == 0 else copysign(inf, x) * copysign(1.0, y)


_DIVIDED: Final = kernel("x / y")


def divided(a: Values, b: Values) -> list[float]:
    """Divide value by value."""
    try:
        return _DIVIDED.arrays(a, b)
    except ZeroDivisionError:
        return [quotient(x, y) for x, y in zip(a, b)]  # noqa: B905  (of one length)


def divided_by(a: Values, y: float) -> list[float]:
    """Divide all values by one number."""
    return _DIVIDED.right(a, y) if y else [quotient(x, y) for x in a]


def divided_from(x: float, b: Values) -> list[float]:
    """Divide one number by all values."""
    try:
        return _DIVIDED.left(x, b)
    except ZeroDivisionError:
        return [quotient(x, y) for y in b]


def rounded(a: Values) -> list[float]:
    """Round to whole numbers, a half to the even one."""
    m, most = _ROUNDER, _FRACTIONS
    return [
        ((x + m - m) or x * 0.0) if -most < x < most else x if x - x != 0 else float(round(x))
        for x in a
    ]


def rounded_down(a: Values) -> list[float]:
    """Round to the whole number below; a zero keeps its sign."""
    return [(float(floor(x)) or x * 0.0) if x - x == 0 else x for x in a]


def rounded_up(a: Values) -> list[float]:
    """Round to the whole number above; a zero has the value's sign."""
    return [(float(ceil(x)) or copysign(0.0, x)) if x - x == 0 else x for x in a]


def running(a: Values, expression: str) -> list[Any]:
    """Return the results so far: `expression` of the one before, `m`, and the value `x`."""
    if not len(a):
        return []
    found: list[Any] = _running(expression)(a, a[0])
    return found


def _running(expression: str) -> Callable[[Values, Any], list[Any]]:
    if expression not in _RUNNING:
        _RUNNING[expression] = eval(f"lambda a, m: [m := {expression} for x in a]")
    return _RUNNING[expression]


_RUNNING: Final[dict[str, Callable[[Values, Any], list[Any]]]] = {}


def all_finite(a: Values) -> bool:
    """Return whether all values are certainly finite: an infinite one or NaN shows in the sum."""
    total = sum(a)
    return total - total == 0


def rising(a: Values) -> list[int]:
    """Return the places of the values, rising, NaN last; equal ones in their order."""
    if all_finite(a):
        return sorted(range(len(a)), key=a.__getitem__)
    return sorted(range(len(a)), key=lambda at: (isnan(a[at]), a[at]))


def of_runs(
    places: Sequence[int], values: Values, extreme: Callable[[Values], Any]
) -> Iterator[tuple[int, Any]]:
    """Yield each of the rising places once, with the extreme of its values."""
    begin = 0
    while begin < len(places):
        end = bisect_right(places, places[begin], begin)
        yield places[begin], extreme(values[begin:end])
        begin = end


def finite(a: Values) -> bytes:
    """Return which values are finite."""
    return b"\1" * len(a) if all_finite(a) else bytes([x - x == 0 for x in a])


def missing(a: Values) -> bytes:
    """Return which values are NaN."""
    return bytes(len(a)) if all_finite(a) else bytes([x != x for x in a])  # noqa: PLR0124


def chosen(mask: bytes, a: Values | None, b: Values | None, x: Any, y: Any) -> Any:  # noqa: ANN401  (numbers)
    """Return the values of `a` (None: `x`) where `mask` is 1, else those of `b` (None: `y`)."""
    if a is not None and b is not None:
        return [x if m else y for m, x, y in zip(mask, a, b)]  # noqa: B905  (of one length)
    if a is not None:
        return [x if m else y for m, x in zip(mask, a)]  # noqa: B905
    if b is not None:
        return [x if m else y for m, y in zip(mask, b)]  # noqa: B905
    return [x if m else y for m in mask]


# Masks are long integers for a moment: 64 times as fast as byte by byte


def both(a: bytes, b: bytes) -> bytes:
    """Return where both masks are 1."""
    return (_number(a) & _number(b)).to_bytes(len(a), "little")


def either(a: bytes, b: bytes) -> bytes:
    """Return where one of the masks is 1."""
    return (_number(a) | _number(b)).to_bytes(len(a), "little")


def different(a: bytes, b: bytes) -> bytes:
    """Return where one mask is 1 and the other is not."""
    return (_number(a) ^ _number(b)).to_bytes(len(a), "little")


def inverted(a: bytes) -> bytes:
    """Return where the mask is 0."""
    return a.translate(_INVERTED)


def _number(mask: bytes) -> int:
    return int.from_bytes(mask, "little")


_INVERTED: Final = bytes([1]) + bytes(255)
