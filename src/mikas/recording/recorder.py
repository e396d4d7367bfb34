"""The recorder of a session: always on the wire, writing from `start` to `stop`, never in the way.

    link ──► CaptureTee ──► Recorder ──► Coalescer ──► CaptureWriter ──► NAME.pcapng
    events ──────────────────┘  take: notes in between

If the disk is full, or the folder or medium is gone, the file ends with its last whole block,
`failure` has the reason, and sampling goes on. Another car gets its own file, NAME-2.pcapng.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.errors import CaptureError
from mikas.files import beside
from mikas.link.base import Direction
from mikas.recording.annotations.annotator import SessionAnnotator
from mikas.recording.annotations.events import note_of
from mikas.recording.annotations.fields import LONGEST_TEXT
from mikas.recording.capture.coalescer import Coalescer
from mikas.recording.capture.dating import moved
from mikas.recording.capture.notes import Note
from mikas.recording.capture.opening import capture_error
from mikas.recording.capture.writer import CaptureWriter
from mikas.sampling.events import ClockChanged, Event, Marker, TextNote, UnitFound

if TYPE_CHECKING:
    from mikas.i18n import Text
    from mikas.recording.capture import blocks as pcapng


@dataclass(frozen=True, slots=True)
class RecordingStatus:
    """The progress of one recording. `since`: on the link's clock; None before any byte or event.

    `samples`: those in the file; `gaps`: counted once, however many cycles failed in them. After a
    `failure` nothing more is written; `lost`: samples since then, or lost with the file.
    """

    path: Path
    """The file."""
    since: float | None
    """The link's clock at its first byte or event."""
    bytes: int
    """The size of the file."""
    samples: int
    """The samples in it."""
    gaps: int
    """How often the values stopped."""
    failure: CaptureError | None
    """Why it ended early; None: it did not."""
    lost: int = 0
    """The samples since a failure."""


@dataclass(slots=True)
class _Open:
    """One recording: its file, until that is closed, and the origin of its name."""

    named: Path  # by the user; the file's own name has a number if other files precede it
    url: str
    writer: CaptureWriter
    sink: Coalescer | CaptureWriter
    since: float | None
    later: float  # seconds that its times are later than the link's clock: the date was set before
    failure: CaptureError | None = None
    written: int = 0  # samples in the file at the failure


class Recorder:
    """Takes the bytes on the wire and the sampler's events; writes from `start` to `stop`.

    `interpretation`: of values, for the notes of plans. `joined`: a packet for each response, not
    for each chunk. `on_file`: called with each file that follows another one, in the thread that
    caused it. `car`: as of `SessionAnnotator`. `instruments`: the ports beside the unit's that
    each file describes. Only `start` and `note` raise; any thread may call.

    `conclude`: called before a file ends, for the events that its session still holds back.
    """

    def __init__(
        self,
        *,
        interpretation: str = "corrected",
        joined: bool = True,
        on_file: Callable[[Path], None] | None = None,
        car: Callable[[UnitFound], Note | None] | None = None,
        instruments: Sequence[pcapng.Interface] = (),
    ) -> None:
        self.instruments: Sequence[pcapng.Interface] = tuple(instruments)
        """The ports of instruments; to be set before the first file, else by `use_instruments`."""
        self.on_file = on_file
        self.conclude: Callable[[], object] = lambda: None
        """To be set before the first event."""
        self._joined = joined
        self._annotator = SessionAnnotator(interpretation, car)
        self._lock = threading.RLock()
        self._open: _Open | None = None
        self._time: float | None = None  # the latest of a byte or an event, on the link's clock
        self.later: float = 0.0
        """The seconds that the date is later than the link's clock, as far as it was set since."""

    # For its users

    def start(self, path: str | os.PathLike[str], *, url: str, pipe: bool = True) -> None:
        """Record to `path` from here on; end a running recording first. As `CaptureWriter`.

        In mid-session the request of a running stream or list was sent before. A job of
        `Acquisition.call` that forgets the list (`Ecu.forget_list`) and calls this has both sent
        again, so that this file can be read by itself: any job ends a running stream.

        Raises `CaptureError` if `path` exists already or can't be written; a running recording
        goes on then.
        """
        with self._lock:
            named = Path(path)
            self.conclude()
            opened = self._create(named, named, url, pipe=pipe)
            self.stop()
            self._begin(opened)

    def stop(self) -> RecordingStatus | None:
        """End the recording; return its progress, None if there was none."""
        with self._lock:
            self.conclude()
            self._write(self._annotator.last_notes())
            self._close()
            status = self.status
            self._open = None
            return status

    def discard(self) -> None:
        """End the recording and delete its file, unless that existed before, as a pipe does."""
        with self._lock:
            opened, _ = self._open, self.stop()
            if opened is not None:
                with suppress(CaptureError):
                    opened.writer.discard()

    def next_file(self) -> None:
        """Go on in another file, NAME-2.pcapng after NAME.pcapng.

        To be called between two cycles, by a job of `Acquisition.call`, after `Ecu.forget_list`.
        """
        with self._lock:
            if self._running is not None:
                self._continue_in_next_file(self._running)

    def use_instruments(self, ports: Sequence[pcapng.Interface]) -> None:
        """Describe these ports from now on: a running recording goes on in another file.

        To be called as `next_file`.
        """
        with self._lock:
            self.instruments = tuple(ports)
            self.next_file()

    def marker(self, time: float | None = None, label: str = "") -> float | None:
        """Mark a moment, by default now. Return its time, None before any byte or event."""
        with self._lock:
            time = self._time if time is None else time
            if time is not None:
                self._write([note_of(Marker(time, label[:LONGEST_TEXT]))])
            return time

    def text(self, text: str) -> None:
        """Write a person's words, as of now."""
        with self._lock:
            if self._time is not None:
                self._write([note_of(TextNote(self._time, text[:LONGEST_TEXT]))])

    def describe(self, car: Note) -> None:
        """Write a note on the car, into this file and those that follow."""
        with self._lock:
            self._write(self._annotator.describe(car))

    def interrupt(self, time: float, reason: Text) -> None:
        """Begin a gap: the connection is left for a while, for `reason`."""
        with self._lock:
            self._annotator.interrupt(time, reason)

    @property
    def status(self) -> RecordingStatus | None:
        """The recording's progress, also after a failure; None without a recording."""
        with self._lock:
            it = self._open
            if it is None:
                return None
            samples, gaps = self._annotator.samples, self._annotator.gaps
            written = it.written if it.failure else samples
            size = 0 if it.writer.deleted else it.writer.size
            lost = samples - written
            return RecordingStatus(it.writer.path, it.since, size, written, gaps, it.failure, lost)

    @property
    def failure(self) -> CaptureError | None:
        """The reason why the recording ended early; None if it did not."""
        with self._lock:
            return self._open.failure if self._open else None

    # For the wire and the sampler

    def record(self, direction: Direction, data: bytes, time: float) -> None:
        """Take bytes that passed on the wire; of `mikas.link.base.Sink`."""
        with self._lock:
            self._advance(time)
            if (running := self._running) is not None:
                try:  # not `_failing`: this is called for each piece of bytes
                    running.sink.record(direction, data, time + running.later)
                except CaptureError as error:
                    self._fail(running, error)

    def record_instrument(self, number: int, data: bytes, time: float, comment: str = "") -> None:
        """Take what the instrument of this number sent; as `CaptureWriter.record_instrument`.

        Nothing waits here for a packet of the unit, and nothing of the unit is joined with it.
        """
        with self._lock:
            if (running := self._running) is not None:
                with self._failing(running):
                    time += running.later
                    running.writer.record_instrument(number, data, time, comment)

    def note(self, note: Note) -> None:
        """Write a note of the caller. Raises `ValueError` for data that JSON can't hold."""
        with self._lock:
            if self._time is None or note.time >= self._time:  # else about a marker set before
                self._advance(note.time)
            self._write([note])

    def record_event(self, event: Event) -> None:
        """Take an event of the session."""
        with self._lock:
            if self._time is None or event.time > self._time:  # a sample began before it was read
                self._advance(event.time)
            if isinstance(event, UnitFound) and event.another and self._running is not None:
                self._continue_in_next_file(self._running, event)
                return
            self._write(self._annotator.notes_of(event))
            if isinstance(event, ClockChanged):
                self.later += event.later
            running = self._running
            if running is not None and isinstance(running.sink, Coalescer):
                with self._failing(running):
                    running.sink.tick(event.time + running.later)

    # The file

    @property
    def _running(self) -> _Open | None:
        return self._open if self._open is not None and self._open.failure is None else None

    def _create(self, path: Path, named: Path, url: str, *, pipe: bool = False) -> _Open:
        writer = CaptureWriter(path, url=url, pipe=pipe, instruments=self.instruments)
        sink = Coalescer(writer) if self._joined else writer
        return _Open(named, url, writer, sink, self._time, self.later)

    def _begin(self, opened: _Open) -> None:
        self._open = opened
        self._write(self._annotator.head(self._time or 0.0))

    def _continue_in_next_file(self, before: _Open, another: UnitFound | None = None) -> None:
        """Close the file and begin the next one. `another`: the unit that is the reason."""
        self.conclude()
        self._write(self._annotator.last_notes(another.time if another else None))
        self._close()
        if another is not None:
            list(self._annotator.notes_of(another))  # its notes are the new file's head
        try:
            path = _next(before.named)
            opened = self._create(path, before.named, before.url)
        except (CaptureError, OSError) as error:
            if before.failure is None:
                if not isinstance(error, CaptureError):
                    error = capture_error(before.named, error)
                before.failure, before.written = error, self._annotator.samples
            return
        self._begin(opened)
        if self.on_file is not None:
            self.on_file(path)

    def _write(self, notes: Iterable[Note]) -> None:
        for note in notes:  # all of them, also after a failure: the annotator's state follows
            if (running := self._running) is not None:
                with self._failing(running):
                    running.sink.note(moved(note, running.later))

    def _close(self) -> None:
        if (running := self._running) is not None:
            with self._failing(running):
                if isinstance(running.sink, Coalescer):
                    running.sink.flush()
                running.writer.close()

    @contextmanager
    def _failing(self, running: _Open) -> Iterator[None]:
        """Take a `CaptureError` inside for the recording's failure, and close its file."""
        try:
            yield
        except CaptureError as error:
            self._fail(running, error)

    def _fail(self, running: _Open, error: CaptureError) -> None:
        running.failure = error
        # All samples so far are in the file, unless that was deleted.
        running.written = 0 if running.writer.deleted else self._annotator.samples
        with suppress(CaptureError):
            running.writer.close()

    def _advance(self, time: float) -> None:
        self._time = time
        if self._open is not None and self._open.since is None:
            self._open.since = time


def _next(named: Path) -> Path:
    """Return NAME-2.pcapng, or with the first higher number that is free."""
    number = 2
    while os.path.lexists(path := beside(named.with_name(named.stem), f"-{number}{named.suffix}")):
        number += 1
    return path
