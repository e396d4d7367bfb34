"""A value is never bare (rule 5 of the architecture): it has its unit, bytes, time and decoding."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from mikas.catalog import Parameter
from mikas.errors import MikasError


@dataclass(frozen=True, slots=True)
class Reading:
    """One parameter, read once.

    `value` is in `unit`; `raw` the datum as it came, low byte first; `time` when the response began
    on the wire, in the link's clock (UNIX time on a real one); `reading` the sense in which it was
    decoded: the session's, or `corrected` for a parameter that has no such.
    """

    parameter: Parameter
    value: float | int | bool
    unit: str
    raw: bytes
    time: float
    interpretation: str

    @property
    def name(self) -> str:
        """The parameter's mnemonic."""
        return self.parameter.name

    def __str__(self) -> str:
        if self.parameter.is_flag:
            return f"{self.name} {'yes' if self.value else 'no'}"
        return f"{self.name} {self.value:.{self.parameter.decimals}f} {self.unit}".rstrip()


def decode(parameter: Parameter, raw: bytes, time: float, interpretation: str) -> Reading:
    """Decode `raw` into a reading."""
    conversion = parameter.interpretation(interpretation)
    taken = interpretation if interpretation in parameter.interpretations else "corrected"
    return Reading(parameter, conversion.decode(raw), conversion.unit, raw, time, taken)


@dataclass(frozen=True, slots=True)
class Sample:
    """The readings of one cycle of `watch`. A parameter that could not be read is missing.

    `gap`: nothing came, `error` says why. A value is never repeated from the cycle before.
    """

    time: float
    readings: Mapping[str, Reading] = field(default_factory=lambda: MappingProxyType({}))
    error: MikasError | None = None

    @property
    def gap(self) -> bool:
        """Whether nothing came; `error` then says why."""
        return self.error is not None
