"""Limits whose crossing is an alarm, of a parameter or of a derived channel."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from math import isfinite

from mikas.catalog.confidence import Confidence
from mikas.errors import UsageError
from mikas.i18n import Text


class Level(StrEnum):
    """How bad it is."""

    NONE = "none"
    WARNING = "warning"
    DANGER = "danger"


LIMITS = ("danger_low", "warning_low", "warning_high", "danger_high")
"""The limits from the lowest to the highest."""


@dataclass(frozen=True, slots=True)
class AlarmLimits:
    """Beyond a limit is an alarm; back inside by `hysteresis`, it is over. None: no such limit.

    In the unit of the corrected reading. `when_true` is for a flag, which has no other limits.
    UsageError: the limits are not in order, or leave nothing between them.
    """

    danger_low: float | None = None
    warning_low: float | None = None
    warning_high: float | None = None
    danger_high: float | None = None
    hysteresis: float = 0
    when_true: Level = Level.NONE
    source: str = ""
    confidence: Confidence = Confidence.UNCONFIRMED

    def __post_init__(self) -> None:
        given = [(name, limit) for name in LIMITS if (limit := getattr(self, name)) is not None]
        for name, number in (*given, ("hysteresis", self.hysteresis)):
            if not isfinite(number):
                raise _wrong(f"{name} is no finite number", f"{name} — не конечное число")
        if self.hysteresis < 0:
            raise _wrong("hysteresis is below 0", "hysteresis меньше 0")
        for (lower, low), (upper, high) in pairwise(given):
            across = lower.endswith("low") and upper.endswith("high")
            if low > high or (across and low + self.hysteresis >= high):
                more = " and the hysteresis" if across else ""
                raise _wrong(
                    f"{upper} {high:g} must be above {lower} {low:g}{more}",
                    f"{upper} {high:g} должен быть выше {lower} {low:g}"
                    + (" с учётом hysteresis" if across else ""),
                )

    @property
    def lows(self) -> tuple[tuple[Level, float], ...]:
        """The low limits that there are, the mildest first."""
        return _present((Level.WARNING, self.warning_low), (Level.DANGER, self.danger_low))

    @property
    def highs(self) -> tuple[tuple[Level, float], ...]:
        """The high limits that there are, the mildest first."""
        return _present((Level.WARNING, self.warning_high), (Level.DANGER, self.danger_high))

    @property
    def for_number(self) -> bool:
        """Whether there is a limit that only a number can cross."""
        return bool(self.lows or self.highs)

    @property
    def for_flag(self) -> bool:
        """Whether `when_true` alarms."""
        return self.when_true is not Level.NONE


def _present(*limits: tuple[Level, float | None]) -> tuple[tuple[Level, float], ...]:
    return tuple((level, limit) for level, limit in limits if limit is not None)


def _wrong(en: str, ru: str) -> UsageError:
    return UsageError(problem=Text(en, ru))
