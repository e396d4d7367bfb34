"""Derived channels: of one reading, of samples one by one, or whole columns for an export.

    readings ──► DerivedChannels.update ──► DerivedValue      read once, or sample by sample
    rows ──────► DerivedChannels.columns ─► arrays            the same numbers, bit for bit

A derived channel has no value where an input is missing in the sample, or where its formula has
none (a division by zero).

An accumulating channel integrates its formula, which is per second, by the trapezoidal rule. A gap
adds nothing and is counted: a pause of more than two seconds, a time in which the inputs were not
requested, or a clock set back. A sample without the inputs (a repeated request) is no gap, nor is
a pause like both before it: slow channels have such pauses.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import isfinite, nan
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, TypeAlias

from mikas.catalog import Catalog, Derived
from mikas.catalog.formulas import Calculation
from mikas.catalog.model import in_order
from mikas.client.parameters.readings import Reading, with_unit
from mikas.i18n import Text
from mikas.instruments.reading import InstrumentReading

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Column: TypeAlias = NDArray[np.float64]

_LONGEST = 2.0  # s; a longer step is a gap, unless such steps are usual
_ALIKE = 2.5  # times the shorter of the two steps before: still a usual step


@dataclass(frozen=True, slots=True)
class DerivedValue:
    """One value of a derived channel, at `time`, with its direct inputs.

    Of an accumulating channel, `since` is the beginning and `gaps` the number of interruptions.
    `Ecu.read` also returns one without a value (`has_value`): it is NaN, and `inputs` are the
    parameters that the channel needs. `raw` and `interpretation` are as of a `Reading`: a computed
    value has no bytes, and is computed from corrected values.
    """

    raw: ClassVar[bytes] = b""
    """Empty: it was computed."""
    interpretation: ClassVar[str] = "corrected"
    """That of the values it was computed from."""

    channel: Derived
    """The definition, with its formula."""
    value: float
    """The computed value."""
    unit: str
    """The key of the unit; empty: it has none."""
    time: float
    """The time of its inputs."""
    inputs: Mapping[str, Reading | DerivedValue | InstrumentReading]
    """The readings, derived values and values of instruments that it was computed from."""
    since: float | None = None
    """The begin of the sum, of an accumulating channel."""
    gaps: int = 0
    """How often the sum was interrupted."""

    @property
    def name(self) -> str:
        """The channel's name."""
        return self.channel.name

    @property
    def has_value(self) -> bool:
        """Whether the formula has a result: not so after a division by zero."""
        return isfinite(self.value)

    @property
    def shown(self) -> Text:
        """The value with its unit, as people write it, as of a `Reading`."""
        if not self.has_value:
            return Text("no value", "нет значения")
        number = f"{self.value:.{self.channel.decimals}f}"
        return with_unit(number, self.channel.unit_text)

    def __repr__(self) -> str:
        """Return it on one line, as of a `Reading`."""
        inputs = ", ".join(map(str, self.inputs.values()))
        return f"<DerivedValue {self}: of {inputs}, {self.time:.3f} s>"

    def __str__(self) -> str:
        if not self.has_value:
            return f"{self.name} no value"
        return f"{self.name} {self.value:.{self.channel.decimals}f} {self.unit}".rstrip()


_Value: TypeAlias = Reading | DerivedValue | InstrumentReading
_NONE: Mapping[str, InstrumentReading | DerivedValue] = MappingProxyType({})


class DerivedChannels:
    """The derived channels `names`, as in the catalog, and those among their inputs."""

    def __init__(self, catalog: Catalog, names: Iterable[str]) -> None:
        names = tuple(dict.fromkeys(names))
        self.channels: tuple[Derived, ...] = tuple(catalog.derived[name] for name in names)
        self._catalog = catalog
        self._steps = _steps(catalog, names)
        self.totals: dict[str, Integral] = {
            each.name: Integral() for each, _ in self._steps if each.accumulates
        }
        """That of each accumulating channel, also while it has no value."""

    def continue_from(self, before: DerivedChannels, requested: Iterable[str]) -> None:
        """Take over the totals of `before`, also those of channels that are not requested now.

        They continue if the `requested` parameters suffice; otherwise the time counts as a gap.
        A channel that another catalog computes otherwise starts again.
        """
        requested = set(requested)
        kept = before.totals
        if kept and self._catalog is not before._catalog:
            same = self._catalog.same_channels(before._catalog)
            kept = {name: integral for name, integral in kept.items() if name in same}
        self.totals |= kept
        for name, integral in kept.items():
            if not requested.issuperset(self._catalog.required_by([name])):
                integral.interrupt()
        names = [channel.name for channel in self.channels]
        self._steps = _steps(self._catalog, dict.fromkeys([*names, *self.totals]))

    def update(
        self,
        readings: Mapping[str, Reading],
        time: float,
        numbers: Mapping[str, float] | None = None,
        beside: Mapping[str, InstrumentReading | DerivedValue] = _NONE,
    ) -> dict[str, DerivedValue]:
        """Return the channels that have a value in a sample of `readings`.

        `numbers`: `numbers_of` them, if the caller needs these too. `beside`: values of instruments
        and of derived channels that are known; these are not computed again.
        """
        values: dict[str, _Value] = {**readings, **beside}
        known = numbers_of(readings) if numbers is None else {**numbers}
        known |= {name: each.value for name, each in beside.items()}
        for channel, calculation in self._steps:
            if channel.name in beside:
                continue
            if value := self._value(channel, calculation, values, known, time):
                values[channel.name] = value
                known[channel.name] = value.value
        derived = (values.get(channel.name) for channel in self.channels)
        return {each.name: each for each in derived if isinstance(each, DerivedValue)}

    def _value(
        self,
        channel: Derived,
        calculation: Calculation,
        values: Mapping[str, _Value],
        numbers: Mapping[str, float],
        time: float,
    ) -> DerivedValue | None:
        inputs = {name: values[name] for name in channel.inputs if name in values}
        if len(inputs) < len(channel.inputs):
            return None
        value, since, gaps = calculation.number(numbers), None, 0
        if isfinite(value) and (integral := self.totals.get(channel.name)):
            value = integral.add(time, value)
            since, gaps = integral.since, integral.gaps
        if not isfinite(value):
            return None
        return DerivedValue(channel, value, channel.unit, time, inputs, since, gaps)

    def columns(self, times: Column, readings: Mapping[str, Column]) -> dict[str, Column]:
        """Return the columns for rows of samples, each value as `update` gives it; NaN is missing.

        `readings`: by the parameter's name, corrected, as long as `times`; flags are 0 and 1.
        Calls follow each other in time, and totals continue from one to the next.
        """
        import numpy as np

        missing = np.full(len(times), nan)
        inputs = {name for channel, _ in self._steps for name in channel.inputs}
        values = {name: readings.get(name, missing) for name in inputs}
        for channel, calculation in self._steps:
            column = calculation.column(values)
            if integral := self.totals.get(channel.name):
                column = integral.add_column(times, column)
            values[channel.name] = column
        return {channel.name: values[channel.name] for channel in self.channels}


class Integral:
    """The `total` of one accumulating channel `since` its beginning, and its gaps.

    After an overflow the total stays NaN.
    """

    def __init__(self) -> None:
        self.total: float = 0.0
        self.since: float | None = None
        self.gaps: int = 0
        self._last: tuple[float, float] | None = None  # time and rate; None after a gap
        self._steps = 0.0, 0.0  # s, the last two, latest second; 0: unknown

    def interrupt(self) -> None:
        """Count a gap: the inputs are not requested any more."""
        if self._last is not None:
            self._last, self._steps = None, (0.0, 0.0)
            self.gaps += 1

    def add(self, time: float, rate: float) -> float:
        """Add the step to `time`; return the total."""
        if self._last is not None:
            before, rate_before = self._last
            step = time - before
            if 0 <= step <= max(_LONGEST, _ALIKE * min(self._steps)):
                self.total = _finite(self.total + (rate_before * 0.5 + rate * 0.5) * step)
            else:
                self.gaps += 1
            self._steps = self._steps[1], step
        self.since = time if self.since is None else self.since
        self._last = time, rate
        return self.total

    def add_column(self, times: Column, rates: Column) -> Column:
        """Return the total at each row, NaN where `rates` is NaN.

        The same operations as `add`, in the same order.
        """
        import numpy as np

        totals, rows = np.full(len(rates), nan), np.flatnonzero(np.isfinite(rates))
        at, rate = times[rows], rates[rows]
        if self._last is not None:
            at, rate = np.insert(at, 0, self._last[0]), np.insert(rate, 0, self._last[1])
        if len(rows):
            with np.errstate(all="ignore"):
                steps = np.diff(at)
                known = np.concatenate([self._steps, steps])
                longest = np.maximum(_LONGEST, _ALIKE * np.minimum(known[:-2], known[1:-1]))
                joined = (steps >= 0) & (steps <= longest)
                self._steps = float(known[-2]), float(known[-1])
                added = np.where(joined, (rate[:-1] * 0.5 + rate[1:] * 0.5) * steps, 0.0)
                running = np.add.accumulate(np.insert(added, 0, self.total))
            totals[rows] = running[len(running) - len(rows) :]
            self.total = _finite(float(running[-1]))
            self.since = float(at[0]) if self.since is None else self.since
            self.gaps += int(np.count_nonzero(~joined))
            self._last = float(at[-1]), float(rate[-1])
        return np.where(np.isfinite(totals), totals, nan)


def _finite(number: float) -> float:
    return number if isfinite(number) else nan


def number_of(value: Reading | DerivedValue) -> float:
    """Return the value in the corrected interpretation, which formulas and limits use."""
    if isinstance(value, Reading) and value.interpretation != "corrected":
        return float(value.parameter.decode(value.raw))
    return float(value.value)


def numbers_of(readings: Mapping[str, Reading]) -> dict[str, float]:
    """Return the `number_of` each reading of a sample."""
    return {
        name: float(each.value) if each.interpretation == "corrected" else number_of(each)
        for name, each in readings.items()
    }


def _steps(catalog: Catalog, names: Iterable[str]) -> list[tuple[Derived, Calculation]]:
    """Return the channels `names` and their derived inputs, inputs first."""
    return [(each, each.calculation()) for each in in_order(catalog.derived, list(names))]
