"""A formula at work: from the values of the channels that it names to its own.

The expression library simpleeval walks the plain form with our own arithmetic, in which it finds no
object but numbers. It is imported when the first formula is computed.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from math import isfinite
from typing import TYPE_CHECKING, Any, TypeAlias

from mikas.catalog.formulas.arithmetic import NO_VALUE, Arithmetic, of_columns, of_numbers
from mikas.catalog.formulas.syntax import Parsed

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from simpleeval import SimpleEval

    Column: TypeAlias = NDArray[np.float64]


class Calculation:
    """Computes one formula, which `parse` has accepted. Not for several threads at once."""

    def __init__(self, formula: Parsed) -> None:
        self._tree = formula.tree
        self.inputs = formula.inputs

    def number(self, values: Mapping[str, float]) -> float:
        """The value of `values`, which has all `inputs`; NaN if one of them is NaN or infinite."""
        named = {name: float(values[name]) for name in self.inputs}
        if not all(map(isfinite, named.values())):
            return NO_VALUE
        return float(self._evaluated(self._of_numbers, named))

    def column(self, values: Mapping[str, Column]) -> Column:
        """The same for columns of one length, each value as `number` has it."""
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

    def _evaluated(
        self,
        evaluator: SimpleEval,
        names: Mapping[str, object],
    ) -> Any:  # noqa: ANN401  (a number or a column, as the evaluator's arithmetic is)
        evaluator.names = names
        return evaluator.eval("", self._tree)


def _evaluator(arithmetic: Arithmetic) -> SimpleEval:
    from simpleeval import SimpleEval

    return SimpleEval(operators=arithmetic.operators, functions=arithmetic.functions)
