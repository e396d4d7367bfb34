"""The way of the car: stretches without interruption, at the receiver's times."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import cos, inf, radians
from typing import TYPE_CHECKING, Final

import numpy as np

from mikas.catalog.instrument_channels import is_labelled
from mikas.drives.curves import PAUSE, SampledCurve, sampled_curve
from mikas.drives.finding import SPEED, column_of, instrument_curve
from mikas.recording.exchanges.arrays import Floats, Mask
from mikas.recording.table.channels import Rows

if TYPE_CHECKING:
    from mikas.recording.recording import Recording
    from mikas.sampling.events import Marker

LATITUDE: Final = "GPS_LAT"
LONGITUDE: Final = "GPS_LON"
_DEGREE: Final = 111_195.0  # m of a degree of latitude
_PAUSE: Final = 10.0  # s between two places that no line joins

_NOTHING: Final = SampledCurve(np.zeros(0), np.zeros(0), 0.0)

Place = tuple[float, float]
"""Latitude and longitude, in degrees."""


@dataclass(frozen=True, slots=True)
class WayStretch:
    """A line of places. `east`, `north`: metres from the first place of the whole way."""

    times: Floats
    east: Floats
    north: Floats
    values: Floats
    """Of the channel that gives the colour, as a rule the speed in km/h; NaN where unknown."""


def way_of(recording: Recording, session: int) -> list[WayStretch]:
    """Return the way of a session in stretches of two places or more; empty without a receiver."""
    found = _places(recording, session)
    if found is None:
        return []
    return stretches_of(*found, instrument_curve(recording, session, SPEED))


def way_since(
    recording: Recording, colours: Mapping[int, SampledCurve], since: Marker | None = None
) -> list[WayStretch]:
    """Return the way of all sessions, from a mark on; `colours`: by session."""
    home: Place | None = None
    way: list[WayStretch] = []
    for session in sorted(recording.raw.spans):
        if since is not None and session < since.recording:
            continue
        found = _places(recording, session)
        if found is None:
            continue
        if since is not None and session == since.recording:
            found = found[0].since(since.time), found[1].since(since.time)
        home = home or first_place(*found)
        way += stretches_of(*found, colours.get(session), home)
    return way


def way_of_rows(rows: Rows, colour: str, since: float = -inf) -> list[WayStretch]:
    """Return the way of rows that have the receiver's columns, as those of a running connection.

    `colour`: the channel that gives the colour.
    """
    named = column_of(rows, LATITUDE), column_of(rows, LONGITUDE)
    if named[0] is None or named[1] is None:
        return []
    latitude, longitude = rows.values[named[0]], rows.values[named[1]]
    # A receiver says a place a second, and each row has the latest one.
    begins = np.ones(1, np.bool_)
    is_new = (np.diff(latitude) != 0) | (np.diff(longitude) != 0)
    chosen = np.concatenate((begins, is_new))[: len(rows.times)]
    times = rows.times[chosen]
    shown = column_of(rows, colour)
    found = (
        SampledCurve(times, latitude[chosen], PAUSE),
        SampledCurve(times, longitude[chosen], PAUSE),
    )
    values = sampled_curve(rows.times, rows.values[shown]) if shown else None
    return stretches_of(found[0].since(since), found[1].since(since), values)


def first_place(latitude: SampledCurve, longitude: SampledCurve) -> Place | None:
    """Return the first place that is known."""
    there = np.flatnonzero(np.isfinite(latitude.values) & np.isfinite(longitude.values))
    if not len(there):
        return None
    first = int(there[0])
    return float(latitude.values[first]), float(longitude.values[first])


def stretches_of(
    latitude: SampledCurve,
    longitude: SampledCurve,
    colour: SampledCurve | None,
    home: Place | None = None,
) -> list[WayStretch]:
    """Return the stretches of places. `home`: where metres count from; None: the first place."""
    home = home or first_place(latitude, longitude)
    if home is None:
        return []
    there = np.isfinite(latitude.values) & np.isfinite(longitude.values)
    north = (latitude.values - home[0]) * _DEGREE
    turn = longitude.values - home[1]
    turn = turn - 360.0 * (turn > 180.0) + 360.0 * (turn < -180.0)  # over the 180th meridian
    east = turn * (_DEGREE * cos(radians(home[0])))
    values = (colour or _NOTHING).latest(latitude.times)
    return [
        WayStretch(latitude.times[run], east[run], north[run], values[run])
        for run in _runs(latitude.times, there)
    ]


def _places(recording: Recording, session: int) -> tuple[SampledCurve, SampledCurve] | None:
    """Return both coordinates of the first receiver that gives them together."""
    for channel in recording.instrument_channels:
        if not is_labelled(channel, LATITUDE):
            continue
        pair = (channel, f"{LONGITUDE}{channel[len(LATITUDE) :]}")
        both = [recording.instrument_samples(name, session) for name in pair]
        curves = [
            SampledCurve(each.times, each.values, each.stale) for each in both if each is not None
        ]
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
