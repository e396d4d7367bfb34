"""Recordings of a virtual fleet, a minute each, and what is asked of a dataset."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from shutil import copytree
from tempfile import TemporaryDirectory

from bench.virtual_fleet import BEGAN, DAY, Drive, record

from mikas.catalog import shipped
from mikas.fleet.adding import Added, add, plan
from mikas.fleet.executors import Runner, Work
from mikas.fleet.interpreting import InterpretingSettings
from mikas.fleet.job import FileOutcome
from mikas.fleet.ledger import FOLDER
from mikas.fleet.places import FoundFile
from mikas.fleet.query.database import opened

MINUTE = Drive(BEGAN, seconds=60.0, rate=4.0, plate="а 101 мр 52", car="ГАЗ-3110")
SETTINGS = InterpretingSettings(shipped())


class HereRunner(Runner):
    """This process itself."""

    def close(self) -> None: ...

    def outcomes(self, work: Work, files: Iterable[FoundFile]) -> Iterator[FileOutcome]:
        return map(work, files)


@cache
def recorded(drive_: str) -> bytes:
    """The bytes of a drive, by its text: each is made once."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "drive.pcapng"
        record(path, eval(drive_, {"Drive": Drive}))
        return path.read_bytes()


def make(path: Path, **changed) -> Path:
    """Write a recording of a minute's drive."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(recorded(repr(replace(MINUTE, **changed))))
    return path


def add_here(*places: object, to: object, settings: InterpretingSettings = SETTINGS) -> Added:
    """Add in this process."""
    planned = plan(map(str, places), str(to), settings)
    return add(planned, str(to), settings, HereRunner())


@cache
def _added(drives: tuple[tuple[str, str], ...]) -> TemporaryDirectory:
    folder = TemporaryDirectory()
    for name, drive in drives:
        path = Path(folder.name) / "in" / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(recorded(drive))
    add_here(Path(folder.name) / "in", to=Path(folder.name) / "set")
    return folder


def make_dataset(home: Path, drives: dict[str, dict[str, object]]) -> Path:
    """Write recordings into `home`/in and their dataset, `home`/set, which is computed once."""
    wanted = {name: repr(replace(MINUTE, **changed)) for name, changed in drives.items()}
    made = _added(tuple(wanted.items())).name
    copytree(made, home, dirs_exist_ok=True)
    for entry in (home / "set" / FOLDER).iterdir():  # where the recordings were found
        entry.write_text(entry.read_text("utf-8").replace(made, str(home)), "utf-8")
    return home / "set"


def ask(dataset: object, sql: str) -> list[tuple]:
    with opened(str(dataset)) as database:
        return list(database.ask(sql).rows)


def counts(result: Added) -> tuple[int, int, int, int]:
    return result.added, result.replaced, result.skipped, len(result.bad)


def files_of(dataset: Path) -> set[str]:
    """The Parquet files of a dataset in a folder, whether they count or not."""
    found = {str(path.relative_to(dataset)) for path in dataset.rglob("*.parquet")}
    return {name for name in found if not name.startswith(".parts")}


__all__ = ["BEGAN", "DAY", "MINUTE", "SETTINGS", "Drive", "record"]
