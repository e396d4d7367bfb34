"""The driver's actions over time: points, with steps or straight lines between them.

At its end a timeline holds its last values or begins again. All functions of the time are pure.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

SLACK = 5e-6  # s: floats of seconds since 1970 and their sums miss a point by less


@dataclass(frozen=True, slots=True)
class Track:
    """One input: values at ascending times. `smooth`: straight lines between, else steps."""

    times: tuple[float, ...]
    values: tuple[float, ...]
    smooth: bool = True

    def at(self, time: float) -> float:
        """Return the value at `time`; outside the points that of the nearest."""
        if len(self.times) == 1:
            return self.values[0]
        index = bisect_right(self.times, time)
        if index == 0:
            return self.values[0]
        before = self.values[index - 1]
        if index == len(self.times) or not self.smooth:
            return before
        start, end = self.times[index - 1], self.times[index]
        return before + (self.values[index] - before) * (time - start) / (end - start)


class Inputs(NamedTuple):
    """The driver's actions at one moment. None: chosen by the model's driver."""

    key: bool
    starter: bool
    throttle: float | None  # %
    gear: int | None  # 0: neutral
    speed: float | None  # km/h: the driver's goal, or that of the rolling road
    soon: float  # `speed` a second later
    load: float  # Nm taken from the crankshaft
    consumers: float  # A of lights, heater and radio


@dataclass(frozen=True, slots=True)
class ScenarioTimeline:
    """All inputs over `duration` seconds; if `loops`, repeated from `loop_from` on."""

    duration: float
    loops: bool
    loop_from: float
    key: Track
    starter: Track
    load: Track
    consumers: Track
    throttle: Track | None = None
    gear: Track | None = None
    speed: Track | None = None

    def place(self, time: float) -> float:
        """Return the timeline's second at `time`, plus `SLACK`: rounding must miss no point."""
        time += SLACK
        if time < self.duration:
            return max(0.0, time)
        if not self.loops:
            return self.duration
        return self.loop_from + (time - self.duration) % self._lap

    def at(self, time: float) -> Inputs:
        """Return the inputs at `time`, seconds since the start."""
        place = self.place(time)
        throttle, gear, speed = self.throttle, self.gear, self.speed
        return Inputs(
            self.key.at(place) >= 0.5,
            self.starter.at(place) >= 0.5,
            None if throttle is None else throttle.at(place),
            None if gear is None else int(gear.at(place)),
            None if speed is None else speed.at(place),
            0.0 if speed is None else speed.at(self.place(time + 1.0)),
            self.load.at(place),
            self.consumers.at(place),
        )

    def key_on(self, time: float) -> bool:
        """Return whether the ignition is on: without it the unit is silent."""
        return self.key.at(self.place(time)) >= 0.5

    def next_key_change(self, after: float) -> float:
        """Return when the ignition is switched next; infinity if never."""
        now = self.key_on(after)
        for begin, offset in self._laps(after):
            for point in (begin, *self.key.times):
                inside = begin <= point and (point < self.duration or not self.loops)
                if inside and point + offset > after and (self.key.at(point) >= 0.5) != now:
                    return point + offset
        return inf

    def _laps(self, after: float) -> Iterator[tuple[float, float]]:
        """Yield the laps from `after` on: the second each begins at, and its offset in time."""
        yield 0.0, 0.0
        if self.loops:
            first = max(0, int((after - self.duration) / self._lap) - 1)
            for lap in range(first, first + 4):
                yield self.loop_from, self._lap * (lap + 1)

    @property
    def _lap(self) -> float:
        return self.duration - self.loop_from
