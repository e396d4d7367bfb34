"""A channel that no unit sends: computed from parameters, or from other derived channels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from mikas.catalog.confidence import Confidence
from mikas.catalog.conversion import NO_TEXT
from mikas.catalog.formulas.calculation import Calculation
from mikas.catalog.formulas.syntax import parse
from mikas.catalog.limits import AlarmLimits
from mikas.i18n import Text


@dataclass(frozen=True, slots=True)
class Derived:
    """One derived channel. Its formula is sound, and takes parameters in the corrected reading.

    `inputs` are the channels that the formula names, in capitals. If it `accumulates`, the formula
    is what is added a second. `constants` are the formula's own, by name.
    """

    name: str
    text: Text
    formula: str
    inputs: tuple[str, ...]
    constants: tuple[tuple[str, float], ...] = ()
    accumulates: bool = False
    unit: str = ""
    unit_text: Text = NO_TEXT
    decimals: int = 2
    alarm_limits: AlarmLimits | None = None
    source: str = ""
    confidence: Confidence = Confidence.UNKNOWN

    @property
    def is_flag(self) -> bool:
        """Never: a derived value is a number."""
        return False

    def calculation(self) -> Calculation:
        """The formula, ready to compute; each caller has its own."""
        return Calculation(parse(self.formula, dict(self.constants)))


def in_order(derived: Mapping[str, Derived], wanted: Iterable[str]) -> tuple[Derived, ...]:
    """The derived channels that `wanted` need, themselves included, each after its inputs.

    CycleError (graphlib): there is no such order.
    """
    from graphlib import TopologicalSorter

    graph: dict[str, list[str]] = {}
    to_see = list(wanted)
    while to_see:
        name = to_see.pop()
        if name not in graph:
            graph[name] = [each for each in derived[name].inputs if each in derived]
            to_see += graph[name]
    return tuple(derived[name] for name in TopologicalSorter(graph).static_order())
