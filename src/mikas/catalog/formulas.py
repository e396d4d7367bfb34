"""The computation of formulas, for one number and for numpy columns, with the same result.

Numbers are 64-bit floats; NaN means no value. An operation without a finite result (division by
zero, root of a negative number, overflow) has no value, nor has anything computed from no value.
Only `where` can skip such an operand: `where(FREQ > 0, JAIR / FREQ, 0)` is 0 at a standing engine.
Conditions are numbers: 0 is false, anything else true; a comparison gives 0 or 1.

IEEE 754 rounds all operations in one way, except powers, whose last digit depends on the library:
a column of powers is computed one by one, by the function for numbers.

A formula is made once into functions of functions, one for each operation of its plain form, from
an arithmetic: a table of functions by the operation's name.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from functools import cache, cached_property, partial, reduce
from math import isfinite
from typing import TYPE_CHECKING, Any, TypeAlias

from mikas.cancellation import check_cancelled
from mikas.catalog.formula_syntax import Operation, Parsed, Term

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Column: TypeAlias = NDArray[np.float64]

NO_VALUE = math.nan
POWER = 150
"""The operations that take as long as one power in a column, which is computed one by one."""

_BLOCK = 8192
"""Rows computed at a time: what lies between two operations fits the processor's cache, and a long
formula takes little memory and can be cancelled.
"""
Arithmetic: TypeAlias = Mapping[str, Callable[..., Any]]
_COMPARISONS: Mapping[str, Callable[[Any, Any], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}


def _finite(number: float) -> float:
    return number if math.isfinite(number) else NO_VALUE


def _power(base: float, exponent: float) -> float:
    try:
        power = math.pow(base, exponent)
    except (ValueError, OverflowError):
        return NO_VALUE
    # nan ** 0 and 1 ** nan are 1 to the library
    return NO_VALUE if math.isnan(base) or math.isnan(exponent) else power


def _compared(holds: Callable[[float, float], bool], a: float, b: float) -> float:
    return NO_VALUE if math.isnan(a) or math.isnan(b) else float(holds(a, b))


def _lesser(a: float, b: float) -> float:
    return a if a < b or math.isnan(a) else b


def _greater(a: float, b: float) -> float:
    return a if a > b or math.isnan(a) else b


_NUMBERS: Arithmetic = {
    "+": lambda a, b: _finite(a + b),
    "-": lambda a, b: _finite(a - b),
    "*": lambda a, b: _finite(a * b),
    "/": lambda a, b: _finite(a / b) if b else NO_VALUE,
    "**": _power,
    "negative": operator.neg,
    "positive": lambda a: a,
    **{sign: partial(_compared, holds) for sign, holds in _COMPARISONS.items()},
    "min": lambda *values: reduce(_lesser, values),
    "max": lambda *values: reduce(_greater, values),
    "abs": abs,
    "sqrt": lambda a: math.sqrt(a) if a >= 0 else NO_VALUE,
    "where": lambda c, a, b: NO_VALUE if math.isnan(c) else a if c else b,
    "clip": lambda a, low, high: _lesser(_greater(a, low), high),
}
"""The arithmetic of single numbers."""


@cache
def _columns() -> Arithmetic:
    """Return the arithmetic of numpy arrays; a single number applies to each of their values."""
    import numpy as np

    def finite(numbers: Column) -> Column:
        return np.where(np.isfinite(numbers), numbers, NO_VALUE)

    def compared(holds: Callable[[Column, Column], Any], a: Column, b: Column) -> Column:
        return np.where(np.isnan(a) | np.isnan(b), NO_VALUE, holds(a, b))

    def power(base: Column, exponent: Column) -> Column:
        return np.asarray(np.frompyfunc(_power, 2, 1)(base, exponent), dtype=np.float64)

    def where(c: Column, a: Column, b: Column) -> Column:
        return np.where(np.isnan(c), NO_VALUE, np.where(np.equal(c, 0), b, a))

    return {
        "+": lambda a, b: finite(np.add(a, b)),
        "-": lambda a, b: finite(np.subtract(a, b)),
        "*": lambda a, b: finite(np.multiply(a, b)),
        "/": lambda a, b: finite(np.divide(a, b)),
        "**": power,
        "negative": np.negative,
        "positive": lambda a: a,
        **{sign: partial(compared, holds) for sign, holds in _COMPARISONS.items()},
        "min": lambda *values: reduce(np.minimum, values),
        "max": lambda *values: reduce(np.maximum, values),
        "abs": np.abs,
        "sqrt": np.sqrt,
        "where": where,
        "clip": lambda a, low, high: np.minimum(np.maximum(a, low), high),
    }


class Calculation:
    """Computes one parsed formula."""

    def __init__(self, formula: Parsed) -> None:
        self._plain = formula.plain
        self.inputs: tuple[str, ...] = formula.inputs

    @property
    def cost(self) -> int:
        """The operations for one row of a column; a power counts as `POWER`."""
        return _cost(self._plain)

    def number(self, values: Mapping[str, float]) -> float:
        """Return the formula's value for `inputs`; NaN if one of them is NaN or infinite."""
        named = {name: float(values[name]) for name in self.inputs}
        if not all(map(isfinite, named.values())):
            return NO_VALUE
        return float(self._of_numbers(named))

    def column(self, values: Mapping[str, Column]) -> Column:
        """Return the values for columns of one length, each equal to that of `number`."""
        import numpy as np

        named = {name: np.asarray(values[name], dtype=np.float64) for name in self.inputs}
        blocks = []
        for at in range(0, len(named[self.inputs[0]]), _BLOCK) or (0,):
            check_cancelled()
            part = {name: column[at : at + _BLOCK] for name, column in named.items()}
            present = np.logical_and.reduce([np.isfinite(column) for column in part.values()])
            with np.errstate(all="ignore"):
                blocks.append(np.where(present, self._of_columns(part), NO_VALUE))
        return blocks[0] if len(blocks) == 1 else np.concatenate(blocks)

    @cached_property
    def _of_numbers(self) -> Callable[[Mapping[str, float]], float]:
        return _function(self._plain, _NUMBERS)

    @cached_property
    def _of_columns(self) -> Callable[[Mapping[str, Column]], Column]:
        return _function(self._plain, _columns())


def _cost(plain: Term) -> int:
    if not isinstance(plain, Operation):
        return 0
    own = POWER if plain.name == "**" else max(1, len(plain.operands) - 1)
    return own + sum(map(_cost, plain.operands))


def _function(plain: Term, arithmetic: Arithmetic) -> Callable[[Mapping[str, Any]], Any]:
    """Return the function that computes a plain form from the channels' values by name."""
    match plain:
        case str():
            return operator.itemgetter(plain)
        case Operation(name, operands):
            apply = arithmetic[name]
            parts = [_function(each, arithmetic) for each in operands]
            return lambda values: apply(*[part(values) for part in parts])
    return lambda _: plain
