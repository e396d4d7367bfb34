"""Derived channels of a recording, computed row by row.

A row is one response. If a unit takes only small requests (D11), or one parameter at a time, the
inputs of a formula stand in different rows. Then each input holds for a second, or for a cycle if
that is longer, and the formula has a value in rows with a new input. A row without values is a gap
and stays one. Values of instruments hold as long as their definitions say; what needs these alone
has a value in every row of the unit.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Final

import numpy as np

from mikas.catalog import Catalog
from mikas.client.parameters.derived import DerivedChannels
from mikas.recording.exchanges.arrays import Floats
from mikas.recording.table.channels import Rows

FRESH: Final = 1.0  # s that a value holds for later responses
LONGEST: Final = 10.0  # s of a cycle: one request a code, to a unit that needs 0.5 s for each

_NONE: Final[Mapping[str, Floats]] = MappingProxyType({})


class Deriver:
    """Computes the derived channels `names` of one port in one session, stretch after stretch."""

    def __init__(self, catalog: Catalog, names: Iterable[str]) -> None:
        names = list(names)
        self._channels = DerivedChannels(catalog, names)
        self._requires = catalog.required_by(names)
        self._alike: dict[tuple[str, ...], list[str]] = {}  # the names by what they require
        for name in dict.fromkeys(names):
            self._alike.setdefault(catalog.required_by([name]), []).append(name)
        self._last: dict[str, tuple[float, float]] = {}  # time, value
        self._step: dict[str, float] = {}  # s since the previous value

    def columns(self, rows: Rows, beside: Mapping[str, Floats] = _NONE) -> dict[str, Floats]:
        """Return a column for each name. `rows`: all recorded parameters, corrected.

        `beside`: the instruments' values at these rows.
        """
        missing = np.full(len(rows.times), np.nan)
        inputs = {name: rows.values.get(name, missing) for name in self._requires}
        is_row = np.zeros(len(rows.times), np.bool_)
        for column in rows.values.values():
            is_row |= np.isfinite(column)
        hold = self._cycle(rows.times, inputs)
        held = {
            name: np.where(is_row, self._held(name, rows.times, column, hold), np.nan)
            for name, column in inputs.items()
        }
        derived = self._channels.columns(rows.times, {**rows.values, **held, **beside})
        for sources, names in self._alike.items():
            new = np.zeros(len(rows.times), np.bool_) if sources else is_row
            for source in sources:
                new |= np.isfinite(inputs[source])
            for name in names:
                derived[name] = np.where(new, derived[name], np.nan)
        return derived

    def _cycle(self, times: Floats, inputs: dict[str, Floats]) -> Floats:
        """Return how long a value holds at each row: the step of the most frequent input, ≥ 1 s."""
        cycle = np.full(len(times), np.inf)
        for name, column in inputs.items():
            rows = np.flatnonzero(np.isfinite(column))
            before = self._last.get(name, (-np.inf, np.nan))[0]
            before = before if np.isfinite(before) else np.inf  # the first step is none
            steps = np.diff(np.concatenate(([before], times[rows])))
            steps = np.concatenate(([self._step.get(name, np.inf)], np.maximum(steps, 0.0)))
            self._step[name] = float(steps[-1])
            cycle = np.minimum(cycle, steps[np.cumsum(np.isfinite(column))])
        return np.clip(np.where(np.isfinite(cycle), cycle, 0.0), FRESH, LONGEST)

    def _held(self, name: str, times: Floats, column: Floats, hold: Floats) -> Floats:
        """Return `column` with each value repeated until the next, as long as it holds."""
        at, value = self._last.get(name, (-np.inf, np.nan))
        all_times = np.concatenate(([at], times))
        values = np.concatenate(([value], column))
        known = np.where(np.isfinite(values), np.arange(values.size), 0)
        latest = np.maximum.accumulate(known)
        self._last[name] = float(all_times[latest[-1]]), float(values[latest[-1]])
        age = times - all_times[latest[1:]]
        return np.where((age >= 0) & (age <= hold), values[latest[1:]], np.nan)
