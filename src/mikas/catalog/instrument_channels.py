"""Channels that instruments beside the unit give: λ, speed, position. No request brings them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from mikas.catalog.conversion import NO_TEXT
from mikas.catalog.limits import AlarmLimits, Confidence
from mikas.i18n import Text


def with_label(name: str, label: str) -> str:
    """Return a channel's name with the label of its instrument: `LAMBDA_LEFT`."""
    return f"{name}_{label.upper()}"


def is_labelled(channel: str, name: str) -> bool:
    """Return whether `channel` is `name`, or that with a label."""
    return channel == name or channel.startswith(f"{name}_")


@dataclass(frozen=True, slots=True)
class InstrumentChannel:
    """A number that an instrument gives. `range`: a value outside of it is damage of the line.

    `short`, `gauge` and `span_least`: as of a parameter.
    """

    name: str
    """The mnemonic, in capitals: `LAMBDA`."""
    text: Text
    """Its name for a person."""
    short: Text = NO_TEXT
    """The text of a small tile."""
    unit: str = ""
    """The key of the unit."""
    unit_text: Text = NO_TEXT
    """The unit for display."""
    decimals: int = 2
    """Digits after the point."""
    range: tuple[float, float] | None = None
    """The values that the instrument can give; None: any."""
    gauge: tuple[float, float] | None = None
    """The scale of a gauge."""
    span_least: float | None = None
    """The least span of an axis."""
    alarm_limits: AlarmLimits | None = None
    """The limits that alarm."""
    source: str = ""
    """Where the definition is from."""
    confidence: Confidence = Confidence.UNKNOWN
    """How well it is known."""
    is_flag: ClassVar[bool] = False
    """False: its values are numbers."""

    def takes(self, value: float) -> bool:
        """Return whether the instrument can have given this value."""
        return self.range is None or self.range[0] <= value <= self.range[1]
