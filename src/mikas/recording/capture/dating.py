"""The true dates of a recording: by how much the computer's date was wrong when it began.

The times of a recording run evenly from the date that the computer had when the port was opened. A
Pi without a battery has a date of the past then, until the network gives it the true one. No packet
jumps for that: a note (`Kind.CLOCK`) says by how many seconds the date was set, and every reader
adds the sum of these notes to all times of their recording, also to those before the note. So its
values keep their order and their distances, and all of them have their true dates.

The note of a computer that slept moves nothing: the packets after it have their true times.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, BinaryIO, Final

from mikas.cleaning import is_in_calendar
from mikas.recording.capture.clock import LONGEST
from mikas.recording.capture.notes import CLOCK_TAG, Kind, Note, index
from mikas.recording.capture.scan import read_whole
from mikas.sampling.date_watch import GRAIN

if TYPE_CHECKING:
    from mikas.recording.capture.notes import FileIndex

_WINDOW: Final = 1 << 16


def set_by(note: Note) -> float:
    """Return by how many seconds the note moves the dates of its recording; 0 for other notes."""
    seconds = note.data.get("seconds")
    if note.kind != Kind.CLOCK or note.data.get("slept") is True:
        return 0.0
    if isinstance(seconds, bool) or not isinstance(seconds, int | float):
        return 0.0
    return round(seconds * GRAIN) / GRAIN if abs(seconds) <= LONGEST else 0.0


def corrections(notes: Iterable[Note]) -> Mapping[int, float]:
    """Return the seconds that are added to the times of each recording, by its number."""
    sums: defaultdict[int, float] = defaultdict(float)
    for note in notes:
        if seconds := set_by(note):
            sums[note.recording] += seconds
    return {number: seconds for number, seconds in sums.items() if abs(seconds) <= LONGEST}


def corrections_in(file: BinaryIO) -> Mapping[int, float]:
    """Return the corrections of a seekable file, whose position may change.

    Nearly every file has none, which one search shows.
    """
    overlap = len(CLOCK_TAG) - 1
    size = file.seek(0, 2)
    for start in range(0, size, _WINDOW):
        file.seek(start)
        if CLOCK_TAG in read_whole(file, _WINDOW + overlap):
            return corrections(index(file).notes)
    return {}


def dated_index(file: BinaryIO) -> FileIndex:
    """Return `index` of a capture, with the true times of its notes."""
    found = index(file)
    if later := corrections(found.notes):
        found.corrections = later
        found.notes = [moved(note, later.get(note.recording, 0.0)) for note in found.notes]
    return found


def moved(note: Note, seconds: float) -> Note:
    """Return the note `seconds` later, with the times in its data."""
    if not seconds or not is_in_calendar(abs(note.time + seconds)):
        return note
    data = dict(note.data)
    if note.kind in (Kind.GAP, Kind.TEST):
        data |= {key: _later(data[key], seconds) for key in ("began", "ended") if key in data}
    elif note.kind == Kind.FAULTS and isinstance(readings := data.get("readings"), list):
        data["readings"] = [
            each | {"time": _later(each["time"], seconds)}
            if isinstance(each, dict) and "time" in each
            else each
            for each in readings
        ]
    return replace(note, time=note.time + seconds, data=data)


def _later(time: Any, seconds: float) -> Any:  # noqa: ANN401  (any JSON)
    """Return a time of a note's data; anything else is left to the reader of that note."""
    if isinstance(time, bool) or not isinstance(time, int | float):
        return time
    return time + seconds
