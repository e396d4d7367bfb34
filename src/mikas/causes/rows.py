"""Samples of rows, recorded or live: thinned to the rate that the tables were made at.

Rows come with one value each (61) or with all (71), up to 35 a second and by strokes more. Each bin
of `PERIOD` becomes one sample, with the last value that each channel has in it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import floor, isnan, nan
from typing import TYPE_CHECKING, Final

from mikas.cancellation import check_cancelled
from mikas.catalog.ignition_only import DEAD, RUNNING, SPEED, WITNESSES, InjectionWatch
from mikas.causes.samples import Samples, samples_of

if TYPE_CHECKING:
    from mikas.recording.table.channels import Rows

PERIOD: Final = 0.2  # s
CHANNELS: Final = (
    "FREQ", "FREQX", "THR", "RXX", "TWAT", "TAIR", "UACC", "JAIR", "UGB", "JQT", "SSM", "FSM",
    "RCOK", "UOZ", "UOZOC", "DET", "INJ",
)  # fmt: skip
"""The channels that features are made of, and those that show a unit without injection."""


def samples_of_rows(stretches: Iterable[Rows]) -> list[Samples]:
    """Return the samples of one port's rows; where time runs back, others begin."""
    found: list[Samples] = []
    times: list[float] = []
    columns: dict[str, list[float]] = {name: [] for name in CHANNELS}
    for rows in stretches:
        check_cancelled()
        stamps = rows.times.tolist()
        if not stamps:
            continue
        if times and stamps[0] < times[-1]:
            found.append(samples_of(times, columns))
            times, columns = [], {name: [] for name in CHANNELS}
        last = _last_of_bins(stamps)
        times += [stamps[row] for row in last]
        missing = [nan] * len(last)
        for name, column in columns.items():
            values = rows.values.get(name)
            column.extend(missing if values is None else _thinned(values.tolist(), last))
    if times:
        found.append(samples_of(times, columns))
    return found


def _last_of_bins(times: Sequence[float]) -> list[int]:
    """Return the number of the last row in each bin; where time runs back, a bin ends."""
    bins = [floor(time / PERIOD) for time in times]
    rows = [row for row in range(len(bins) - 1) if bins[row] != bins[row + 1]]
    return [*rows, len(bins) - 1]


def _thinned(values: Sequence[float], last: Sequence[int]) -> list[float]:
    """Return the last value of each bin; NaN without one."""
    found = []
    begin = 0
    for row in last:
        value = values[row]
        at = row
        while isnan(value) and at > begin:
            at -= 1
            value = values[at]
        found.append(value)
        begin = row + 1
    return found


def unserved(samples: Iterable[Samples], watch: InjectionWatch | None = None) -> frozenset[str]:
    """Return the channels that mean nothing, if this is a unit that controls the ignition alone.

    `watch`: has counted earlier samples of the unit, and counts these too.
    """
    watch = watch or InjectionWatch()
    for each in samples:
        speed = each.column(SPEED)
        if speed is None:
            continue
        running = [row for row, value in enumerate(speed) if value >= RUNNING]
        for name in WITNESSES:
            column = each.column(name)
            if column is not None:
                values = [value for row in running if not isnan(value := column[row])]
                watch.count(name, len(values), is_alive=any(value != 0 for value in values))
    return DEAD if watch.ignition_only else frozenset()
