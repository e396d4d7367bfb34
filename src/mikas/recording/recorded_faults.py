"""The stored faults of a recording: their readings, and the freeze frame of each that appeared.

    exchanges ──► readings of 02 by port ──► faults that appeared, between which readings
    rows ───────────────────────────────────► FrameCollector ──► the rows around each

Of a long file only the rows around those moments are held: a minute and ten seconds of a fault at
most, and thirty faults. The readings are those on the wire, and those from before the recording,
which its notes have. They are of the port with most rows in the last session, as in the report.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Final

import numpy as np

from mikas.recording.annotations.events import recorded_faults
from mikas.recording.capture.notes import Note
from mikas.recording.capture.reader import Source
from mikas.recording.freeze_frames import (
    AROUND,
    LONGEST,
    AppearedFault,
    Breaks,
    frame_of,
    new_faults,
)
from mikas.recording.table.channels import Rows, joined_rows
from mikas.sampling.events import Event, FaultReading
from mikas.sampling.fault_watch import MINERR, appeared

if TYPE_CHECKING:
    from mikas.recording.recording import Recording

_MOST: Final = 30  # frames of a recording


@dataclass(frozen=True, slots=True)
class RecordedFaults:
    """The readings in their order; none: the faults were not read. `appeared`: the latest first."""

    readings: tuple[FaultReading, ...]
    appeared: tuple[AppearedFault, ...]


class FaultReadings:
    """The readings of the faults in a recording, by session and port."""

    def __init__(self, recording: Recording) -> None:
        self._before: dict[int, list[Note]] = defaultdict(list)
        for note in recording.notes:
            self._before[note.recording].append(note)
        self._heard = recording.raw.fault_readings

    def readings_of_port(self, source: Source) -> tuple[FaultReading, ...]:
        """Return the readings of a port, after those from before its recording began."""
        before = recorded_faults(self._before.get(source.recording, ()))
        return *before, *self._heard.get(source, ())

    def port_without_rows(self) -> Source:
        """Return the port with most readings in the last session, where no port has rows."""
        last = max((*self._before, *(port.recording for port in self._heard)), default=0)
        ports = [port for port in self._heard if port.recording == last]
        return max(ports, key=lambda port: len(self._heard[port]), default=Source(last))


class FrameCollector:
    """Collects the rows around the faults that appear in `readings`, at most thirty: the latest
    appearance of each number first. `events`: of the same session; a fault that another unit has is
    not a new one.
    """

    def __init__(self, readings: Sequence[FaultReading], events: Iterable[Event] = ()) -> None:
        breaks = Breaks.of(events)
        new = [
            each
            for each in new_faults(readings)
            if not any(each[1] < change <= each[2] for change in breaks.units)
        ]
        latest = {code: at for at, (code, _, _) in enumerate(new)}
        ranked = sorted(range(len(new)), key=lambda at: (latest[new[at][0]] == at, at))
        self._windows = [_Window(*new[at], breaks) for at in sorted(ranked[-_MOST:], reverse=True)]

    @property
    def is_empty(self) -> bool:
        """Whether no fault appeared, so that no rows are needed."""
        return not self._windows

    def add(self, rows: Rows) -> None:
        """Take the next rows of the same port and session."""
        if len(rows.times):
            span = float(rows.times.min()), float(rows.times.max())
            for window in self._windows:
                window.add(rows, *span)

    @property
    def appeared(self) -> tuple[AppearedFault, ...]:
        """The faults that appeared, the latest first."""
        return tuple(window.result() for window in self._windows)


class _Window:
    """The rows around one fault; those that can't be in its frame are dropped as others come."""

    def __init__(self, code: int, before: float, read: float, breaks: Breaks) -> None:
        self._code, self._before, self._read, self._breaks = code, before, read, breaks
        self._begin, self._end = before - AROUND, read + AROUND
        self._pieces: list[Rows] = []
        self._last = -inf
        self._is_doubtful = False  # its times came twice: a clock was set back

    def add(self, rows: Rows, first: float, last: float) -> None:
        if last < self._begin or first > self._end:
            return
        inside = self._part(rows)
        times = inside.times
        if not times.size:
            return
        self._is_doubtful |= bool(times[0] < self._last or (np.diff(times) < 0).any())
        if self._is_doubtful:
            self._pieces = []
            return
        self._last = float(times[-1])
        self._pieces.append(inside)
        self._narrow()

    def _part(self, rows: Rows) -> Rows:
        return rows.part((rows.times >= self._begin) & (rows.times <= self._end))

    def _narrow(self) -> None:
        """Drop rows before and after the moment, as far as it is known by now."""
        rows = joined_rows(self._pieces)
        lowest = rows.values.get(MINERR, np.full(len(rows.times), np.nan))
        without, seen = appeared(
            self._code, self._before, self._read, rows.times.tolist(), lowest.tolist()
        )
        if seen < self._read:
            self._end = seen + AROUND
        self._begin = max(without, min(seen, self._last) - LONGEST) - AROUND
        self._pieces = [self._part(rows)]

    def result(self) -> AppearedFault:
        frame = None
        if self._pieces:
            rows = joined_rows(self._pieces)
            frame = frame_of(self._code, self._before, self._read, rows, self._breaks)
        return AppearedFault(self._code, self._before, self._read, frame)


def faults_in(recording: Recording) -> RecordedFaults:
    """Return the faults of a recording's last session, in the recording's interpretation."""
    readings, raw = FaultReadings(recording), recording.raw
    ports = [port for port in raw.row_counts if port.recording == raw.last_session]
    port = max(ports, key=lambda each: raw.row_counts[each], default=readings.port_without_rows())
    heard = readings.readings_of_port(port)
    events = (event for event in recording.events if event.recording == port.recording)
    frames = FrameCollector(heard, events)
    if not frames.is_empty:
        for source, rows in recording.stretches(raw.last_session):
            if source == port:
                frames.add(rows)
    return RecordedFaults(heard, frames.appeared)
