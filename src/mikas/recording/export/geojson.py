"""GeoJSON (RFC 7946): the way as lines, and its points with their values, for QGIS and maps.

Point        a place: `time` (UTC), `seconds` from the first row, the values by channel
Point        a marker, a note, an alarm, a gap: `kind`, `text`
LineString   each stretch without interruption: `begin`, `end`
"""

from __future__ import annotations

import json
from array import array
from pathlib import Path
from typing import Any, BinaryIO, Final

from mikas.recording.export.gpx import utc
from mikas.recording.export.sheet import Moment, Sheet, program
from mikas.recording.export.track import GpsTrack, PlacedMoments, TrackPoint

_CLOSE: Final = b"\n]}\n"


def write(path: Path, sheet: Sheet) -> None:
    """Write the whole sheet. Raises `ExportError` if it has no position."""
    track = GpsTrack(path, sheet)
    moments = PlacedMoments(sheet.moments)
    with path.open("wb") as file:
        collection = _Collection(file, track, sheet)
        for point in track.points():
            for moment, place in moments.until(point):
                collection.add_moment(moment, place)
            collection.add_point(point)
        for moment, place in moments.rest():
            collection.add_moment(moment, place)
        collection.close()


class _Collection:
    """The features of a file, as they come; a line is written where it ends."""

    def __init__(self, file: BinaryIO, track: GpsTrack, sheet: Sheet) -> None:
        self._file = file
        self._track = track
        self._separator = b"\n"
        self._line: array[float] = array("d")  # longitude and latitude, in turn
        self._begin = self._end = 0.0
        head = {
            "type": "FeatureCollection",
            "program": program(),
            "about": dict(sheet.about),
            "channels": {channel.name: channel.facts() for channel in track.channels},
        }
        file.write(f'{_json(head)[:-1]},"features":['.encode())

    def add_point(self, point: TrackPoint) -> None:
        if point.begins:
            self._end_line()
            self._begin = point.time
        self._line.extend((point.longitude, point.latitude))
        self._end = point.time
        self._add("Point", _position(point), self._when(point.time) | dict(point.values))

    def add_moment(self, moment: Moment, place: TrackPoint) -> None:
        facts = moment.as_json()
        texts = {"kind": facts["kind"], "text": {"en": facts["en"], "ru": facts["ru"]}}
        self._add("Point", _position(place), self._when(moment.time) | texts)

    def close(self) -> None:
        self._end_line()
        self._file.write(_CLOSE)

    def _end_line(self) -> None:
        """Write the line so far; one place alone is none."""
        if len(self._line) >= 4:
            ends = {"begin": self._when(self._begin), "end": self._when(self._end)}
            places = [list(both) for both in zip(self._line[::2], self._line[1::2], strict=True)]
            self._add("LineString", places, ends)
        self._line = array("d")

    def _when(self, time: float) -> dict[str, Any]:
        moment = self._track.moment_of(time)
        return {"time": None if moment is None else utc(moment), "seconds": round(time, 3)}

    def _add(self, kind: str, coordinates: list[Any], properties: dict[str, Any]) -> None:
        feature = {
            "type": "Feature",
            "geometry": {"type": kind, "coordinates": coordinates},
            "properties": properties,
        }
        self._file.write(self._separator + _json(feature).encode())
        self._separator = b",\n"


def _position(point: TrackPoint) -> list[float]:
    height = [] if point.altitude is None else [point.altitude]
    return [point.longitude, point.latitude, *height]


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
