"""Recording of the running connection: start, stop, marker, note.

The recorder always listens to the line, so a recording can start at any moment. It starts between
two cycles, where a running stream is requested again, so that the file alone can be decoded.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from dataclasses import InitVar, dataclass, replace
from pathlib import Path
from typing import Final

from mikas.client import Ecu
from mikas.client.cars import CarBook, CarDetails
from mikas.dashboard.errors import ADVICE, Busy, NotConnected, NotFound
from mikas.dashboard.library.folder import RecordingFolder
from mikas.dashboard.session.connection import Connection
from mikas.dashboard.session.history import FaultHistory, RecordingChanged
from mikas.dashboard.session.port_threads import SamplingThread
from mikas.dashboard.settings import ensure_folder
from mikas.errors import MikasError
from mikas.i18n import Text
from mikas.recording.annotations.events import car_note, faults_note, note_of
from mikas.recording.capture.dating import moved
from mikas.recording.capture.notes import Note
from mikas.recording.capture.writer import append_note
from mikas.recording.recorder import Recorder, RecordingStatus
from mikas.sampling.events import Event, Marker, UnitFound

_MOST_MARKED = 1000
_ROUNDED: Final = 1e-6  # s that a date loses when it is moved
_LAST: Final = 1.0  # s that the end of a recording waits for its last reading of the faults
_MARKER = Text("the marker", "отметка")
_NONE = Text("nothing is being recorded", "запись не идёт")


@dataclass(eq=False)
class SessionRecorder:
    """The recorder of the connection, with the folder of its files."""

    _connection: Connection
    _faults: FaultHistory
    _folder: RecordingFolder
    _cars: CarBook
    interpretation: InitVar[str]

    def __post_init__(self, interpretation: str) -> None:
        self._reported: MikasError | None = None
        self._name: str | None = None
        self.last: RecordingStatus | None = None
        """The recording that the end of the program ended."""
        self._continues = False  # with the next unit that is found
        self._marked: OrderedDict[float, Path] = OrderedDict()  # markers by time: their files
        self.recorder: Recorder = Recorder(
            interpretation=interpretation,
            on_file=lambda path: self._log(path.name, on=True),
            car=self._car_note,
        )

    @property
    def file_name(self) -> str | None:
        """The name of the file in progress; None: nothing is being recorded."""
        path = self._path
        return path.name if path else None

    @property
    def _path(self) -> Path | None:
        status = self.recorder.status
        return status.path if status is not None and status.failure is None else None

    async def start(self, name: str | None) -> None:
        """Record to a new file, as soon as the unit is known; a recording in progress ends.

        Raises `CaptureError`; as `Connection.ask` if no unit was found on this connection yet.
        """
        thread = self._connection.thread
        if thread is None:
            raise NotConnected
        path = self._folder.new_path(name)

        def between_cycles(ecu: Ecu) -> None:
            ecu.forget_list()
            self._start(path, thread)

        try:
            await self._connection.ask(between_cycles)
        except NotConnected:
            if self._connection.monitor.unit is None:
                raise
            # The unit is silent: no stream runs that would have to be restarted.
            self._start(path, thread)
        self._name, self._continues = name, False

    def record_event(self, event: Event) -> None:
        """Record an event; in the sampling thread."""
        self.recorder.record_event(event)
        thread = self._connection.thread
        if isinstance(event, UnitFound) and self._continues and thread is not None:
            self._continues = False
            path = self._folder.new_path(self._name)
            try:
                self._start(path, thread)
            except MikasError as error:
                self._log(path.name, on=False, failure=error)

    def change_port(self) -> None:
        """End the recording; it continues in a file of its own with the next unit found."""
        continues = self.file_name is not None or self._continues
        self.stop()
        self._continues = continues

    async def read_last(self) -> None:
        """Read the stored faults into a recording that is about to end, or give up in a second.

        Never raises.
        """
        session = self._connection.monitor.session
        if self.file_name is None or (future := session.read_now()) is None:
            return
        waiting = asyncio.wrap_future(future)
        waiting.add_done_callback(lambda it: it.cancelled() or it.exception())
        await asyncio.wait({waiting}, timeout=_LAST)
        future.cancel()

    def stop(self) -> RecordingStatus | None:
        """End the recording, if there is one; returns its final status."""
        self._continues = False
        status = self.recorder.stop()
        if status is not None:
            self._log(status.path.name, on=False, failure=status.failure)
        return status

    def close(self) -> None:
        """End the recording at the end of the program."""
        self.last = self.stop()

    def marker(self, label: str, date: float | None = None) -> float:
        """Mark this moment, or that of a `date`, and return its date.

        Without a recording at that moment it is only shown.
        """
        time = self._connection.now()  # not that of the latest sample: several may follow it
        if date is not None:
            time = min(date - self._connection.later, time)
        status = self.recorder.status
        recorded = date is None or (
            status is not None and status.since is not None and status.since <= time
        )
        if recorded:
            self.recorder.marker(time, label)
        if recorded and (path := self._path) is not None:
            self._marked[time] = path
            if len(self._marked) > _MOST_MARKED:
                self._marked.popitem(last=False)
        self._connection.monitor.log(Marker(time, label))
        return time + self._connection.later

    def change_marker(self, marker: Marker) -> None:
        """Rename the marker of that date, remove it or bring it back, in its recording, too.

        Raises `NotFound`: there was no such marker; `CaptureError`: its file can't be written.
        """
        logged, time = self._connection.monitor.logged, marker.time - self._connection.later
        markers = (it.time for it in logged if isinstance(it, Marker))
        found = next((it for it in markers if abs(it - time) < _ROUNDED), None)
        if found is None:
            raise NotFound(name=_MARKER)
        marker = replace(marker, time=found)
        self._connection.monitor.log(marker)
        if (path := self._marked.get(marker.time)) is not None:
            dated = moved(note_of(marker), self.recorder.later)
            self.append_note(path, dated)  # the recording may have ended since

    def write_text(self, text: str) -> None:
        """Write a note into the recording. Raises `Busy` if there is none."""
        if self.recorder.status is None:
            raise Busy(problem=_NONE)
        self.recorder.text(text)

    def append_note(self, path: Path, note: Note) -> None:
        """Write a note into a recording's file, which may be in progress. Raises `CaptureError`.

        `note.time`: as readers give the times of that recording.
        """
        if path == self._path:
            self.recorder.note(moved(note, -self.recorder.later))
        else:
            append_note(path, note)

    def describe(self, details: CarDetails) -> None:
        """Write the details of the car into the recording in progress, if there is one."""
        if self.file_name is not None:
            self.recorder.describe(car_note(self._connection.now(), details))

    def _car_note(self, unit: UnitFound) -> Note | None:
        """Return the note on a unit's car; without the mileage, which is another by now."""
        details = self._cars.details_of(unit.identity)
        known = replace(details, mileage=None) if details else None
        return car_note(unit.time, known) if known else None

    def check(self) -> None:
        """Log once that the recording has broken off."""
        status = self.recorder.status
        if status is not None and status.failure not in (None, self._reported):
            self._reported = status.failure
            self._log(status.path.name, on=False, failure=status.failure)

    def _start(self, path: Path, thread: SamplingThread) -> None:
        self.recorder.start(ensure_folder(path.parent) / path.name, url=thread.url, pipe=False)
        self._reported = None
        unit = self._connection.monitor.unit
        if unit is not None and (car := self._car_note(unit)) is not None:
            self.recorder.describe(replace(car, time=thread.now()))  # not the last file's mileage
        if readings := self._faults.readings:  # from before this file
            self.recorder.note(faults_note(thread.now(), readings))
        self._log(path.name, on=True)
        self._connection.monitor.session.read_now()

    def _log(self, file: str, *, on: bool, failure: MikasError | None = None) -> None:
        text = ADVICE.text(failure) if failure else None
        changed = RecordingChanged(self._connection.now(), file, on=on, failure=text)
        self._connection.monitor.log(changed)
