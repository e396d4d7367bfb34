"""What every benchmark gives: rows of figures in themes, printed and written as Markdown.

A theme is one module with `run(scope)`, which yields a `Theme` for each of its tables as soon as it
is measured; `bench.__main__` lists the modules. A row holds the figure of every run: the median
counts, lowest and highest are the spread, and the target is met or MISSED by the median.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median
from textwrap import fill
from time import perf_counter


@dataclass(frozen=True, slots=True)
class Scope:
    """How much is measured. `quick`: enough to see that everything works, not to quote."""

    quick: bool = False

    def of(self, full: int, quick: int) -> int:
        return quick if self.quick else full


@dataclass(frozen=True, slots=True)
class Row:
    """One figure. `runs`: repeated measurements; `aside`: a remark to it.

    `how`: how it was measured, where the theme's method does not say it.
    """

    what: str
    runs: Sequence[float]
    unit: str
    digits: int = 1
    at_least: float | None = None
    at_most: float | None = None
    aside: str = ""
    how: str = ""

    @property
    def value(self) -> float:
        return median(self.runs)

    @property
    def met(self) -> bool | None:
        """None: there is no target, the row stands for comparison."""
        if self.at_least is not None:
            return self.value >= self.at_least
        return None if self.at_most is None else self.value <= self.at_most

    def cells(self) -> list[str]:
        target = ""
        if self.at_least is not None:
            target = f"≥ {self.at_least:,g} {self.unit}"
        elif self.at_most is not None:
            target = f"≤ {self.at_most:,g} {self.unit}"
        verdict = {True: "met", False: "**MISSED**", None: ""}[self.met]
        spread = ""
        if len(self.runs) > 1:
            spread = f"{self._shown(min(self.runs))} … {self._shown(max(self.runs))}"
        measured = f"{self._shown(self.value)} {self.unit}"
        return [self.what, target, measured, spread, verdict, self.aside]

    def _shown(self, value: float) -> str:
        return f"{value:,.{self.digits}f}"


def timed(work: Callable[[], object], runs: int) -> list[float]:
    """Return how many seconds each of these runs took."""
    taken = []
    for _ in range(runs):
        began = perf_counter()
        work()
        taken.append(perf_counter() - began)
    return taken


_WIDTH = 120
_HEADS = ("", "target", "measured", "lowest … highest", "", "")


@dataclass(frozen=True, slots=True)
class Theme:
    """A table and how its figures came about, in words."""

    title: str
    method: str
    rows: Sequence[Row]

    def markdown(self) -> str:
        cells = [list(_HEADS), *(row.cells() for row in self.rows)]
        kept = [n for n in range(len(_HEADS)) if n == 0 or any(line[n] for line in cells[1:])]
        lines = ["| " + " | ".join(line[n] for n in kept) + " |" for line in cells]
        lines.insert(1, "|" + "---|" * len(kept))
        notes = [
            fill(f"- {row.what}: {row.how}", _WIDTH, subsequent_indent="  ", break_on_hyphens=False)
            for row in self.rows
            if row.how
        ]
        method = fill(self.method, _WIDTH, break_on_hyphens=False)
        parts = [f"## {self.title}", method, "\n".join(lines), "\n".join(notes)]
        return "\n\n".join(part for part in parts if part)
