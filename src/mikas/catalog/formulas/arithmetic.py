"""The arithmetic of formulas, for one number and for columns of them, with the same result.

Numbers are 64-bit floats; NaN is "no value". An operation whose result is no finite number (a
division by zero, a root of a negative number, an overflow) has no value, and what has no value
gives none to whatever is computed from it. Only `where` can leave it aside:
`where(FREQ > 0, JAIR / FREQ, 0)` is 0 with the engine standing. Conditions are numbers: 0 is false,
anything else true, and a comparison gives 0 or 1.

Both forms are made of operations that IEEE 754 rounds in one way only. Powers are not of these
(libraries differ in the last digit), so a column's are computed one by one, by the same function.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping
from functools import cache, partial, reduce
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Column: TypeAlias = NDArray[np.float64]

NO_VALUE = math.nan


class Arithmetic(NamedTuple):
    """What simpleeval needs: what each operator's node does, and each function."""

    operators: Mapping[type[ast.AST], Callable[..., Any]]
    functions: Mapping[str, Callable[..., Any]]


@cache
def of_numbers() -> Arithmetic:
    """The form for one number."""
    return Arithmetic(
        operators={
            ast.Add: lambda a, b: _finite(a + b),
            ast.Sub: lambda a, b: _finite(a - b),
            ast.Mult: lambda a, b: _finite(a * b),
            ast.Div: lambda a, b: _finite(a / b) if b else NO_VALUE,
            ast.Pow: _power,
            ast.USub: lambda a: -a,
            ast.UAdd: lambda a: a,
            ast.Lt: partial(_compared, lambda a, b: a < b),
            ast.LtE: partial(_compared, lambda a, b: a <= b),
            ast.Gt: partial(_compared, lambda a, b: a > b),
            ast.GtE: partial(_compared, lambda a, b: a >= b),
            ast.Eq: partial(_compared, lambda a, b: a == b),
            ast.NotEq: partial(_compared, lambda a, b: a != b),
        },
        functions={
            "min": lambda *values: reduce(_lesser, values),
            "max": lambda *values: reduce(_greater, values),
            "abs": abs,
            "sqrt": lambda a: math.sqrt(a) if a >= 0 else NO_VALUE,
            "where": lambda c, a, b: NO_VALUE if math.isnan(c) else a if c else b,
            "clip": lambda a, low, high: _lesser(_greater(a, low), high),
        },
    )


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


@cache
def of_columns() -> Arithmetic:
    """The form for numpy's arrays; a number among them counts for each of their values."""
    import numpy as np

    def finite(numbers: Column) -> Column:
        return np.where(np.isfinite(numbers), numbers, NO_VALUE)

    def compared(holds: Callable[[Column, Column], Any], a: Column, b: Column) -> Column:
        return np.where(np.isnan(a) | np.isnan(b), NO_VALUE, holds(a, b))

    def power(base: Column, exponent: Column) -> Column:
        return np.asarray(np.frompyfunc(_power, 2, 1)(base, exponent), dtype=np.float64)

    def where(c: Column, a: Column, b: Column) -> Column:
        return np.where(np.isnan(c), NO_VALUE, np.where(np.equal(c, 0), b, a))

    return Arithmetic(
        operators={
            ast.Add: lambda a, b: finite(np.add(a, b)),
            ast.Sub: lambda a, b: finite(np.subtract(a, b)),
            ast.Mult: lambda a, b: finite(np.multiply(a, b)),
            ast.Div: lambda a, b: finite(np.divide(a, b)),
            ast.Pow: power,
            ast.USub: np.negative,
            ast.UAdd: lambda a: a,
            ast.Lt: partial(compared, np.less),
            ast.LtE: partial(compared, np.less_equal),
            ast.Gt: partial(compared, np.greater),
            ast.GtE: partial(compared, np.greater_equal),
            ast.Eq: partial(compared, np.equal),
            ast.NotEq: partial(compared, np.not_equal),
        },
        functions={
            "min": lambda *values: reduce(np.minimum, values),
            "max": lambda *values: reduce(np.maximum, values),
            "abs": np.abs,
            "sqrt": np.sqrt,
            "where": where,
            "clip": lambda a, low, high: np.minimum(np.maximum(a, low), high),
        },
    )
