"""The recorder of a session: always at the wire, it writes when it is asked to, and never stops it.

    link ──► CaptureTee ──► Recorder ──► Coalescer ──► CaptureWriter ──► NAME.pcapng
    events ──────────────────┘  take: notes in between

A full disk, a folder that is gone, a stick that was pulled out: the file ends with its last whole
block, `failure` says why, and sampling goes on. Another car gets a file of its own, NAME-2.pcapng.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from mikas.errors import CaptureError, MikasError
from mikas.link.tee import Direction
from mikas.recording.capture import CaptureWriter
from mikas.recording.chronicle import Chronicle
from mikas.recording.coalescing import Coalescer, NotedSink
from mikas.recording.notes import Note, marker_note, text_note
from mikas.recording.reader import reason_of
from mikas.sampling.events import UnitFound

if TYPE_CHECKING:
    import os

    from mikas.client import Ecu
    from mikas.sampling.events import Event

_LONGEST_TEXT: Final = 100_000


@dataclass(frozen=True, slots=True)
class RecordingStatus:
    """How far one recording has come. `since`: on the link's clock, once anything was seen.

    `samples` are those in the file; `gaps` counts holes, not the cycles lost in them. With a
    `failure` nothing more is written; `lost`: samples that came since, or went with the file.
    """

    path: Path
    since: float | None
    bytes: int
    samples: int
    gaps: int
    failure: MikasError | None
    lost: int = 0


@dataclass(slots=True)
class _Open:
    """One recording: its file, until that is closed, and how it came to its name."""

    path: Path
    named: Path  # by the user; `path` has a number in it if there were others before
    url: str
    baud: int
    writer: CaptureWriter
    sink: NotedSink
    since: float | None
    failure: MikasError | None = None
    kept: int = 0  # samples that were in the file at the failure


class Recorder:
    """Takes what passes on the wire and what the sampler tells; writes between `start` and `stop`.

    `ecu`: the unit of now, for the head of a recording and to know whether the line echoes.
    `joined`: a packet a response, not one a chunk. `on_file`: told of each file that another one
    led to, in whatever thread that happened. Nothing but `start` raises; any thread may call.
    """

    def __init__(
        self,
        *,
        ecu: Callable[[], Ecu | None] = lambda: None,
        interpretation: str = "corrected",
        joined: bool = True,
        on_file: Callable[[Path], None] | None = None,
    ) -> None:
        self.wire_bytes = 0
        """What the wire carried since this recorder was made; an echo is not counted twice."""
        self.on_file = on_file
        self._ecu = ecu
        self._joined = joined
        self._chronicle = Chronicle(ecu, interpretation)
        self._lock = threading.RLock()
        self._open: _Open | None = None
        self._time: float | None = None  # the latest that was seen on the link's clock

    # What is asked of it

    def start(
        self,
        path: str | os.PathLike[str],
        *,
        url: str,
        baud: int = 9600,
        overwrite: bool = False,
    ) -> None:
        """Records to `path` from here on; a recording that runs is ended first.

        In mid-session a stream or a list that runs was asked for before: `begin_anew`, given to
        `Acquisition.call`, makes the sampler ask again, or this file can't be read without another.

        Raises `CaptureError` if `path` is there already or can't be written; what runs goes on.
        """
        with self._lock:
            named = Path(path)
            opened = self._opened(named, named, url, baud, overwrite=overwrite)
            self.stop()
            self._begin(opened)

    def stop(self) -> RecordingStatus | None:
        """Ends the recording; returns how far it came, None if there was none."""
        with self._lock:
            if self._open is not None and self._open.failure is None:
                self._write(self._chronicle.end())
            if self._open is not None and self._open.failure is None:
                self._close()
            status = self.status
            self._open = None
            return status

    def next_file(self) -> None:
        """Goes on in another file, NAME-2.pcapng after NAME.pcapng.

        To be called between two cycles, by a job of `Acquisition.call`, after `begin_anew`.
        """
        with self._lock:
            if self._open is not None and self._open.failure is None:
                self._move_on(None)

    def marker(self, time: float | None = None, label: str = "") -> float | None:
        """A moment worth finding again; None: now. Returns its time, None if nothing was seen."""
        with self._lock:
            time = self._time if time is None else time
            if time is not None:
                self._write([marker_note(time, label[:_LONGEST_TEXT])])
            return time

    def text(self, time: float | None = None, text: str = "") -> None:
        """A person's words."""
        with self._lock:
            time = self._time if time is None else time
            if time is not None:
                self._write([text_note(time, text[:_LONGEST_TEXT])])

    @property
    def status(self) -> RecordingStatus | None:
        """How far the recording has come, also after a failure; None if there is none."""
        with self._lock:
            it = self._open
            if it is None:
                return None
            told, gaps = self._chronicle.samples, self._chronicle.gaps
            kept = it.kept if it.failure else told
            size = 0 if it.writer.deleted else it.writer.size
            return RecordingStatus(it.path, it.since, size, kept, gaps, it.failure, told - kept)

    @property
    def failure(self) -> MikasError | None:
        """Why the recording broke off, if it did."""
        with self._lock:
            return self._open.failure if self._open else None

    # What it is told

    def record(self, direction: Direction, data: bytes, time: float) -> None:
        """One piece of the wire's history; of `mikas.link.tee.Sink`."""
        with self._lock:
            self._seen(time)
            if direction is Direction.RECEIVED or not self._echoes():
                self.wire_bytes += len(data)
            if self._open is not None and self._open.failure is None:
                try:
                    self._open.sink.record(direction, data, time)
                except CaptureError as error:
                    self._fail(error)

    def note(self, note: Note) -> None:
        """A note of somebody else's. Raises `ValueError` for data that JSON can't hold."""
        with self._lock:
            self._seen(note.time)
            self._write([note])

    def take(self, event: Event) -> None:
        """What the sampler tells."""
        with self._lock:
            if self._time is None or event.time > self._time:  # a sample began before it was read
                self._seen(event.time)
            recording = self._open is not None and self._open.failure is None
            if isinstance(event, UnitFound) and event.another and recording:
                self._move_on(event)
                return
            self._write(self._chronicle.take(event))
            if self._open is not None and isinstance(self._open.sink, Coalescer):
                self._guarded(lambda sink: sink.tick(event.time), self._open.sink)

    # The file

    def _opened(
        self, path: Path, named: Path, url: str, baud: int, *, overwrite: bool = False
    ) -> _Open:
        writer = CaptureWriter(path, url=url, baud=baud, overwrite=overwrite)
        sink = Coalescer(writer, baud=baud) if self._joined else writer
        return _Open(path, named, url, baud, writer, sink, self._time)

    def _begin(self, opened: _Open) -> None:
        self._open = opened
        time = 0.0 if self._time is None else self._time
        self._write(self._chronicle.head(time))

    def _move_on(self, another: UnitFound | None) -> None:
        """Goes on in the next file; `another`: because of that unit."""
        before = self._open
        assert before is not None
        self._write(self._chronicle.end(another.time if another else None))
        if before.failure is None:
            self._close()
        if another is not None:
            list(self._chronicle.take(another))  # its notes are the new file's head
        try:
            path = _next(before.named)
            opened = self._opened(path, before.named, before.url, before.baud)
        except (CaptureError, OSError) as error:
            if before.failure is None:
                before.failure, before.kept = _as_ours(error, before.named), self._chronicle.samples
            return
        self._begin(opened)
        if self.on_file is not None:
            self.on_file(path)

    def _write(self, notes: Iterable[Note]) -> None:
        for note in notes:  # all of them, since making them is what keeps the story up to date
            if self._open is not None and self._open.failure is None:
                try:
                    self._open.sink.note(note)
                except CaptureError as error:
                    self._fail(error)

    def _guarded(self, act: Callable[[Coalescer], None], sink: Coalescer) -> None:
        try:
            act(sink)
        except CaptureError as error:
            self._fail(error)

    def _fail(self, error: MikasError) -> None:
        assert self._open is not None
        self._open.failure = error
        # What was told as sampled is written; unless the file itself is gone.
        self._open.kept = 0 if self._open.writer.deleted else self._chronicle.samples
        with suppress(CaptureError):
            self._open.writer.close()

    def _close(self) -> None:
        assert self._open is not None
        try:
            if isinstance(self._open.sink, Coalescer):
                self._open.sink.flush()
            self._open.writer.close()
        except CaptureError as error:
            self._fail(error)

    def _seen(self, time: float) -> None:
        self._time = time
        if self._open is not None and self._open.since is None:
            self._open.since = time

    def _echoes(self) -> bool:
        ecu = self._ecu()
        return ecu is None or ecu.tester.echoes


def begin_anew(ecu: Ecu) -> None:
    """A job for `Acquisition.call`: what follows is asked for in full, and so can be read alone.

    That there is a job ends a running stream; a list that was set is set again (64).
    """
    ecu.forget_list()


def _next(named: Path) -> Path:
    """NAME-2.pcapng, or the first number behind it that is free."""
    number = 2
    while (path := named.with_name(f"{named.stem}-{number}{named.suffix}")).exists():
        number += 1
    return path


def _as_ours(error: CaptureError | OSError, path: Path) -> CaptureError:
    if isinstance(error, CaptureError):
        return error
    return CaptureError(str(path), reason_of(error))
