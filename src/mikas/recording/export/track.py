"""The way of the car as points: what .gpx and .geojson share.

A GPS gives a position a second, the unit thirty rows. So a point is a row with another position
than the point before, and has with it the values that came within the second before. The line is
interrupted where a gap is, or the position is missing.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from math import isfinite
from pathlib import Path
from typing import Final

import numpy as np

from mikas.catalog.instrument_channels import is_labelled
from mikas.errors import ExportError
from mikas.i18n import Text
from mikas.recording.export.sheet import Column, Moment, Sheet
from mikas.recording.table.channels import Channel

LATITUDE: Final = "GPS_LAT"
LONGITUDE: Final = "GPS_LON"
ALTITUDE: Final = "GPS_ALT"
_FRESH: Final = 1.0  # s that a value holds for a point
_PAUSE: Final = 10.0  # s without rows that interrupt the line
_NEAR: Final = 10.0  # s from a moment to the point that stands for its place


@dataclass(frozen=True, slots=True)
class TrackPoint:
    """A position. `time`: seconds from the first row; `begins`: no line leads to it."""

    time: float
    latitude: float
    longitude: float
    altitude: float | None
    begins: bool
    values: Mapping[str, float]
    """What was measured within the second before, by channel."""


class GpsTrack:
    """The points of a sheet. Raises `ExportError` if it has no position."""

    def __init__(self, path: Path, sheet: Sheet) -> None:
        self._path = path
        self._sheet = sheet
        names = [channel.name for channel in sheet.channels]
        self._label = _label_of(names)
        if self._label is None:
            raise _no_track(path, _NO_POSITION)
        self.channels: tuple[Channel, ...] = tuple(
            channel for channel in sheet.channels if channel.name not in self._own
        )
        """The channels of the values."""

    @property
    def _own(self) -> tuple[str, str, str]:
        return (f"{LATITUDE}{self._label}", f"{LONGITUDE}{self._label}", f"{ALTITUDE}{self._label}")

    def named(self, name: str) -> str:
        """Return the receiver's channel `name`, with the label of the one that gives positions."""
        return f"{name}{self._label}"

    def points(self) -> Iterator[TrackPoint]:
        """Yield the points, once. Raises `ExportError` at the end if there was none."""
        names = [channel.name for channel in self._sheet.channels]
        latitude, longitude, altitude = self._own
        at, to = names.index(latitude), names.index(longitude)
        high = names.index(altitude) if altitude in names else None
        shown = [names.index(channel.name) for channel in self.channels]
        last: tuple[float, float] | None = None  # None: no line leads to the next point
        before, found = -np.inf, False
        held = [(-np.inf, np.nan)] * len(names)  # time and value, by column
        for times, columns in self._sheet.batches():
            filled = [_Filled(times, column, held[n]) for n, column in enumerate(columns)]
            steps = np.diff(np.concatenate((np.array([before]), times)))
            is_apart = (steps < 0) | (steps > _PAUSE)
            is_missing = ~(np.isfinite(columns[at]) & np.isfinite(columns[to]))
            places = zip(columns[at].tolist(), columns[to].tolist(), strict=True)
            for row, place in enumerate(places):
                if is_missing[row] or is_apart[row]:
                    last = None
                if is_missing[row] or place == last:
                    continue
                found = True
                yield TrackPoint(
                    float(times[row]), *place, None if high is None else filled[high].at(row),
                    last is None,
                    {
                        channel.name: value
                        for channel, n in zip(self.channels, shown, strict=True)
                        if (value := filled[n].at(row)) is not None
                    },
                )  # fmt: skip
                last = place
            held = [each.last for each in filled]
            before = float(times[-1])
        if not found:
            raise _no_track(self._path, _NOT_FOUND if self._sheet.rows else _NO_ROWS)

    def moment_of(self, time: float) -> datetime | None:
        """Return the date of a point; None: the recording has none."""
        if self._sheet.started is None:
            return None
        return self._sheet.started.astimezone(UTC) + timedelta(seconds=time)


class PlacedMoments:
    """The markers, notes and alarms of a sheet, each at the nearest point of the track."""

    def __init__(self, moments: Sequence[Moment]) -> None:
        self._waiting = deque(moments)
        self._before: TrackPoint | None = None

    def until(self, point: TrackPoint) -> Iterator[tuple[Moment, TrackPoint]]:
        """Yield those up to `point`, the next one of the track."""
        while self._waiting and self._waiting[0].time <= point.time:
            moment = self._waiting.popleft()
            candidates = [each for each in (self._before, point) if each is not None]
            yield from _placed(moment, candidates)
        self._before = point

    def rest(self) -> Iterator[tuple[Moment, TrackPoint]]:
        """Yield those after the last point."""
        for moment in self._waiting:
            yield from _placed(moment, [self._before] if self._before is not None else [])


def _placed(moment: Moment, points: Sequence[TrackPoint]) -> Iterator[tuple[Moment, TrackPoint]]:
    nearest = min(points, key=lambda each: abs(each.time - moment.time), default=None)
    if nearest is not None and abs(nearest.time - moment.time) <= _NEAR:
        yield moment, nearest


class _Filled:
    """A column whose values hold for `_FRESH`; `last`: the latest of all with its time."""

    def __init__(self, times: Column, column: Column, before: tuple[float, float]) -> None:
        self._times = np.concatenate((np.array([before[0]]), times))
        self._values = np.concatenate((np.array([before[1]]), column))
        known = np.where(np.isfinite(self._values), np.arange(len(self._values)), 0)
        self._latest = np.maximum.accumulate(known)
        at = int(self._latest[-1])
        self.last = float(self._times[at]), float(self._values[at])

    def at(self, row: int) -> float | None:
        """Return the value of a row, or the one that holds there; None: there is none."""
        place = int(self._latest[row + 1])
        value = float(self._values[place])
        age = float(self._times[row + 1]) - float(self._times[place])
        return value if isfinite(value) and 0 <= age <= _FRESH else None


def _label_of(names: Sequence[str]) -> str | None:
    """Return the label of the first receiver with both coordinates; empty: without one."""
    for name in names:
        if is_labelled(name, LATITUDE):
            label = name[len(LATITUDE) :]
            if f"{LONGITUDE}{label}" in names:
                return label
    return None


def _no_track(path: Path, why: Text) -> ExportError:
    return ExportError(str(path.with_suffix("")), why)


_NO_POSITION: Final = Text(
    "there is no position in this recording: a track needs a GPS beside the unit "
    "(`mikas log … --instrument nmea=PORT`) that has found its place",
    "в этой записи нет координат: для трека нужен GPS рядом с блоком "
    "(`mikas log … --instrument nmea=ПОРТ`), который определил своё место",
)
_NOT_FOUND: Final = Text(
    "the GPS had not found its place: no message of it has a position (a receiver under the sky "
    "needs a minute or two)",
    "GPS ещё не определил своё место: ни в одном его сообщении нет координат (под открытым небом "
    "приёмнику нужна минута-другая)",
)
_NO_ROWS: Final = Text(
    "there is a GPS, but no response of the unit: a track has its points where the unit answered; "
    "`mikas decode FILE` shows what the receiver sent",
    "GPS есть, но нет ни одного ответа блока: точки трека стоят там, где блок отвечал; что передал "
    "приёмник, покажет `mikas decode ФАЙЛ`",
)
