"""What the recorder's tests share: a session's events, a small disk, and what a file holds."""

from __future__ import annotations

import errno
import weakref
from pathlib import Path

from mikas.catalog import load
from mikas.client import Passport
from mikas.errors import EchoOnly, NoResponse
from mikas.link.base import Direction
from mikas.recording import CaptureReader
from mikas.recording.capture.notes import Note
from mikas.recording.capture.reader import Packet, Problem
from mikas.recording.recorder import Recorder
from mikas.sampling.events import (
    CycleFailed,
    Event,
    LineState,
    PlanChanged,
    Sampled,
    StateChanged,
    UnitFound,
)
from mikas.sampling.plan import Plan, PlannedParameter
from mikas.sampling.session import SamplingSession

SENT, RECEIVED = Direction.SENT, Direction.RECEIVED
CATALOG = load()
PLAN = Plan(
    (PlannedParameter(CATALOG.parameter("TWAT")), PlannedParameter(CATALOG.parameter("FREQ"), 10)),
    "stream",
)
PASSPORT = Passport(("A", "B", None), ("C", "D", "E", "F", "G"))
_SESSIONS: weakref.WeakKeyDictionary[Recorder, SamplingSession] = weakref.WeakKeyDictionary()
OTHER = Passport(("Z", "B", None), ("C", "D", "E", "F", "G"))


def unit(
    time: float, passport: Passport = PASSPORT, *, another: bool = False, echo: bool = True
) -> UnitFound:
    return UnitFound(
        time, 0x0A, passport, another, adapter="an adapter", echo=echo, catalog=CATALOG.version
    )


def sampled(time: float) -> Sampled:
    return Sampled(time, {}, {})


def gap(time: float) -> CycleFailed:
    return CycleFailed(time, NoResponse(seconds=0.5))


def plan(time: float) -> PlanChanged:
    return PlanChanged(time, PLAN)


def state(time: float, which: LineState) -> StateChanged:
    error = EchoOnly() if which is LineState.ECHO_ONLY else None
    return StateChanged(time, which, error)


def begin_session(recorder, time: float = 1.0) -> None:
    """Pass the first events of a session to the recorder."""
    for event in (
        state(time, LineState.ECU_ALIVE),
        unit(time + 0.1),
        plan(time + 0.2),
        state(time + 0.3, LineState.SAMPLING),
    ):
        take(recorder, event)


def take(recorder: Recorder, event: Event) -> None:
    """Let the recorder's session take `event`: gaps follow from several of them."""
    if recorder not in _SESSIONS:
        weak = weakref.proxy(recorder)

        def record(event: Event) -> None:
            weak.record_event(event)

        _SESSIONS[recorder] = SamplingSession(record)
    for _ in _SESSIONS[recorder].events_of(event):
        pass


def notes(path: Path) -> list[Note]:
    return list(CaptureReader(path).notes())


def kinds(path: Path) -> list[str]:
    return [str(note.kind) for note in notes(path)]


def wire(path: Path) -> dict[Direction, bytes]:
    """All bytes of each direction, and no damage."""
    got = {SENT: b"", RECEIVED: b""}
    for item in CaptureReader(path):
        assert not isinstance(item, Problem), item.text.en
        assert isinstance(item, Packet)
        got[item.direction] += item.data
    return got


class SmallDisk:
    """A disk with room for so many bytes, then full, at whatever byte that is."""

    def __init__(self, monkeypatch) -> None:
        self.room = 1 << 30
        opened = Path.open

        def small(path, mode="r", *args, **more):
            file = opened(path, mode, *args, **more)
            return _OnSmallDisk(self, file) if more.get("buffering") == 0 else file

        monkeypatch.setattr(Path, "open", small)


class _OnSmallDisk:
    def __init__(self, disk: SmallDisk, file) -> None:
        self._disk, self._file = disk, file

    def write(self, data) -> int:
        taken = self._file.write(bytes(data)[: self._disk.room])
        self._disk.room -= taken
        if not taken:
            raise OSError(errno.ENOSPC, "No space left on device")
        return taken

    def __getattr__(self, name):
        return getattr(self._file, name)
