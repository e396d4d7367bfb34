"""Limits that alarm, their levels, and how well a statement of the catalog is known."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from math import isfinite

from mikas.errors import usage_error


class Confidence(StrEnum):
    """How well a statement is known."""

    CONFIRMED = "confirmed"
    """Two independent public sources."""
    REPORTED = "reported"
    """One source."""
    UNCONFIRMED = "unconfirmed"
    """Commonly printed, no source seen."""
    UNKNOWN = "unknown"
    """Only the number is shown."""


class Level(StrEnum):
    """The severity of an alarm."""

    NONE = "none"
    """No alarm."""
    WARNING = "warning"
    """To be watched."""
    DANGER = "danger"
    """To stop for."""


LIMITS = ("danger_low", "warning_low", "warning_high", "danger_high")
"""The limits from the lowest to the highest."""


@dataclass(frozen=True, slots=True)
class AlarmLimits:
    """Alarm limits in the unit of the corrected interpretation; None: no such limit.

    An alarm ends when the value is back inside by `hysteresis`. `when_true` is for a flag, which
    has no other limits. UsageError: the limits are not in order, or leave no range between them.
    """

    danger_low: float | None = None
    """Below it is danger."""
    warning_low: float | None = None
    """Below it is a warning."""
    warning_high: float | None = None
    """Above it is a warning."""
    danger_high: float | None = None
    """Above it is danger."""
    hysteresis: float = 0
    """By how much it has to be back inside."""
    when_true: Level = Level.NONE
    """The level of a flag that is set."""
    source: str = ""
    """Where the limits are from."""
    confidence: Confidence = Confidence.UNCONFIRMED
    """How well they are known."""

    def __post_init__(self) -> None:
        given = [(name, limit) for name in LIMITS if (limit := getattr(self, name)) is not None]
        for name, number in (*given, ("hysteresis", self.hysteresis)):
            if not isfinite(number):
                raise usage_error(f"{name} is no finite number", f"{name} — не конечное число")
        if self.hysteresis < 0:
            raise usage_error("hysteresis is below 0", "hysteresis меньше 0")
        for (lower, low), (upper, high) in pairwise(given):
            across = lower.endswith("low") and upper.endswith("high")
            if low > high or (across and low + self.hysteresis >= high):
                more = " and the hysteresis" if across else ""
                raise usage_error(
                    f"{upper} {high:g} must be above {lower} {low:g}{more}",
                    f"{upper} {high:g} должен быть выше {lower} {low:g}"
                    + (" с учётом hysteresis" if across else ""),
                )

    @property
    def lows(self) -> tuple[tuple[Level, float], ...]:
        """The existing low limits, the mildest first."""
        return _present((Level.WARNING, self.warning_low), (Level.DANGER, self.danger_low))

    @property
    def highs(self) -> tuple[tuple[Level, float], ...]:
        """The existing high limits, the mildest first."""
        return _present((Level.WARNING, self.warning_high), (Level.DANGER, self.danger_high))

    @property
    def for_number(self) -> bool:
        """Whether a number can cross a limit."""
        return bool(self.lows or self.highs)

    @property
    def for_flag(self) -> bool:
        """Whether a flag can raise the alarm."""
        return self.when_true is not Level.NONE


def _present(*limits: tuple[Level, float | None]) -> tuple[tuple[Level, float], ...]:
    return tuple((level, limit) for level, limit in limits if limit is not None)
