"""Channels as curves: straight between samples, unknown in a pause.

      value   •──•──•           •──•         a pause: two samples further apart than usual
      known   ├─────┤           ├──┤

The sums of a stretch are exact integrals of these curves, so those of two neighbouring stretches
are together that of both.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from mikas.recording.exchanges.arrays import Floats, Mask

PAUSE: Final = 2.0  # s, as of a gap; more where such steps are usual
_ALIKE: Final = 2.5  # times the usual step
_LONGEST: Final = 10.0  # s: one request a code, to a unit that needs 0.5 s for each


@dataclass(frozen=True, slots=True)
class CurveIntervals:
    """A curve over adjacent intervals: its value at the begin and at the end of each.

    Both are NaN where the curve is unknown. `first`: the value of the sample before the interval.
    `most`: the greater one of the samples on both sides.
    """

    begins: Floats
    ends: Floats
    first: Floats
    most: Floats

    @property
    def known(self) -> Mask:
        """The intervals in which the curve has values."""
        return np.isfinite(self.begins)

    @property
    def means(self) -> Floats:
        """The mean of each interval."""
        return self.begins * 0.5 + self.ends * 0.5


@dataclass(frozen=True, slots=True)
class SampledCurve:
    """Samples of one channel, times rising. A NaN ends the part before it.

    `longest`: seconds between two samples of which the values between are known.
    """

    times: Floats
    values: Floats
    longest: float

    def over(self, edges: Floats) -> CurveIntervals:
        """Return the curve between each two neighbours of `edges`.

        `edges` rise, and hold all times of samples between the first and the last of them.
        """
        if len(self.times) < 2 or len(edges) < 2:
            nothing = np.full(max(0, len(edges) - 1), np.nan)
            return CurveIntervals(nothing, nothing, nothing, nothing)
        middles = edges[:-1] * 0.5 + edges[1:] * 0.5
        place = np.searchsorted(self.times, middles, "right") - 1
        inside = (place >= 0) & (place < len(self.times) - 1)
        place = np.minimum(np.maximum(place, 0), len(self.times) - 2)
        begin, end = self.times[place], self.times[place + 1]
        first, last = self.values[place], self.values[place + 1]
        step = end - begin
        inside = inside & (step > 0) & (step <= self.longest)
        inside = inside & np.isfinite(first) & np.isfinite(last)
        slope = (last - first) / np.where(step > 0, step, 1.0)
        begins = first + slope * (edges[:-1] - begin)
        ends = first + slope * (edges[1:] - begin)
        return CurveIntervals(
            np.where(inside, begins, np.nan),
            np.where(inside, ends, np.nan),
            np.where(inside, first, np.nan),
            np.where(inside, np.maximum(first, last), np.nan),
        )

    def latest(self, times: Floats) -> Floats:
        """Return the latest value at each time; NaN where it is too old."""
        missing = np.full(len(times), np.nan)
        if not len(self.times):
            return missing
        place = np.searchsorted(self.times, times, "right") - 1
        before = np.maximum(place, 0)
        is_fresh = (place >= 0) & (times - self.times[before] <= self.longest)
        values: Floats = np.where(is_fresh, self.values[before], np.nan)
        return values

    def since(self, time: float) -> SampledCurve:
        """Return what it has from a time on."""
        inside = self.times >= time
        return SampledCurve(self.times[inside], self.values[inside], self.longest)


def sampled_curve(times: Floats, values: Floats) -> SampledCurve:
    """Return the curve of a channel of the unit. A NaN: not in this response."""
    there = np.isfinite(values)
    times, values = times[there], values[there]
    steps = np.diff(times)
    steps = steps[steps > 0]
    usual = float(np.median(steps)) if len(steps) else 0.0
    return SampledCurve(times, values, min(_LONGEST, max(PAUSE, _ALIKE * usual)))
