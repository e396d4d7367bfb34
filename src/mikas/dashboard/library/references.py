"""Recordings to compare with: those that the user marked, and those of the virtual car.

The user's marks are names of files in a file beside the presets. A recording of the virtual car is
made when it is first requested, on the simulated clock (seconds), and kept in a folder of its own;
the same version of mikas makes the same bytes. Its id contains colons, which no file's name has.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Final

import mikas
from mikas.cancellation import check_cancelled
from mikas.dashboard.errors import NotFound
from mikas.dashboard.library.folder import RecordingFile, RecordingFolder
from mikas.errors import naming_file
from mikas.i18n import Text
from mikas.recording import CaptureWriter
from mikas.recording.annotations.annotator import SessionAnnotator
from mikas.sampling.events import UnitFound
from mikas.saving import KeptFile

MOST_MARKED: Final = 100
_MOST_BYTES: Final = 1 << 17
_PREFIX: Final = "virtual:"
MODELS: Final = ("7.1", "5.4")


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
        self.file = KeptFile(marks, _MOST_BYTES, _names)
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
    part = file.with_name(f"{file.name}.part")
    try:
        sink = CaptureWriter(part, url=url, overwrite=True)
        with sink, mikas.connect(url, sink=sink) as ecu:
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
