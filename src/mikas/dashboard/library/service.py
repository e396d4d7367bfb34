"""The library of recordings: the folder, summaries and open recordings, kept until files change.

Recordings stay open for a while (`open_recordings.py`). The one in progress grows all the time: it
is read again when it is requested some seconds later.

Work that a client causes is done in three lanes (`lanes.py`): `views`, what a screen shows of a
file; `files`, reports and exports, which take long; `answers`, all else that grows with the data:
values of the last hours, searches in them, lists and the user's own files. In each lane one file is
read by one thread at a time for this computer, and by one for the network.

References are recordings to compare with: those that the user marked, and those of the virtual car.
The marks are names of files in a file beside the presets. A recording of the virtual car is made
when it is first requested, on the simulated clock (seconds), and kept in a folder of its own; the
same version of mikas makes the same bytes. Its id contains colons, which no file's name has.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from secrets import token_hex
from typing import Final

from mikas.cancellation import check_cancelled
from mikas.catalog import Catalog
from mikas.client.connecting import ConnectionOptions, open_ecu
from mikas.dashboard.errors import AnswerTookTooLong, NotFound, TookTooLong
from mikas.dashboard.library.folder import LeftOut, RecordingFile, RecordingFolder
from mikas.dashboard.library.lanes import Lane, LaneLimits
from mikas.dashboard.library.open_recordings import IDLE, OpenRecording, OpenRecordings
from mikas.dashboard.memory import give_back_memory
from mikas.errors import naming_file
from mikas.files import beside
from mikas.i18n import Text
from mikas.recording import CaptureWriter
from mikas.recording.annotations.annotator import SessionAnnotator
from mikas.recording.recording import Recording
from mikas.recording.summary import Summary, summarise
from mikas.sampling.events import UnitFound
from mikas.saving import KeptFile

MOST_MARKED: Final = 100
_MOST_BYTES: Final = 1 << 17
_PREFIX: Final = "virtual:"
MODELS: Final = ("7.1", "5.4")
_GROWING: Final = 10.0  # s until the recording in progress is read again
VIEWS: Final = LaneLimits(slots=3, deadline=60.0, places=32, per_address=8)
FILES: Final = LaneLimits(slots=2, deadline=600.0, places=8, per_address=2)
ANSWERS: Final = LaneLimits(slots=2, deadline=20.0, places=48, per_address=16)
_QUIET: Final = 2.0  # s without work, after which freed memory is given back
_SUMMARY_TIME: Final = 10.0  # s for one file; ten hours take some 0.1 s
_LIST_TIME: Final = 30.0  # s for all that were not read before
_TRY_AGAIN: Final = 300.0  # s until a file that took too long is tried again
_SLOW: Final = Text(
    f"reading it took longer than {_SUMMARY_TIME:g} s: the file is damaged, or its disk is slow; "
    "`mikas decode FILE` shows its contents",
    f"чтение заняло больше {_SUMMARY_TIME:g} с: файл повреждён или медленный диск; его содержимое "
    "покажет `mikas decode ФАЙЛ`",
)
_NOT_YET: Final = Text(
    "not read yet, there are many files; reload the list", "ещё не прочитан; обновите список"
)


@dataclass(frozen=True, slots=True)
class Drive:
    """A drive to record: `seconds` of a scenario, `rate` sets of values per second."""

    scenario: str
    seconds: float
    rate: float
    text: Text


DRIVES: Final = {
    "warm-idle": Drive("warm-idle", 60, 5, Text("warm idle", "прогретый, холостой ход")),
    "warm-up": Drive("cold-start", 600, 1, Text("cold start, warm-up", "холодный пуск, прогрев")),
    "drive": Drive("city", 195, 5, Text("city drive", "поездка по городу")),
}
VIRTUAL: Final = {f"{_PREFIX}{name}:{model}": (name, model) for model in MODELS for name in DRIVES}
"""The recordings of the virtual car by id: the drive, and the unit's model."""


class References:
    """`marks`: the file of the marked names; `folder`: of the virtual car's recordings."""

    def __init__(self, marks: Path, folder: Path) -> None:
        self.file: KeptFile[list[str]] = KeptFile(marks, _MOST_BYTES, _names)
        self._folder = folder
        self._changing = threading.Lock()

    def marked(self) -> list[str]:
        """Return the marked recordings, the latest first; none if their file can't be used."""
        return (self.file.load() or [])[:MOST_MARKED]

    def mark(self, name: str, *, on: bool) -> None:
        """Mark a recording, or remove its mark. Raises `UsageError` if that can't be kept."""
        with self._changing:
            names = [other for other in self.marked() if other != name]
            names = [name, *names][:MOST_MARKED] if on else names
            self.file.save(names)

    def virtual(self, identity: str) -> RecordingFile | None:
        """Return a recording of the virtual car, made now if need be; None: another kind of id.

        Raises `NotFound` for an unknown one, `UsageError` if it can't be kept.
        """
        if not identity.startswith(_PREFIX):
            return None
        if identity not in VIRTUAL:
            raise NotFound(name=identity[:60])
        drive, model = VIRTUAL[identity]
        file = self._folder / f"{drive}-{model}-{version('mikas')}.pcapng"
        with naming_file(file):
            if not file.is_file():
                self._folder.mkdir(parents=True, exist_ok=True)
                _record(file, DRIVES[drive], model)
        return RecordingFolder(self._folder).one(file.name)


def _names(stored: object) -> list[str]:
    """Return the marks in the file. Raises `TypeError`."""
    if not isinstance(stored, list) or not all(isinstance(name, str) for name in stored):
        raise TypeError("no list of names")
    return stored


def _record(file: Path, drive: Drive, model: str) -> None:
    """Record the virtual car, as a session does; all of it or nothing."""
    url = f"sim:?clock=simulated&seed=1&scenario={drive.scenario}&model={model}"
    part = beside(file, f".{token_hex(4)}.part")  # another program may make it, too
    try:
        sink = CaptureWriter(part, url=url, overwrite=True)
        with sink, open_ecu(url, _options(file.parent), sink=sink) as ecu:
            now, unit = ecu.tester.link.now, ecu.version_code
            found = UnitFound(now(), unit, ecu.passport(), catalog=ecu.catalog.version)
            for note in SessionAnnotator().notes_of(found):
                sink.note(note)
            ecu.faults()
            end = now() + drive.seconds
            names = [parameter.name for parameter in ecu.catalog.parameters]
            for _ in ecu.watch(*names, method="batch", rate=drive.rate):
                check_cancelled()
                if now() >= end:
                    break
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)


def _options(folder: Path) -> ConnectionOptions:
    """Return options that depend on nothing that the user has learnt or set."""
    return ConnectionOptions(
        journal=folder / "journal.jsonl", state=folder / "units", virtual_units=False
    )


@dataclass(frozen=True, slots=True)
class _Kept:
    """A summary. `until`: on the clock; None: as long as the file does not change."""

    stamp: tuple[int, int, int]
    summary: Summary
    until: float | None = None


@dataclass(eq=False)
class RecordingService:
    """`in_progress`: the file name of the recording in progress; None: there is none.

    `clock`: seconds that never run back. `address`: of a client in the network; None: the client is
    on this computer.
    """

    folder: RecordingFolder
    references: References
    catalog: Catalog
    interpretation: str
    clock: Callable[[], float]
    in_progress: Callable[[], str | None]

    def __post_init__(self) -> None:
        self.views: Lane = Lane(VIEWS, on_end=self._tidy_later)
        self.files: Lane = Lane(FILES, on_end=self._tidy_later)
        self.answers: Lane = Lane(ANSWERS, AnswerTookTooLong, self._tidy_later)
        self._lanes = (self.views, self.files, self.answers)
        self._summaries: dict[str, _Kept] = {}
        self._open = OpenRecordings(self.clock)
        self._tidying: asyncio.TimerHandle | None = None

    def use_catalog(self, catalog: Catalog) -> None:
        """Decode by another catalog; a recording that is being read keeps its own."""
        before, self.catalog = self.catalog, catalog
        if (before.codes, before.models) != (catalog.codes, catalog.models):
            self._summaries.clear()  # they count samples by sizes, and name the unit

    def is_growing(self, file: RecordingFile) -> bool:
        """Whether the recording is in progress."""
        return self.in_progress() == file.id

    def of_any(self, identity: str) -> RecordingFile:
        """Return a recording of the folder, or of the virtual car. Raises `NotFound`."""
        return self.references.virtual(identity) or self.folder.one(identity)

    async def all(
        self, address: str | None
    ) -> tuple[list[tuple[RecordingFile, Summary]], list[LeftOut]]:
        """Return the recordings, the latest first, and the files left out. Raises `Busy`.

        A summary that takes too long has a `problem`; the next call continues with the others.
        """
        end = self.clock() + _LIST_TIME
        listed = []
        with self.views.place(address):
            files, left_out = await self.views.run(self.folder.all, key="", address=address)
            for name in self._summaries.keys() - {file.id for file in files}:
                del self._summaries[name]
            for file in files:
                summary = self._kept(file)
                if summary is None:
                    left = min(_SUMMARY_TIME, end - self.clock())
                    summary = await self._read_for_list(file, left, address)
                listed.append((file, summary))
        return listed, left_out

    def summary(self, file: RecordingFile) -> Summary:
        """Return the summary of `file`, made now or before; in a thread that views this file."""
        kept = self._kept(file)
        if kept is None:
            kept = summarise(file.path, self.catalog)
            self._summaries[file.id] = _Kept(file.stamp, kept)
        return kept

    def opened(self, file: RecordingFile, *, latest: bool = False) -> Recording:
        """Return the recording, opened now or before; in a thread that views this file.

        `latest`: one in progress is read to its present end.
        """
        kept = self._open.pop(file.id)
        if kept is None or not self._is_current(kept, file, latest=latest):
            recording = Recording(file.path, self.catalog, self.interpretation)
            kept = OpenRecording(file.stamp, self.clock(), recording)
        self._open.put(file.id, kept)
        return kept.recording

    async def close(self) -> None:
        """Cancel all work."""
        await asyncio.gather(*(lane.close() for lane in self._lanes))
        if self._tidying is not None:
            self._tidying.cancel()

    def _tidy_later(self) -> None:
        """Tidy once no work has been done for a moment; called when a piece has ended."""
        self._open.close_some()
        self._wait_to_tidy(_QUIET)

    def _wait_to_tidy(self, seconds: float) -> None:
        if self._tidying is not None:
            self._tidying.cancel()
        self._tidying = asyncio.get_running_loop().call_later(seconds, self._tidy)

    def _tidy(self) -> None:
        """Close what was not used for long, and give freed memory back; later again, if need be."""
        self._tidying = None
        if any(lane.is_busy for lane in self._lanes):
            return  # its end comes
        self._open.close_some()
        threading.Thread(target=give_back_memory, name="mikas memory", daemon=True).start()
        if len(self._open):
            self._wait_to_tidy(IDLE)

    def _kept(self, file: RecordingFile) -> Summary | None:
        kept = self._summaries.get(file.id)
        if kept is None or kept.stamp != file.stamp:
            return None
        return kept.summary if kept.until is None or self.clock() < kept.until else None

    async def _read_for_list(
        self, file: RecordingFile, seconds: float, address: str | None
    ) -> Summary:
        if seconds > 0:
            with suppress(TookTooLong):
                return await self.views.run(
                    lambda: self.summary(file), key=file.id, address=address, deadline=seconds
                )
        if seconds < _SUMMARY_TIME:
            return Summary(file.path, file.bytes, problem=_NOT_YET)
        slow = Summary(file.path, file.bytes, problem=_SLOW)
        self._summaries[file.id] = _Kept(file.stamp, slow, self.clock() + _TRY_AGAIN)
        return slow

    def _is_current(self, kept: OpenRecording, file: RecordingFile, *, latest: bool) -> bool:
        if kept.recording.catalog is not self.catalog:
            return False
        is_grown = self.is_growing(file) and kept.stamp[2] == file.stamp[2]
        is_new = is_grown and not latest and self.clock() - kept.at < _GROWING
        return kept.stamp == file.stamp or is_new
