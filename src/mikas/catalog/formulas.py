"""The computation of formulas, for one number and for numpy columns, with the same result.

Numbers are 64-bit floats; NaN means no value. An operation without a finite result (division by
zero, root of a negative number, overflow) has no value, nor has anything computed from no value.
Only `where` can skip such an operand: `where(FREQ > 0, JAIR / FREQ, 0)` is 0 at a standing engine.
Conditions are numbers: 0 is false, anything else true; a comparison gives 0 or 1.

IEEE 754 rounds all operations in one way, except powers, whose last digit depends on the library:
a column of powers is computed one by one, by the function for numbers.

The library simpleeval evaluates the plain form with this arithmetic, so it meets nothing but
numbers. It is imported when the first formula is computed.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping
from functools import cache, cached_property, partial, reduce
from math import isfinite
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from mikas.catalog.formula_syntax import Parsed

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from simpleeval import SimpleEval

    Column: TypeAlias = NDArray[np.float64]

NO_VALUE = math.nan


class Arithmetic(NamedTuple):
    """The functions for simpleeval: by operator's node, and by name."""

    operators: Mapping[type[ast.AST], Callable[..., Any]]
    functions: Mapping[str, Callable[..., Any]]


@cache
def of_numbers() -> Arithmetic:
    """Return the arithmetic of single numbers."""
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


class Calculation:
    """Computes one parsed formula; not for several threads at once."""

    def __init__(self, formula: Parsed) -> None:
        self._tree = formula.tree
        self.inputs = formula.inputs

    def number(self, values: Mapping[str, float]) -> float:
        """Return the formula's value for `inputs`; NaN if one of them is NaN or infinite."""
        named = {name: float(values[name]) for name in self.inputs}
        if not all(map(isfinite, named.values())):
            return NO_VALUE
        return float(self._evaluated(self._of_numbers, named))

    def column(self, values: Mapping[str, Column]) -> Column:
        """Return the values for columns of one length, each equal to that of `number`."""
        import numpy as np

        named = {name: np.asarray(values[name], dtype=np.float64) for name in self.inputs}
        present = np.logical_and.reduce([np.isfinite(column) for column in named.values()])
        with np.errstate(all="ignore"):
            return np.where(present, self._evaluated(self._of_columns, named), NO_VALUE)

    @cached_property
    def _of_numbers(self) -> SimpleEval:
        return _evaluator(of_numbers())

    @cached_property
    def _of_columns(self) -> SimpleEval:
        return _evaluator(of_columns())

    def _evaluated(self, evaluator: SimpleEval, names: Mapping[str, object]) -> Any:  # noqa: ANN401  (a number or a column, as the evaluator's arithmetic is)
        evaluator.names = names
        return evaluator.eval("", self._tree)


def _evaluator(arithmetic: Arithmetic) -> SimpleEval:
    from simpleeval import SimpleEval

    return SimpleEval(operators=arithmetic.operators, functions=arithmetic.functions)
