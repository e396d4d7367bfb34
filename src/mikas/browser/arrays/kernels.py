"""The loops over values: list comprehensions, in which each operation is one of the interpreter.

In WebAssembly a call for each value (`map` with a function) takes twice as long as the expression
in a comprehension. Nothing here knows arrays: values are lists, ranges, or bytes of 0 and 1.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from math import ceil, copysign, floor, inf, isnan, nan
from typing import Any, Final, NamedTuple

Values = Sequence[Any]
Operand = Values | float
"""Values, or one number for all of them."""
Loop = Callable[[Any, Any], list[Any]]
_ROUNDER: Final = 6755399441055744.0
"""1.5 · 2⁵²: a number to which it is added has no bits left for a fraction."""
_FRACTIONS: Final = float(1 << 51)


class Kernel(NamedTuple):
    """One operation on two arrays, an array and a number, a number and an array."""

    arrays: Callable[[Values, Values], list[Any]]
    right: Callable[[Values, Any], list[Any]]
    left: Callable[[Any, Values], list[Any]]


@lru_cache  # of functions that are applied again and again
def kernel(expression: str, **names: object) -> Kernel:
    """Return the loops of an expression of `x` and `y`, and of the functions `names`."""
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


def _quick_or_safe(quick: Loop, safe: Loop) -> Loop:
    """Return the quick loop, with the safe one where that divides by zero."""

    def loop(a: Operand, b: Operand) -> list[Any]:
        try:
            return quick(a, b)
        except ZeroDivisionError:
            return safe(a, b)

    return loop


DIVISION: Final = Kernel(*map(_quick_or_safe, kernel("x / y"), kernel("q(x, y)", q=quotient)))


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


def running(expression: str) -> Callable[[Values], list[Any]]:
    """Return the loop of the results so far: an expression of the one before, `m`, and of `x`."""
    loop = eval(f"lambda a, m: [m := {expression} for x in a]")
    return lambda a: loop(a, a[0]) if len(a) else []


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


def chosen(mask: bytes, a: Operand, b: Operand) -> list[Any]:
    """Return the values of `a` where `mask` is 1, else those of `b`; either may be one number."""
    if isinstance(a, (int, float)):
        if isinstance(b, (int, float)):
            return [a if m else b for m in mask]
        return [a if m else y for m, y in zip(mask, b, strict=False)]
    if isinstance(b, (int, float)):
        return [x if m else b for m, x in zip(mask, a, strict=False)]
    return [x if m else y for m, x, y in zip(mask, a, b, strict=False)]


def masked(a: bytes, b: bytes, operation: Callable[[int, int], int]) -> bytes:
    """Return two masks under `&`, `|` or `^`: as long integers, 64 times as fast as by bytes."""
    found = operation(int.from_bytes(a, "little"), int.from_bytes(b, "little"))
    return found.to_bytes(len(a), "little")


def inverted(a: bytes) -> bytes:
    """Return where the mask is 0."""
    return a.translate(_INVERTED)


_INVERTED: Final = bytes([1]) + bytes(255)
