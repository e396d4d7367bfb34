"""The freeze frames of the connected unit: taken when a fault is first seen, kept in a folder.

    FaultHistory.on_reading ──► take ──► frame at once ──► five seconds later with what followed

Each is a file, so that it survives the program; at most thirty of a unit, the oldest go first. They
stay when the faults are erased, until the user deletes them. Those of this program get other dates,
and files, when the computer's date is set (`follow_date`).
"""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from mikas import unkept
from mikas.client.limits import unit_file
from mikas.dashboard.session.history import History
from mikas.errors import MikasError, UsageError, naming_file
from mikas.files import read_json
from mikas.i18n import Text
from mikas.recording.freeze_frames import (
    AROUND,
    LONGEST,
    Breaks,
    FreezeFrame,
    frame_from,
    frame_of,
    new_faults,
)
from mikas.sampling.events import Event, FaultReading, Gap, UnitFound
from mikas.saving import save
from mikas.virtual import VIRTUAL_PASSPORT

_MOST: Final = 30
_BREAKS: Final = 100
_MOST_BYTES: Final = 4 << 20
_LATER: Final = 0.5  # s after the last row that is wanted
_UNKEPT: Final = Text(
    "Freeze frames can't be saved in {place} ({why}): they stay until this program ends.",
    "Стоп-кадры не сохраняются в {place} ({why}): они останутся только до завершения программы.",
)


@dataclass(eq=False)
class FreezeFrameStore:
    """Frames by id, those of the unit of the latest `begin_unit`. Any thread may call.

    `_virtual_units`: whether those of virtual units are kept in the folder as well. `_later`: by
    how many seconds the date was set since the program began.
    """

    _folder: Path
    _history: History
    _now: Callable[[], float]
    _virtual_units: bool = True
    _later: Callable[[], float] = lambda: 0.0

    def __post_init__(self) -> None:
        self._lock = threading.Lock()  # held briefly: the sampling thread takes it
        self._disk = threading.Lock()  # held while a file is written or deleted; before `_lock`
        self._own: Path | None = None  # the folder of the unit
        self._kept = True  # in that folder
        self._frames: dict[str, FreezeFrame] = {}
        self._pending: list[FreezeFrame] = []  # to be completed, by the links' clock
        self._dated: dict[Path, float] = {}  # files of this program: `_later` of their dates
        self._breaks = Breaks()  # the latest, by the links' clock

    def begin_connection(self, time: float) -> None:
        """No value from before is of a moment from here on."""
        begins = (*self._breaks.connections, time)[-_BREAKS:]
        self._breaks = replace(self._breaks, connections=begins)

    def add_event(self, event: Event) -> None:
        """Note the gaps, and when another unit answers; in the sampling thread."""
        breaks = self._breaks
        if isinstance(event, Gap) and event.began not in breaks.gaps:
            self._breaks = replace(breaks, gaps=(*breaks.gaps, event.began)[-_BREAKS:])
        elif isinstance(event, UnitFound):
            if event.another:
                self._breaks = replace(breaks, units=(*breaks.units, event.time)[-_BREAKS:])
            self.begin_unit(event)

    def begin_unit(self, unit: UnitFound) -> None:
        """Show the frames of `unit` from here on; also those so far, if it is the same one."""
        if unit.version_code is None or unit.passport is None:
            return
        pieces = unit.passport.pieces
        own = unit_file(self._folder, unit.version_code, pieces).with_suffix("")
        with self._lock:
            if own == self._own:
                return
            if unit.another:
                self._frames, self._pending = {}, []
            elif self._own is not None:  # more of its passport is known now
                self._move_files(self._own, own)
                self._dated = {
                    own / file.name if file.parent == self._own else file: later
                    for file, later in self._dated.items()
                }
            self._own = own
            self._kept = self._virtual_units or VIRTUAL_PASSPORT not in pieces
            files = _files(own)[:_MOST]
            self._frames |= {frame.id: frame for frame in map(_load, files) if frame}

    def _move_files(self, before: Path, own: Path) -> None:
        """Move the files to the folder of the whole passport, which may have frames, too."""
        with unkept.saying_once(_UNKEPT, self._folder):
            for file in _files(before):
                own.mkdir(parents=True, exist_ok=True)
                file.replace(own / file.name)
        with suppress(OSError):  # an empty folder takes nothing
            before.rmdir()

    @property
    def frames(self) -> list[FreezeFrame]:
        """The frames, the latest first."""
        with self._lock:
            return sorted(self._frames.values(), key=lambda it: (-it.seen, it.code))

    def keep_frames_of(self, reading: FaultReading, before: FaultReading | None) -> None:
        """Keep the values around each fault that `before` does not have; None: all are old."""
        if before is None or self._own is None:
            return
        for code, without, read in new_faults([before, reading]):
            if frame := self._make(code, without, read):
                self._keep(frame)
                with self._lock:
                    self._pending.append(frame)

    def follow_date(self) -> None:
        """Give the frames of this program their dates: the computer's date was set."""
        moved = self._moved()
        if moved:  # not in the sampling thread
            threading.Thread(target=self._write_moved, args=(moved,), daemon=True).start()

    def _moved(self) -> dict[Path, tuple[float, FreezeFrame | None]]:
        """Move the frames; return the files to be moved, by how much, and the frames shown."""
        later = self._later()
        found: dict[Path, tuple[float, FreezeFrame | None]] = {}
        with self._lock:
            for file, before in list(self._dated.items()):
                if before == later:
                    continue
                del self._dated[file]
                frame = self._frames.pop(file.stem, None) if file.parent == self._own else None
                if frame is not None:
                    frame = frame.moved(later - before)
                    self._frames[frame.id] = frame
                    self._dated[_file(file.parent, frame)] = later
                found[file] = later - before, frame
        return found

    def _write_moved(self, moved: dict[Path, tuple[float, FreezeFrame | None]]) -> None:
        for file, (seconds, shown) in moved.items():
            with self._disk, unkept.saying_once(_UNKEPT, self._folder):
                frame = shown or ((kept := _load(file)) and kept.moved(seconds))
                if frame is None or (shown and not self._kept):
                    continue
                if shown is None or self._frames.get(shown.id) is shown:  # else moved again
                    save(_file(file.parent, frame), json.dumps(frame.as_json()))
                file.unlink(missing_ok=True)

    def follow(self, time: float) -> None:
        """Complete the frames whose last row is there; called with each event."""
        if not self._pending:
            return
        with self._lock:
            ripe = [it for it in self._pending if time >= it.seen + AROUND + _LATER]
            self._pending = [it for it in self._pending if it not in ripe]
        self._complete(ripe)

    def finish(self) -> None:
        """Complete all frames with the values there are: the connection ends."""
        with self._lock:
            ripe, self._pending = self._pending, []
        self._complete(ripe, at_once=True)

    def delete(self, identity: str) -> bool:
        """Delete a frame; False: there is none of this id. Raises `UsageError` if it stays."""
        with self._disk:
            with self._lock:
                own, frame = self._own, self._frames.pop(identity, None)
                later = self._later()
                dropped = [it for it in self._pending if it.moved(later).id == identity]
                self._pending = [it for it in self._pending if it not in dropped]
            if frame is not None and own is not None:
                try:
                    _delete(_file(own, frame))
                except UsageError:
                    with self._lock:
                        self._frames[identity] = frame
                        self._pending += dropped
                    raise
        return frame is not None

    def _complete(self, ripe: list[FreezeFrame], *, at_once: bool = False) -> None:
        for early in ripe:
            frame = self._make(early.code, early.without, early.seen)
            if frame is None:  # a gap before its moment is known by now
                self._discard(early)
            elif frame.id == early.id:
                self._keep(frame, at_once=at_once)

    def _discard(self, early: FreezeFrame) -> None:
        with suppress(UsageError):  # a file that stays is shown at the next start only
            self.delete(early.moved(self._later()).id)

    def _make(self, code: int, without: float, read: float) -> FreezeFrame | None:
        rows = self._history.rows(self._now() - read + LONGEST + 2 * AROUND)
        return frame_of(code, without, read, rows, self._breaks)

    def _keep(self, taken: FreezeFrame, *, at_once: bool = False) -> None:
        """Keep a frame that was `taken` by the links' clock, with its dates."""
        self.follow_date()  # the one that it completes
        later = self._later()
        frame = taken.moved(later)
        with self._lock:
            own = self._own
            self._frames[frame.id] = frame
            if own is not None:
                self._dated[_file(own, frame)] = later
            for identity in sorted(self._frames, key=lambda it: self._frames[it].seen)[:-_MOST]:
                del self._frames[identity]
        if own is None or not self._kept:
            return
        if at_once:
            self._write(own, frame)
        else:  # a file's way to the disk may take a while; sampling goes on
            threading.Thread(target=self._write, args=(own, frame), daemon=True).start()

    def _write(self, own: Path, frame: FreezeFrame) -> None:
        with self._disk, unkept.saying_once(_UNKEPT, self._folder):
            with self._lock:
                if own == self._own and self._frames.get(frame.id) is not frame:
                    return  # deleted, or completed meanwhile
            own.mkdir(parents=True, exist_ok=True)
            save(_file(own, frame), json.dumps(frame.as_json()))
            for file in _files(own)[_MOST:]:
                file.unlink(missing_ok=True)


def _file(folder: Path, frame: FreezeFrame) -> Path:
    return folder / f"{frame.id}.json"


def _delete(file: Path) -> None:
    """Delete a file, if it could be saved. Raises `UsageError`."""
    if os.path.lexists(file):
        with naming_file(file):
            file.unlink()


def _files(folder: Path) -> list[Path]:
    """Return the files of frames, the latest first."""
    try:
        names = [it.name for it in folder.iterdir() if it.suffix == ".json"]
    except OSError:
        return []
    return [folder / name for name in sorted(names, key=_time_of, reverse=True)]


def _time_of(name: str) -> float:
    try:
        return float(name.partition("-")[0])
    except ValueError:
        return 0.0


def _load(file: Path) -> FreezeFrame | None:
    try:
        return frame_from(read_json(file, _MOST_BYTES))
    except (OSError, ValueError, MikasError):
        return None
