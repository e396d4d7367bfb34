"""The rows of one step, and the measures computed from them.

A row has the values of all channels that are fresh enough at its time, so a method that reads one
channel at a time works as one that reads all at once. A measure has a value only if its channels
came often enough, without a gap, in the whole part of the step that it covers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from math import isfinite, nan
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mikas.catalog import Catalog
from mikas.catalog.conversion import NO_TEXT
from mikas.catalog.formula_syntax import Parsed
from mikas.catalog.formulas import Calculation
from mikas.catalog.model import in_order
from mikas.guided.definition import SECONDS, GuidedStep, Measure, Statistic, parameters_of
from mikas.guided.result import Number
from mikas.i18n import Text
from mikas.recording.formatting import digits

Column = NDArray[np.float64]
Mask = NDArray[np.bool_]

MOST_ROWS: Final = 100_000  # of a step; more than half an hour at 50 a second
_BINS: Final = 20
_NEVER: Final = (-1e18, nan)
_LEAST_RATE_SPAN: Final = 1.0  # s; a shorter part has no rate worth the name


def number_of(
    measure: Measure, value: float | None, count: int = 0, rate: float = 0.0, why: Text = NO_TEXT
) -> Number:
    """Return a measure's value, made of `count` readings; None: there is none, for the reason."""
    return Number(
        measure.name,
        measure.text,
        value,
        measure.unit,
        measure.decimals,
        count,
        round(rate, 2),
        why,
    )


class Values:
    """The latest value of each parameter with its time, and formulas computed from them."""

    def __init__(self, catalog: Catalog) -> None:
        self._catalog = catalog
        self._latest: dict[str, tuple[float, float]] = {}
        self._needed: dict[tuple[str, ...], tuple[tuple[str, ...], dict[str, Calculation]]] = {}

    def add_row(self, time: float, values: Mapping[str, float]) -> None:
        """Take the fresh values of a row."""
        for name, value in values.items():
            if isfinite(value):
                self._latest[name] = time, value

    def clear(self) -> None:
        """Forget all values: the clock has run back."""
        self._latest.clear()

    def at(self, time: float, names: tuple[str, ...], longest_gap: float) -> dict[str, float]:
        """Return the values of parameters and derived channels, those that are fresh enough."""
        if names not in self._needed:
            known = self._catalog.derived
            derived = in_order(known, [name for name in names if name in known])
            calculations = {each.name: each.calculation() for each in derived}
            self._needed[names] = parameters_of(self._catalog, names), calculations
        found = {}
        parameters, calculations = self._needed[names]
        for name in parameters:
            when, value = self._latest.get(name, _NEVER)
            if 0 <= time - when <= longest_gap:
                found[name] = value
        for name, calculation in calculations.items():
            if all(each in found for each in calculation.inputs):
                value = calculation.number(found)
                if isfinite(value):
                    found[name] = value
        return found

    def lacking(self, time: float, names: tuple[str, ...], longest_gap: float) -> tuple[str, ...]:
        """Return the parameters without a value, or with one that is too old."""
        ages = ((name, time - self._latest.get(name, _NEVER)[0]) for name in names)
        return tuple(name for name, age in ages if age > longest_gap)


class StepRows:
    """The rows of the measured part of a step. `began`: of the step, for `SECONDS`."""

    def __init__(self, names: tuple[str, ...], began: float) -> None:
        self._names, self._began = names, began
        self.started: float | None = None
        """The beginning of the measured part."""
        self.clear()

    def clear(self) -> None:
        """Drop all rows: the measured part starts again."""
        self.started = None
        self._times: list[float] = []
        self._values: dict[str, list[float]] = {name: [] for name in self._names}
        self._fresh: dict[str, list[bool]] = {name: [] for name in self._names}

    @property
    def is_full(self) -> bool:
        """Whether the part is longer than can be measured."""
        return len(self._times) >= MOST_ROWS

    def add(self, time: float, latest: Mapping[str, float], fresh: Mapping[str, float]) -> None:
        """Add a row: the values that are fresh enough, and those that came with it."""
        if self.is_full:
            return
        if self.started is None:
            self.started = time
        self._times.append(time)
        for name in self._names:
            self._values[name].append(latest.get(name, nan))
            self._fresh[name].append(name in fresh)

    def measured(
        self, measure: Measure, step: GuidedStep, ended: float, catalog: Catalog
    ) -> Number:
        """Return the measure's value at the end of the part."""
        if self.started is None or not self._times:
            return number_of(measure, None, why=_NO_ROWS)
        if self.is_full:
            return number_of(measure, None, why=_TOO_LONG)
        times = np.array(self._times)
        since = self.started if measure.last is None else max(self.started, ended - measure.last)
        part: Mask = times >= since
        inputs = [name for formula in measure.formulas for name in formula.inputs]
        needed = parameters_of(catalog, tuple(inputs))
        if (why := self._hole(needed, step, times, since, ended)) is not None:
            return number_of(measure, None, why=why)
        fresh: Mask = np.zeros(times.size, np.bool_)
        for name in needed:
            fresh |= np.array(self._fresh[name])
        column = self._columns(catalog, inputs, times)
        values = Calculation(measure.of).column(column)
        chosen = part & fresh & np.isfinite(values)
        if measure.when is not None:
            condition = Calculation(measure.when).column(column)
            chosen &= np.isfinite(condition) & (condition != 0)
        by = values
        if measure.by is not None:
            by = Calculation(measure.by).column(column)
            chosen &= np.isfinite(by)
        count = int(chosen.sum())
        span = ended - since
        rate = float((part & fresh).sum()) / span if span >= _LEAST_RATE_SPAN else 0.0
        if count < measure.fewest:
            why = _FEW.filled(count=count, fewest=measure.fewest)
            return number_of(measure, None, count, rate, why)
        value = _STATISTICS[measure.statistic](
            _Sample(times[chosen], values[chosen], by[chosen], measure, step)
        )
        if not isfinite(value):
            return number_of(measure, None, count, rate, _FEW.filled(count=count, fewest=count + 1))
        return number_of(measure, value, count, rate)

    def _hole(
        self, needed: tuple[str, ...], step: GuidedStep, times: Column, since: float, ended: float
    ) -> Text | None:
        """Return the reason why the data of the part are incomplete, or None."""
        for name in needed:
            came = times[np.array(self._fresh[name])]
            came = came[came >= since]
            if not came.size:
                return _NO_VALUES.filled(name=name)
            gap = float(np.max(np.diff(np.concatenate(([since], came, [ended])))))
            if gap > step.longest_gap:
                return _GAP.filled(name=name, seconds=digits(gap, 1))
            span = ended - since
            if span >= _LEAST_RATE_SPAN and came.size / span < step.rate:
                rate, needed = digits(came.size / span, 1), digits(step.rate, 1)
                return _SLOW.filled(name=name, rate=rate, needed=needed)
        return None

    def _columns(self, catalog: Catalog, names: Iterable[str], times: Column) -> dict[str, Column]:
        columns = {name: np.array(self._values[name]) for name in self._names}
        columns[SECONDS] = times - self._began
        derived = [name for name in names if name in catalog.derived]
        for channel in in_order(catalog.derived, derived):
            columns[channel.name] = channel.calculation().column(columns)
        return columns


@dataclass(frozen=True, slots=True)
class _Sample:
    """The chosen readings of a measure: at least one."""

    times: Column
    values: Column
    by: Column
    measure: Measure
    step: GuidedStep

    @property
    def joined(self) -> Mask:
        """Whether each reading but the first follows the one before without a gap."""
        return np.diff(self.times) <= self.step.longest_gap


def _slope(it: _Sample) -> float:
    if it.times.size < 2 or it.times[-1] <= it.times[0]:
        return nan
    minutes = (it.times - it.times[0]) / 60
    apart = minutes - minutes.mean()
    return float((apart * (it.values - it.values.mean())).sum() / (apart * apart).sum())


def _jump(it: _Sample) -> float:
    steps = np.abs(np.diff(it.values))[it.joined]
    return float(steps.max()) if steps.size else nan


def _fall(it: _Sample) -> float:
    values = it.values
    if it.measure.by is not None:
        low, high = float(it.by.min()), float(it.by.max())
        if high <= low:
            return nan
        bins = np.minimum(((it.by - low) / (high - low) * _BINS).astype(int), _BINS - 1)
        values = np.array([np.median(values[bins == each]) for each in np.unique(bins)])
    return float(np.max(np.maximum.accumulate(values) - values))


def _seconds(it: _Sample) -> float:
    steps = np.diff(it.times)
    return float(steps[it.joined & (it.values[:-1] != 0)].sum())


_STATISTICS: Final[Mapping[Statistic, Callable[[_Sample], float]]] = {
    Statistic.MIN: lambda it: float(it.values.min()),
    Statistic.MAX: lambda it: float(it.values.max()),
    Statistic.MEAN: lambda it: float(it.values.mean()),
    Statistic.MEDIAN: lambda it: float(np.median(it.values)),
    Statistic.FIRST: lambda it: float(it.values[0]),
    Statistic.LAST: lambda it: float(it.values[-1]),
    Statistic.SLOPE: _slope,
    Statistic.SPREAD: lambda it: float(it.values.max() - it.values.min()),
    Statistic.PERCENTILE: lambda it: float(np.percentile(it.values, it.measure.percentile)),
    Statistic.JUMP: _jump,
    Statistic.FALL: _fall,
    Statistic.SECONDS: _seconds,
    Statistic.TIMES: lambda it: float((np.diff((it.values != 0) * 1.0, prepend=0.0) > 0).sum()),
    Statistic.SHARE: lambda it: float(100 * np.mean(it.values != 0)),
}


def holds(calculation: Calculation, values: Mapping[str, float]) -> bool:
    """Return whether a condition is true; false if one of its inputs is missing."""
    if any(name not in values for name in calculation.inputs):
        return False
    found = calculation.number(values)
    return isfinite(found) and found != 0


def formulas_inputs(formulas: Iterable[Parsed | None]) -> tuple[str, ...]:
    """Return the channels of formulas, each once."""
    names = (name for formula in formulas if formula is not None for name in formula.inputs)
    return tuple(dict.fromkeys(names))


_NO_ROWS: Final = Text("there are no data of this step", "нет данных этого шага")
_TOO_LONG: Final = Text("the step took too long to be measured", "шаг длился слишком долго")
_NO_VALUES: Final = Text("no values of {name} came", "нет данных {name}")
_GAP: Final = Text("no values of {name} came for {seconds} s", "данных {name} не было {seconds} с")
_SLOW: Final = Text(
    "{name} came {rate} times a second; {needed} are needed",
    "{name} приходил {rate} раза в секунду, а нужно {needed}",
)
_FEW: Final = Text(
    "too few readings fit: {count}; at least {fewest} are needed",
    "подходящих замеров {count}, а нужно не меньше {fewest}",
)
