"""Recording the running connection: start, stop, marker, note.

The recorder is always at the wire, so a recording can begin at any moment; it does so between two
cycles, where a stream that runs is begun anew and can be read again from the file alone.
"""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.dashboard import happenings
from mikas.dashboard.refusals import Busy, NotConnected
from mikas.dashboard.settings import made
from mikas.language import Text
from mikas.recording.recorder import Recorder, begin_anew

if TYPE_CHECKING:
    from mikas.client import Ecu
    from mikas.dashboard.hub import Hub
    from mikas.errors import MikasError

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
        self.recorder = Recorder(
            ecu=lambda: hub.ecu, reading=hub.settings.reading, on_file=self._another_file
        )

    async def start(self, name: str | None) -> None:
        """Records to a new file; what is being recorded ends. Raises `CaptureError`."""
        session = self._hub.session
        if session is None:
            raise NotConnected
        folder = self._hub.settings.recordings
        path = _free(folder, named(name) or time.strftime("%Y-%m-%d %H-%M-%S"))

        def begin() -> None:
            self.recorder.start(made(folder) / path.name, url=session.url)

        def between_cycles(ecu: Ecu) -> None:
            begin_anew(ecu)
            begin()

        try:
            await self._hub.ask(between_cycles)
        except NotConnected:  # nobody answers: nothing runs that would have to be begun anew
            begin()
        self._told = None
        self._hub.story.tell(happenings.recording(self._hub.now(), path.name, on=True))

    def stop(self) -> None:
        """Ends the recording, if there is one."""
        status = self.recorder.stop()
        if status is not None:
            self._hub.story.tell(
                happenings.recording(
                    self._hub.now(), status.path.name, on=False, failure=status.failure
                )
            )

    def marker(self, label: str) -> float:
        """A moment worth finding again; returns its time. Without a recording it is shown only."""
        at = self.recorder.marker(label=label)
        at = self._hub.now() if at is None else at
        self._hub.story.tell(happenings.marker(at, label))
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
            self._hub.story.tell(
                happenings.recording(self._hub.now(), status.path.name, on=False, failure=failure)
            )

    def _another_file(self, path: Path) -> None:
        self._hub.story.tell(happenings.recording(self._hub.now(), path.name, on=True))


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
