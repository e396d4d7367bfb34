"""The way of the car in one session: stretches without interruption, at the receiver's times."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, radians
from typing import TYPE_CHECKING, Final

import numpy as np

from mikas.drives.curves import Curve
from mikas.drives.finding import SPEED, instrument_curve
from mikas.recording.exchanges.arrays import Floats, Mask

if TYPE_CHECKING:
    from mikas.recording.recording import Recording

_DEGREE: Final = 111_195.0  # m of a degree of latitude
_PAUSE: Final = 10.0  # s between two places that no line joins


@dataclass(frozen=True, slots=True)
class WayStretch:
    """A line of places. `east`, `north`: metres from the first place of the whole way."""

    times: Floats
    east: Floats
    north: Floats
    speeds: Floats
    """km/h; NaN where it is not known."""


def way_of(recording: Recording, session: int) -> list[WayStretch]:
    """Return the way of a session in stretches of two places or more; empty without a receiver."""
    found = _places(recording, session)
    if found is None:
        return []
    latitude, longitude = found
    there = np.isfinite(latitude.values) & np.isfinite(longitude.values)
    if not there.any():
        return []
    first = int(np.flatnonzero(there)[0])
    home = float(latitude.values[first]), float(longitude.values[first])
    north = (latitude.values - home[0]) * _DEGREE
    east = (longitude.values - home[1]) * (_DEGREE * cos(radians(home[0])))
    speeds = _at(instrument_curve(recording, session, SPEED), latitude.times)
    return [
        WayStretch(latitude.times[run], east[run], north[run], speeds[run])
        for run in _runs(latitude.times, there)
    ]


def _places(recording: Recording, session: int) -> tuple[Curve, Curve] | None:
    """Return both coordinates of the first receiver that gives them together."""
    for channel in recording.instrument_channels:
        if channel != "GPS_LAT" and not channel.startswith("GPS_LAT_"):
            continue
        pair = (channel, f"GPS_LON{channel[len('GPS_LAT') :]}")
        both = [recording.instrument_samples(name, session) for name in pair]
        curves = [Curve(each.times, each.values, each.stale) for each in both if each is not None]
        if len(curves) == 2 and np.array_equal(curves[0].times, curves[1].times):
            return curves[0], curves[1]
    return None


def _runs(times: Floats, there: Mask) -> Iterator[slice]:
    begin: int | None = None
    at = times.tolist()
    for place, is_there in enumerate(there.tolist()):
        is_joined = bool(begin is not None and place and 0 <= at[place] - at[place - 1] <= _PAUSE)
        if begin is not None and not (is_there and is_joined):
            if place - begin > 1:
                yield slice(begin, place)
            begin = None
        if is_there and begin is None:
            begin = place
    if begin is not None and len(at) - begin > 1:
        yield slice(begin, len(at))


def _at(curve: Curve | None, times: Floats) -> Floats:
    """Return the latest value at each time, if it is not too old."""
    missing = np.full(len(times), np.nan)
    if curve is None or not len(curve.times):
        return missing
    place = np.searchsorted(curve.times, times, "right") - 1
    latest = np.maximum(place, 0)
    is_fresh = (place >= 0) & (times - curve.times[latest] <= curve.longest)
    values: Floats = np.where(is_fresh, curve.values[latest], np.nan)
    return values
