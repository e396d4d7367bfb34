"""GPX 1.1: the way with its values, for maps and for programs of receivers.

wpt     a marker, a note, an alarm, a gap, at its place
trk     one, with a segment for each stretch without interruption
trkpt   lat, lon, ele, time; the values as elements of a namespace of their own; the receiver's
        speed and course as Garmin's TrackPointExtension, which many programs read
"""

from __future__ import annotations

import re
import shutil
import tempfile
from datetime import datetime
from html import escape
from pathlib import Path
from typing import Final

from mikas.cleaning import clean_line
from mikas.recording.export.csv import shortest
from mikas.recording.export.sheet import Moment, Sheet, program
from mikas.recording.export.track import GpsTrack, PlacedMoments, TrackPoint

NAMESPACE: Final = "https://github.com/mikas-diagnostics/mikas"
_GARMIN: Final = "http://www.garmin.com/xmlschemas/TrackPointExtension/v2"
_NOT_IN_NAMES: Final = re.compile(r"[^\w.-]")


def write(path: Path, sheet: Sheet) -> None:
    """Write the whole sheet. Raises `ExportError` if it has no position."""
    track = GpsTrack(path, sheet)
    moments = PlacedMoments(sheet.moments)
    places: list[str] = []
    # Its places stand before the track, and are known only after it.
    with path.open("wb") as file, tempfile.TemporaryFile(dir=path.parent) as body:
        for number, point in enumerate(track.points()):
            for moment, place in moments.until(point):
                places.append(_place(track, sheet, moment, place))
            if point.begins:
                body.write(b"</trkseg>\n<trkseg>\n" if number else b"<trkseg>\n")
            body.write(_point(track, point).encode())
        places += [_place(track, sheet, *both) for both in moments.rest()]
        file.write(_head(sheet).encode())
        file.write("".join(places).encode())
        file.write(_track_head(track, sheet).encode())
        body.seek(0)
        shutil.copyfileobj(body, file)
        file.write(b"</trkseg>\n</trk>\n</gpx>\n")


def _head(sheet: Sheet) -> str:
    name = clean_line(sheet.about.get("recording", ""))
    facts = "; ".join(f"{title}: {text}" for title, text in sheet.about.items())
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<gpx version="1.1" creator="{escape(program())}"'
        ' xmlns="http://www.topografix.com/GPX/1/1"'
        f' xmlns:mikas="{NAMESPACE}" xmlns:gpxtpx="{_GARMIN}">\n'
        f"<metadata><name>{escape(name)}</name><desc>{escape(clean_line(facts))}</desc>"
        f"{_time(sheet.started)}</metadata>\n"
    )


def _track_head(track: GpsTrack, sheet: Sheet) -> str:
    units = ", ".join(
        f"{_element(channel.name)}: {channel.text.to(sheet.language)}"
        + (f" ({unit})" if (unit := channel.unit_in(sheet.language)) else "")
        for channel in track.channels
    )
    name = clean_line(sheet.about.get("recording", ""))
    return f"<trk><name>{escape(name)}</name><desc>{escape(clean_line(units))}</desc>\n"


def _place(track: GpsTrack, sheet: Sheet, moment: Moment, point: TrackPoint) -> str:
    text = escape(clean_line(moment.text.to(sheet.language)))
    return (
        f"<wpt {_coordinates(point)}>{_height(point)}{_time(track.moment_of(moment.time))}"
        f"<name>{text}</name><type>{moment.kind}</type></wpt>\n"
    )


def _point(track: GpsTrack, point: TrackPoint) -> str:
    values = "".join(
        f"<mikas:{(name := _element(channel))}>{shortest(value)}</mikas:{name}>"
        for channel, value in point.values.items()
    )
    garmin = ""
    if (speed := point.values.get(track.named("GPS_SPEED"))) is not None:
        garmin += f"<gpxtpx:speed>{speed / 3.6:.3f}</gpxtpx:speed>"  # m/s
    if (course := point.values.get(track.named("GPS_COURSE"))) is not None:
        garmin += f"<gpxtpx:course>{course % 360:.1f}</gpxtpx:course>"
    if garmin:
        garmin = f"<gpxtpx:TrackPointExtension>{garmin}</gpxtpx:TrackPointExtension>"
    extensions = f"<extensions>{garmin}{values}</extensions>" if values or garmin else ""
    return (
        f"<trkpt {_coordinates(point)}>{_height(point)}{_time(track.moment_of(point.time))}"
        f"{extensions}</trkpt>\n"
    )


def _coordinates(point: TrackPoint) -> str:
    return f'lat="{shortest(point.latitude)}" lon="{shortest(point.longitude)}"'


def _height(point: TrackPoint) -> str:
    return "" if point.altitude is None else f"<ele>{shortest(point.altitude)}</ele>"


def _time(moment: datetime | None) -> str:
    return "" if moment is None else f"<time>{utc(moment)}</time>"


def utc(moment: datetime) -> str:
    """Return `2026-06-01T08:12:40.123Z`."""
    return f"{moment.strftime('%Y-%m-%dT%H:%M:%S')}.{moment.microsecond // 1000:03d}Z"


def _element(name: str) -> str:
    """Return a channel's name as an element's, which begins with a letter."""
    name = _NOT_IN_NAMES.sub("_", name)
    return name if name[:1].isalpha() else f"_{name}"
