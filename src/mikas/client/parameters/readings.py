"""Values of parameters: a `Reading`, how it is decoded, and the sample of one cycle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from mikas import errors
from mikas.catalog import Conversion, Parameter
from mikas.client.parameters.data import RawDatum, distinct
from mikas.commands import Datum
from mikas.i18n import Text, unit_after
from mikas.tester import StreamItem


@dataclass(frozen=True, slots=True)
class Reading:
    """One value of a parameter, with unit, bytes, time and interpretation.

    `raw`: the datum as received, low byte first. `time`: the start of the response on the wire, in
    the link's clock. `interpretation`: the session's, or `corrected` if the parameter lacks that.
    """

    parameter: Parameter
    """The definition that decoded it."""
    value: float | int | bool
    """The value: True or False of a flag, else a number."""
    unit: str
    """The key of the unit, `rpm`; empty: it has none."""
    raw: bytes
    time: float
    interpretation: str

    @property
    def name(self) -> str:
        """The parameter's mnemonic."""
        return self.parameter.name

    @property
    def channel(self) -> Parameter:
        """The parameter, as of a `DerivedValue` its channel."""
        return self.parameter

    @property
    def shown(self) -> Text:
        """The value with its unit, as people write it: `13.5 °`, `13,5 °`; a flag as yes or no."""
        if self.parameter.is_flag:
            return Text("yes", "да") if self.value else Text("no", "нет")
        number = f"{self.value:.{self.parameter.decimals}f}"
        return with_unit(number, self.parameter.interpretation(self.interpretation).unit_text)

    def __repr__(self) -> str:
        """Return it on one line: a notebook shows a whole dict of them."""
        used = "" if self.interpretation == "corrected" else f", {self.interpretation}"
        return f"<Reading {self}: raw {self.raw.hex().upper()}, {self.time:.3f} s{used}>"

    def __str__(self) -> str:
        if self.parameter.is_flag:
            return f"{self.name} {'yes' if self.value else 'no'}"
        return f"{self.name} {self.value:.{self.parameter.decimals}f} {self.unit}".rstrip()


def decode(parameter: Parameter, raw: bytes, time: float, interpretation: str) -> Reading:
    """Decode `raw` into a reading."""
    conversion, used = _conversion(parameter, interpretation)
    return Reading(parameter, conversion.decode(raw), conversion.unit, raw, time, used)


def _conversion(parameter: Parameter, interpretation: str) -> tuple[Conversion, str]:
    has_it = interpretation in parameter.interpretations
    used = interpretation if has_it else "corrected"
    return parameter.interpretation(interpretation), used


class Wanted:
    """Parameters that are read together: their data, each code once, and how each is decoded.

    Made once for many cycles. Raises `UsageError` for a code with two sizes.
    """

    def __init__(self, parameters: Sequence[Parameter], interpretation: str) -> None:
        self.parameters: tuple[Parameter, ...] = tuple(parameters)
        self.data: tuple[Datum, ...] = distinct(self.parameters)
        places = {datum.code: place for place, datum in enumerate(self.data)}
        self._decoded = [
            (each.name, each.code, places[each.code], each, *_conversion(each, interpretation))
            for each in self.parameters
        ]

    def readings(self, got: Mapping[int, RawDatum]) -> dict[str, Reading]:
        """Decode the parameters whose code is in `got`."""
        return {
            name: Reading(
                each, conversion.decode(datum.raw), conversion.unit, datum.raw, datum.time, used
            )
            for name, code, _, each, conversion, used in self._decoded
            if (datum := got.get(code)) is not None
        }

    def of_item(self, item: StreamItem) -> dict[str, Reading]:
        """Decode one streamed response, which has all data in their order."""
        data, time = item.data, item.time
        return {
            name: Reading(
                each, conversion.decode(data[place]), conversion.unit, data[place], time, used
            )
            for name, _, place, each, conversion, used in self._decoded
        }


@dataclass(frozen=True, slots=True)
class Sample:
    """The readings of one cycle of `watch`. A parameter that could not be read is missing."""

    time: float
    """The start of the first response on the link's clock; of a gap its end."""
    readings: Mapping[str, Reading] = field(default_factory=lambda: MappingProxyType({}))
    """The readings by name."""
    error: errors.MikasError | None = None
    """Why the cycle failed; None: it did not."""

    @property
    def gap(self) -> bool:
        """Whether the cycle failed; `error` is the reason."""
        return self.error is not None


def with_unit(number: str, unit: Text) -> Text:
    """Return a number and its unit as people write them: `13.5 °`, `13,5 °`."""
    value = Text(number, number.replace(".", ","))
    unit = unit_after(value, unit)
    return Text(f"{value.en} {unit.en}".rstrip(), f"{value.ru} {unit.ru}".rstrip())
