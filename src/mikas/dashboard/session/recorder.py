"""Recording the running connection: start, stop, marker, note.

The recorder is always at the wire, so a recording can begin at any moment; it does so between two
cycles, where a stream that runs is begun anew and can be read again from the file alone.
"""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.dashboard.advice import ADVICE
from mikas.dashboard.errors import Busy, NotConnected
from mikas.dashboard.session.event_log import RecordingChanged
from mikas.dashboard.settings import ensure_folder
from mikas.errors import MikasError
from mikas.i18n import Text
from mikas.recording.annotations.events import faults_note
from mikas.recording.recorder import Recorder, RecordingStatus, ask_in_full
from mikas.sampling.events import Marker, UnitFound

if TYPE_CHECKING:
    from mikas.client import Ecu
    from mikas.dashboard.dashboard import Hub
    from mikas.dashboard.session.thread import Session
    from mikas.sampling.events import Event

SUFFIX = ".pcapng"
_NO_PLACE_IN_A_NAME = re.compile(r'[\x00-\x1f\x7f/\\:*?"<>|]+')
_LONGEST = 100
_RESERVED = re.compile(r"(?i)(?:con|prn|aux|nul|com\d|lpt\d)(?:\.|$)")
_NONE = Text("nothing is being recorded", "запись не идёт")


class RecordingDesk:
    """The hub's recorder, and where its files go."""

    def __init__(self, hub: Hub) -> None:
        self._hub = hub
        self._told: MikasError | None = None
        self._name: str | None = None
        self.kept: RecordingStatus | None = None
        """The recording that the end of the program ended."""
        self._goes_on = False  # with the first unit that answers
        self.recorder = Recorder(
            interpretation=hub.settings.connection.interpretation,
            on_file=self._tell_begun,
        )

    async def start(self, name: str | None) -> None:
        """Records to a new file; what is being recorded ends.

        Raises `CaptureError`; `NotConnected` if nobody has answered on this connection yet.
        """
        session = self._hub.session
        if session is None:
            raise NotConnected
        if self._hub.monitor.unit is None:  # it would be of nobody
            raise self._hub.nobody()
        path = self._path(name)

        def begin() -> None:
            self._begin(path, session)

        def between_cycles(ecu: Ecu) -> None:
            ask_in_full(ecu)
            begin()

        try:
            await self._hub.ask(between_cycles)
        except NotConnected:  # nobody answers: nothing runs that would have to be begun anew
            begin()
        self._name, self._goes_on = name, False
        self._tell_begun(path)

    def take(self, event: Event, session: Session) -> None:
        """In the sampling thread: what is told goes into the recording."""
        self.recorder.take(event)
        if isinstance(event, UnitFound) and self._goes_on:
            self._goes_on = False
            path = self._path(self._name)
            try:
                self._begin(path, session)
            except MikasError as error:
                self._tell_end(path.name, error)
            else:
                self._tell_begun(path)

    def pause(self, time: float, why: Text) -> None:
        """The connection is left for a while: there will be a gap."""
        self.recorder.interrupt(time, why)

    def part(self) -> None:
        """Another port was chosen: the recording ends, and goes on in a file of its own with the
        first unit that answers there.
        """
        status = self.recorder.status
        runs = status is not None and status.failure is None
        self._goes_on, goes_on = False, runs or self._goes_on
        self.stop()
        self._goes_on = goes_on

    def stop(self) -> RecordingStatus | None:
        """Ends the recording, if there is one; returns how far it came."""
        self._goes_on = False
        status = self.recorder.stop()
        if status is not None:
            self._tell_end(status.path.name, status.failure)
        return status

    def close(self) -> None:
        """The program ends, and the recording with it."""
        self.kept = self.stop()

    def marker(self, label: str) -> float:
        """A moment worth finding again; returns its time. Without a recording it is shown only."""
        at = self.recorder.marker(label=label)
        at = self._hub.now() if at is None else at
        self._hub.monitor.log(Marker(at, label))
        return at

    def note(self, text: str) -> None:
        """A person's words into the recording. Raises `Busy` if there is none."""
        if self.recorder.status is None:
            raise Busy(problem=_NONE)
        self.recorder.text(text=text)

    def look(self) -> None:
        """Tells once if the recording has broken off."""
        status = self.recorder.status
        failure = status.failure if status else None
        if status is not None and failure is not None and failure is not self._told:
            self._told = failure
            self._tell_end(status.path.name, failure)

    def _path(self, name: str | None) -> Path:
        stem = named(name) or time.strftime("%Y-%m-%d %H-%M-%S")
        return _free(self._hub.settings.recordings, stem)

    def _begin(self, path: Path, session: Session) -> None:
        self.recorder.start(ensure_folder(path.parent) / path.name, url=session.url)
        self._told = None
        readings = self._hub.fault_history.readings
        if readings:  # from before this file
            self.recorder.note(faults_note(session.now(), readings))

    def _tell_begun(self, path: Path) -> None:
        self._hub.monitor.log(RecordingChanged(self._hub.now(), path.name, on=True))

    def _tell_end(self, file: str, failure: MikasError | None) -> None:
        text = ADVICE.text(failure) if failure else None
        self._hub.monitor.log(RecordingChanged(self._hub.now(), file, on=False, failure=text))


def named(name: str | None) -> str:
    """`name` as a file can be called, without its suffix; empty if nothing is left of it."""
    kept = _NO_PLACE_IN_A_NAME.sub(" ", name or "").removesuffix(SUFFIX)
    kept = kept.strip(" .")[:_LONGEST].strip(" .")
    return f"{kept}-" if _RESERVED.match(kept) else kept


def _free(folder: Path, stem: str) -> Path:
    path, number = folder / f"{stem}{SUFFIX}", 2
    while path.exists():
        path, number = folder / f"{stem} ({number}){SUFFIX}", number + 1
    return path
