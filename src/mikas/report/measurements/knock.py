"""Knock over the time covered: how often, at which speed, and how often the ignition was retarded.

The unit shows a knock for an eighth of a second (DET) and retards for some seconds after it (RDET),
so a tester that reads seldom sees the second alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from mikas.recording.table.channels import Rows

FAST: Final = 3000.0  # rpm; knock above it is hardly heard
_ENOUGH: Final = 50  # readings for a share
_OFTEN: Final = 0.2  # of the readings; a drive with some pulls at full load has less


@dataclass(frozen=True, slots=True)
class Knock:
    """`knocks`: how often the engine knocked, `fast`: above `FAST`. `retarded`: the readings with
    retard for knock, among the `readings` of a running engine.
    """

    knocks: int = 0
    fast: int = 0
    retarded: int = 0
    readings: int = 0

    @property
    def share(self) -> float | None:
        """The share of readings with retard; None with too few."""
        return self.retarded / self.readings if self.readings >= _ENOUGH else None

    @property
    def often_retarded(self) -> bool:
        """Whether the share alone needs attention."""
        return self.share is not None and self.share >= _OFTEN


class KnockCounter:
    """Counts over consecutive blocks of rows."""

    def __init__(self) -> None:
        self._knocks = self._fast = self._retarded = self._readings = 0
        self._is_set = False
        self._rpm = 0.0

    def add(self, rows: Rows) -> None:
        """Add rows."""
        rpm = self._speeds(rows)
        if (knock := rows.values.get("DET")) is not None:
            there = np.isfinite(knock)
            is_set = np.not_equal(knock[there], 0)
            if is_set.size:
                before = np.concatenate(([self._is_set], is_set[:-1]))
                begins = is_set & ~before
                self._knocks += int(begins.sum())
                self._fast += int((begins & (rpm[there] > FAST)).sum())
                self._is_set = bool(is_set[-1])
        if (retard := rows.values.get("RDET")) is not None:
            running = np.isfinite(retard) & (rpm > 0)
            self._readings += int(running.sum())
            self._retarded += int((running & np.not_equal(retard, 0)).sum())

    @property
    def found(self) -> Knock:
        """The totals so far."""
        return Knock(self._knocks, self._fast, self._retarded, self._readings)

    def _speeds(self, rows: Rows) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """Return the speed at each row: the last one read."""
        size = len(rows.times)
        column = rows.values.get("FREQ")
        if column is None:
            return np.full(size, self._rpm)
        latest = np.maximum.accumulate(np.where(np.isfinite(column), np.arange(size), -1))
        rpm = np.where(latest >= 0, column[latest], self._rpm)
        if size:
            self._rpm = float(rpm[-1])
        return rpm
