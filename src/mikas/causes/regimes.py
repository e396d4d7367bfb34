"""Regimes: what the engine did in each row, by the unit's own values.

Key on, cranking, starting (the first seconds of running), idle (cold, warm), part load, full load,
overrun. The throttle counts as closed near the least that this drive has, so that a throttle that
does not close still has an idle. But the least of a drive may be a pedal that was never let go: an
opening counts as the closed throttle only if something shows that the foot was off (`_let_go`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from math import isnan, nan
from typing import Final

from mikas.causes.samples import PAUSE, Column, Samples, quantile, spans_of

RUNNING: Final = 500.0  # rpm
STARTED: Final = 12.0  # s after a start: enrichment and high idle fade
SETTLING: Final = 4.0  # s that throttle and speed are steady before idle counts
COLD: Final = 60.0
WARM: Final = 68.0
CLOSED: Final = 0.8  # % above the least opening
OPEN: Final = 2.0
FULL: Final = 60.0
STEADY: Final = 260.0  # rpm within `SETTLING`
SILENT: Final = 4.0  # s without a reading, after which an engine that stands was switched off
IDLING: Final = 0.02  # kg/h of air a rpm: more is a load
RESTING: Final = 8.0  # s at one opening, as a foot that holds a speed seldom rests
SWINGING: Final = 30.0  # s of a speed that never holds, with the throttle closed
SWINGS: Final = 4  # rises meanwhile
COASTED: Final = 1.4  # times the speed between which a closed throttle is seen


class Regime(StrEnum):
    """What the engine does."""

    KEY_ON = "key-on"
    CRANKING = "cranking"
    STARTING = "starting"
    COLD_IDLE = "cold-idle"
    MILD_IDLE = "mild-idle"
    WARM_IDLE = "warm-idle"
    PART_LOAD = "part-load"
    FULL_LOAD = "full-load"
    OVERRUN = "overrun"
    OTHER = "other"


@dataclass(frozen=True, slots=True)
class DriveByRegime:
    """Samples with the regime of each row. `starts`: rows in which the engine began to run.

    `run_time`: seconds of running so far, NaN while it stands; `closed`: the closed throttle, %,
    0 if the pedal was never let go (`let_go`). `unsettled`: rows of a closed throttle at a speed
    that never held, so that they are no idle.
    """

    samples: Samples
    speed: Column
    rows: Mapping[Regime, Sequence[int]]
    running: Sequence[int]
    starts: Sequence[int]
    stalls: Sequence[int]
    run_time: Column
    closed: float
    let_go: bool
    unsettled: Sequence[int]

    def at(self, *regimes: Regime) -> list[int]:
        """Return the rows of these regimes, rising."""
        if len(regimes) == 1:
            return list(self.rows[regimes[0]])
        return sorted(row for regime in regimes for row in self.rows[regime])


def drive_of(samples: Samples) -> DriveByRegime | None:
    """Return the samples by regime; None: the engine's speed was not read."""
    speed = _speed(samples)
    if speed is None:
        return None
    times = samples.times
    throttle = samples.column("THR")
    idle_flag = samples.column("RXX")
    coolant = samples.column("TWAT")
    run_time, starts, stalls = _run_time(times, speed)
    running = [row for row, rpm in enumerate(speed) if rpm >= RUNNING]
    closed, let_go = _closed(samples, speed, running)
    rows: dict[Regime, list[int]] = {regime: [] for regime in Regime}
    shut = [_shut(row, throttle, idle_flag, closed) for row in range(len(times))]
    steady = _steady(times, speed, shut)
    unsettled: list[int] = []
    for row, rpm in enumerate(speed):
        if isnan(rpm):
            continue
        warmth = coolant[row] if coolant is not None else nan
        opening = throttle[row] - closed if throttle is not None else nan
        if rpm < RUNNING:
            regime = _standing(rpm, run_time[row])
        elif run_time[row] < STARTED:
            regime = Regime.STARTING
        elif shut[row]:
            regime = _closed_throttle(rpm, warmth, settled=steady[row])
            if not steady[row]:
                unsettled.append(row)
        else:
            regime = _under_load(rpm, opening, closed)
        rows[regime].append(row)
    return DriveByRegime(
        samples, speed, rows, running, starts, stalls, run_time, closed, let_go, unsettled
    )


def swings(drive: DriveByRegime) -> tuple[float, float] | None:
    """Return the speeds between which the engine went up and down with the throttle closed, for so
    long and so often that it is no driver's doing; None: it did not.
    """
    times = drive.samples.times
    for begin, end in spans_of(times, drive.unsettled):
        if end - begin < SWINGING:
            continue
        speeds = [drive.speed[row] for row in drive.unsettled if begin <= times[row] <= end]
        low, high = quantile(speeds, 0.05), quantile(speeds, 0.95)
        middle = (low + high) / 2
        rises = sum(a < middle <= b for a, b in pairwise(speeds))
        if rises >= SWINGS:
            return low, high
    return None


def _closed(samples: Samples, speed: Column, running: Sequence[int]) -> tuple[float, bool]:
    """Return the opening of the closed throttle, and whether it was seen."""
    throttle = samples.column("THR")
    opened = [throttle[row] for row in running if not isnan(throttle[row])] if throttle else []
    if throttle is None or not opened:
        return 0.0, False
    least = quantile(opened, 0.02)
    shut = [row for row, value in enumerate(throttle) if value <= least + CLOSED]
    if least <= CLOSED or _let_go(samples, speed, shut, max(opened) - least):
        return least, True
    return 0.0, False


def _let_go(samples: Samples, speed: Column, shut: Sequence[int], moved: float) -> bool:
    """Whether the foot was off the pedal in these rows, those of the least opening.

    It was, if the engine stood then, if the unit saw the closed throttle, if the engine ran down at
    this opening, as a pedal that holds a speed never lets it, or if it stayed there and took no
    more air than an engine without a load.
    """
    flag, air = samples.column("RXX"), samples.column("JAIR")
    if any(speed[row] < RUNNING or (flag is not None and flag[row] == 1) for row in shut):
        return True
    speeds = [speed[row] for row in shut if not isnan(speed[row])]
    if quantile(speeds, 0.95) >= COASTED * quantile(speeds, 0.05):
        return True
    if air is None:
        return moved <= OPEN
    for begin, end in spans_of(samples.times, shut):
        here = [row for row in shut if begin <= samples.times[row] <= end]
        taken = [each for row in here if not isnan(each := air[row] / speed[row])]
        if end - begin >= RESTING and taken and quantile(taken, 0.9) <= IDLING:
            return True
    return False


def _speed(samples: Samples) -> Column | None:
    """Return rpm: the coarse speed above 2000 rpm, below it the idle speed's finer one."""
    coarse, fine = samples.column("FREQ"), samples.column("FREQX")
    if coarse is None or fine is None:
        return coarse or fine
    return [b if b < 2000 and not isnan(b) else a for a, b in zip(coarse, fine, strict=True)]


def _run_time(times: Column, speed: Column) -> tuple[Column, list[int], list[int]]:
    result, starts, stalls = [], [], []
    began = nan  # when the engine began to run; before the first row: long ago
    known = False  # whether a start was seen
    last = ran = nan
    for row, (time, rpm) in enumerate(zip(times, speed, strict=True)):
        if not isnan(last) and time - last > 30.0:
            known, began = False, nan
        last = time
        if rpm >= RUNNING:
            if isnan(began):
                began = time if known else time - 1000.0
                if known:
                    starts.append(row)
            result.append(time - began)
            ran = time
            continue
        if rpm < 40:
            # A unit that was silent meanwhile lost its key: that is no stall.
            if not isnan(began) and time - began > 3.0 and time - ran <= SILENT:
                stalls.append(row)
            known, began = True, nan
        elif isnan(began):
            known = True
        result.append(nan if isnan(began) else time - began)
    return result, starts, stalls


def _shut(row: int, throttle: Column | None, flag: Column | None, closed: float) -> bool:
    if throttle is not None and not isnan(throttle[row]):
        return throttle[row] <= closed + CLOSED
    return flag is not None and flag[row] == 1


def _steady(times: Column, speed: Column, shut: Sequence[bool]) -> list[bool]:
    """Return where throttle and speed have been steady for `SETTLING` seconds."""
    result = []
    begin = low = 0  # since when it is shut without a pause; the first row of the window
    for row, time in enumerate(times):
        paused = row > 0 and time - times[row - 1] > PAUSE
        if not shut[row] or isnan(speed[row]) or paused:
            begin = row + (not shut[row])
        low = max(low, begin)
        while low < row and times[low] < time - SETTLING:
            low += 1
        window = speed[low : row + 1]
        settled = row > begin and time - times[begin] >= SETTLING
        result.append(settled and max(window) - min(window) <= STEADY)
    return result


def _standing(rpm: float, run_time: float) -> Regime:
    """Return the regime below the speed of a running engine: a dying one is none."""
    if rpm < 40:
        return Regime.KEY_ON
    return Regime.CRANKING if isnan(run_time) else Regime.OTHER


def _closed_throttle(rpm: float, warmth: float, *, settled: bool) -> Regime:
    if not settled or rpm >= 2600:
        return Regime.OVERRUN if rpm > 1600 else Regime.OTHER
    if warmth < COLD:
        return Regime.COLD_IDLE
    return Regime.MILD_IDLE if warmth < WARM else Regime.WARM_IDLE


def _under_load(rpm: float, opening: float, closed: float) -> Regime:
    if opening + closed >= FULL:
        return Regime.FULL_LOAD
    return Regime.PART_LOAD if opening >= OPEN and rpm > 1100 else Regime.OTHER
