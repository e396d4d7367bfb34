"""Recordings of units that control the ignition alone (`catalog.ignition_only`), by their rows."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mikas.catalog.ignition_only import (
    RUNNING,
    SPEED,
    WITNESSES,
    InjectionWatch,
    absent_channels,
)

if TYPE_CHECKING:
    from mikas.recording.recording import Recording
    from mikas.recording.table.channels import Rows


class RowsInjectionWatch(InjectionWatch):
    """An `InjectionWatch` that takes columns; a speed holds until the next one."""

    def add_rows(self, rows: Rows) -> None:
        """Take rows that follow those before."""
        import numpy as np

        speed = rows.values.get(SPEED)
        rpm = np.full(len(rows.times), self._rpm)
        if speed is not None and len(rows.times):
            latest = np.maximum.accumulate(np.where(np.isfinite(speed), np.arange(speed.size), -1))
            rpm = np.where(latest >= 0, speed[latest], self._rpm)
            self._rpm = float(rpm[-1])
        for name in WITNESSES:
            if (column := rows.values.get(name)) is not None:
                there = np.isfinite(column) & (rpm >= RUNNING)
                alive = bool((there & np.not_equal(column, 0)).any())
                self.count(name, int(there.sum()), is_alive=alive)


def absent_in(recording: Recording) -> tuple[str, ...]:
    """Return the channels that the recorded unit does not have; none while that is not certain."""
    watch = RowsInjectionWatch()
    wanted = [name for name in (SPEED, *WITNESSES) if name in recording.catalog.channels]
    for rows in recording.interpreted("corrected", wanted).rows():
        watch.add_rows(rows)
        if watch.is_alive:
            return ()
    return absent_channels(recording.catalog) if watch.ignition_only else ()
