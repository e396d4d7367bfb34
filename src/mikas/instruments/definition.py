"""What an instrument is: its decoder, its port's speed, its channels, in a TOML file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from mikas.catalog.instrument_channels import InstrumentChannel, with_label
from mikas.catalog.limits import Confidence
from mikas.i18n import Text

STOICHIOMETRIC: Final = 14.7
"""Kilograms of air that burn a kilogram of petrol."""


@dataclass(frozen=True, slots=True)
class InstrumentDefinition:
    """One instrument, as its file says. `docs/how-to/instruments.md` has the keys."""

    name: str
    """The file's name without `.toml`: `aem`."""
    text: Text
    """The instrument's name for a person."""
    decoder: str
    """`line`, `nmea`, `isp2`, `gpsd`, or the name of another distribution's."""
    channels: tuple[InstrumentChannel, ...]
    """The channels that it gives."""
    baud: int = 9600
    """Bits a second of its serial port."""
    patterns: tuple[str, ...] = ()
    """Of a `line`: the first that fits decides."""
    decimal: str = "."
    """The sign between the parts of a number in a line."""
    stoichiometric: float = STOICHIOMETRIC
    """The air-fuel ratio at λ = 1, to give λ and the ratio where it sends one of them."""
    stale: float = 1.0
    """Seconds that a value holds."""
    source: str = ""
    """Where the definition is from."""
    confidence: Confidence = Confidence.UNCONFIRMED
    """How well it is known."""
    toml: str = field(default="", repr=False)
    """The file's text, which a recording keeps."""

    def labelled(self, label: str) -> InstrumentDefinition:
        """Return the same with the label at the end of each channel's name: `LAMBDA_LEFT`."""
        if not label:
            return self
        channels = tuple(
            replace(
                each,
                name=with_label(each.name, label),
                text=Text(f"{each.text.en}, {label}", f"{each.text.ru}, {label}"),
                short=Text(f"{each.short.en}, {label}", f"{each.short.ru}, {label}"),
            )
            for each in self.channels
        )
        return replace(self, channels=channels)

    def completed(self, values: Mapping[str, float]) -> Mapping[str, float]:
        """Return the values with λ of the ratio, or the ratio of λ, where one is missing."""
        if "LAMBDA" in values and "AFR" not in values:
            return {**values, "AFR": values["LAMBDA"] * self.stoichiometric}
        if "AFR" in values and "LAMBDA" not in values:
            return {**values, "LAMBDA": values["AFR"] / self.stoichiometric}
        return values
