"""The states of an engine in which its values can be compared, drive by drive.

Warm idle is the report's (`report/measurements/warm_idle.py`). Two more are for parts that idle
does not show: `above-idle` for the charging, and `warmed-up` for the thermostat, which also holds
for an engine that does not become warm.
"""

from __future__ import annotations

from enum import StrEnum
from math import inf
from typing import TYPE_CHECKING, Final

import numpy as np

from mikas.catalog import Catalog
from mikas.i18n import Text
from mikas.recording.table.channels import Rows
from mikas.report.measurements.statistics import ChannelStatistics, ValueCounts
from mikas.report.measurements.warm_idle import PAUSE, ChannelWatch, IdleRule

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Mask = NDArray[np.bool_]

COOLANT: Final = "TWAT"
VOLTAGE: Final = "UACC"
SPEED: Final = "FREQ"
WARMED_UP: Final = 600.0  # s of running
COLD: Final = 40.0  # °C from which the warm-up is timed …
WARM: Final = 70.0  # … to this
RUNNING: Final = IdleRule(Text("400 rpm or more", "не ниже 400 об/мин"), (SPEED,), 400, inf, PAUSE)
ABOVE_IDLE: Final = IdleRule(
    Text("1500 rpm or more", "не ниже 1500 об/мин"), (SPEED,), 1500, inf, PAUSE
)


class DriveState(StrEnum):
    """A state of the engine in a drive."""

    ALL = "all"  # whatever it did
    WARM_IDLE = "warm-idle"
    ABOVE_IDLE = "above-idle"
    WARMED_UP = "warmed-up"


class StateCollector:
    """Collects the values of some channels by state, and the warm-up, over the rows of a drive."""

    def __init__(self, catalog: Catalog) -> None:
        self._running = ChannelWatch(RUNNING, SPEED)
        self._above = ChannelWatch(ABOVE_IDLE, SPEED)
        self._counts = {
            (VOLTAGE, DriveState.ABOVE_IDLE): ValueCounts(catalog.channel(VOLTAGE).decimals + 1),
            (COOLANT, DriveState.WARMED_UP): ValueCounts(catalog.channel(COOLANT).decimals + 1),
        }
        self._last = -inf  # the last row's time
        self._run = 0.0  # s that the engine has run
        self.coolant_first: float | None = None
        self._cold_at: float | None = None  # s of running at which the coolant passed `COLD`
        self.warm_up: float | None = None

    def add(self, rows: Rows) -> None:
        """Add rows, parameters in the corrected interpretation."""
        times = rows.times
        if not times.size:
            return
        steps = np.diff(times, prepend=self._last)
        _, runs = self._running.look(rows)
        _, above = self._above.look(rows)
        counted = runs & (steps >= 0) & (steps <= PAUSE)
        run = self._run + np.cumsum(np.where(counted, steps, 0.0))
        self._last, self._run = float(times[-1]), float(run[-1])
        if (voltage := rows.values.get(VOLTAGE)) is not None:
            self._counts[VOLTAGE, DriveState.ABOVE_IDLE].add(voltage[above])
        if (coolant := rows.values.get(COOLANT)) is not None:
            settled = runs & (run >= WARMED_UP)
            self._counts[COOLANT, DriveState.WARMED_UP].add(coolant[settled])
            self._time_warm_up(coolant, run)

    def statistics(self) -> dict[tuple[str, DriveState], ChannelStatistics]:
        """Return the statistics of the states that had values."""
        found = {key: counts.stats() for key, counts in self._counts.items()}
        return {key: stats for key, stats in found.items() if stats is not None}

    def _time_warm_up(self, coolant: NDArray[np.float64], run: NDArray[np.float64]) -> None:
        there = np.flatnonzero(np.isfinite(coolant))
        if not there.size or self.warm_up is not None:
            return
        values = coolant[there]
        if self.coolant_first is None:
            self.coolant_first = float(values[0])
        if self.coolant_first >= COLD:
            return
        if self._cold_at is None:
            self._cold_at = _first(run[there], values >= COLD)
        warm = _first(run[there], values >= WARM)
        if self._cold_at is not None and warm is not None:
            self.warm_up = warm - self._cold_at


def _first(run: NDArray[np.float64], holds: Mask) -> float | None:
    return float(run[int(holds.argmax())]) if holds.any() else None
