"""The sums of a stretch of time, from the curves of one session."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from mikas.drives.curves import CurveIntervals, SampledCurve
from mikas.drives.trip import Trip
from mikas.recording.exchanges.arrays import Floats, Mask

STANDING: Final = 3.0  # km/h: a receiver on a roof that stands still shows up to 1
IDLE_SPEED: Final = 1900.0  # rpm, of a cold engine too; above it the car coasts in gear


@dataclass(frozen=True, slots=True)
class DriveCurves:
    """The curves of one session of one port. None: the channel was not recorded.

    `fuel_from`: the channel of the fuel flow. `idle`: the unit's own flag, RXX.
    """

    session: int
    rpm: SampledCurve
    fuel: SampledCurve | None = None
    fuel_from: str | None = None
    speed: SampledCurve | None = None
    idle: SampledCurve | None = None

    def trip(self, begin: float, end: float) -> Trip:
        """Return the sums from `begin` to `end`, of a time in which the engine runs."""
        curves = [each for each in (self.rpm, self.fuel, self.speed, self.idle) if each is not None]
        edges = _edges([each.times for each in curves], begin, end)
        steps = np.diff(edges)
        rpm = self.rpm.over(edges)
        fuel, speed, idle = (
            None if each is None else each.over(edges)
            for each in (self.fuel, self.speed, self.idle)
        )
        fuel_seconds, litres = _integral(fuel, steps, 3600)
        speed_seconds, kilometres = _integral(speed, steps, 3600)
        rpm_seconds, turns = _integral(rpm, steps, 60)
        shared_litres = shared_kilometres = 0.0
        if fuel is not None and speed is not None:
            both = fuel.known & speed.known
            shared_litres = _sum(fuel.means, both, steps) / 3600
            shared_kilometres = _sum(speed.means, both, steps) / 3600
        stood, is_known = _standing(rpm, speed, idle, len(steps))
        idle_known = float(steps[is_known].sum())
        return Trip(
            session=self.session,
            begin=begin,
            end=end,
            seconds=end - begin,
            rpm_seconds=rpm_seconds,
            turns=turns,
            highest_rpm=_highest(rpm),
            fuel_seconds=fuel_seconds,
            litres=litres if fuel_seconds else None,
            litres_from=self.fuel_from if fuel_seconds else None,
            speed_seconds=speed_seconds,
            kilometres=kilometres if speed_seconds else None,
            highest_speed=_highest(speed),
            idle_known=idle_known,
            idle_seconds=float(steps[stood].sum()) if idle_known else None,
            shared_litres=shared_litres,
            shared_kilometres=shared_kilometres,
        )


def _edges(times: list[Floats], begin: float, end: float) -> Floats:
    """Return `begin`, all times between, and `end`."""
    ends = np.array([begin, end])
    inside: list[Floats] = []
    for each in times:
        # A recording may have thousands of drives: none looks at all rows.
        first, last = np.searchsorted(each, ends).tolist()
        part = each[first:last]
        inside.append(part[part > begin])
    inner = np.unique(np.concatenate(inside))
    edges: Floats = np.concatenate((np.array([begin]), inner, np.array([end])))
    return edges


def _integral(intervals: CurveIntervals | None, steps: Floats, unit: float) -> tuple[float, float]:
    """Return the seconds in which the curve is known, and its integral over them."""
    if intervals is None:
        return 0.0, 0.0
    known = intervals.known
    return float(steps[known].sum()), _sum(intervals.means, known, steps) / unit


def _sum(means: Floats, chosen: Mask, steps: Floats) -> float:
    return float((means[chosen] * steps[chosen]).sum())


def _highest(intervals: CurveIntervals | None) -> float | None:
    if intervals is None:
        return None
    known = intervals.known
    if not known.any():
        return None
    return max(float(intervals.begins[known].max()), float(intervals.ends[known].max()))


def _standing(
    rpm: CurveIntervals, speed: CurveIntervals | None, idle: CurveIntervals | None, count: int
) -> tuple[Mask, Mask]:
    """Return the intervals in which the car stood, and those of which that is known.

    By the road speed; where that is unknown by the unit's flag and a low speed of the engine.
    """
    none = np.zeros(count, np.bool_)
    by_speed = none if speed is None else speed.known
    stood = none if speed is None else by_speed & (np.where(by_speed, speed.most, 0.0) < STANDING)
    if idle is None:
        return stood, by_speed
    by_flag = idle.known & rpm.known & ~by_speed
    low = np.where(by_flag, rpm.most, 0.0) < IDLE_SPEED
    flagged = np.where(by_flag, idle.first, 0.0) > 0
    return stood | (by_flag & low & flagged), by_speed | by_flag
