"""A disk, a network or a system that fails says nothing of the files: none is dropped for it, and
none is called damaged.
"""

from __future__ import annotations

import errno
import os
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import fsspec
import pytest
from fsspec.implementations.local import LocalFileSystem

from fleet_rig import BEGAN, DAY, add_here, ask, counts, make_dataset
from mikas.cli.main import run
from mikas.errors import FleetError
from mikas.fleet.query import table_system
from mikas.fleet.query.database import Database, opened
from mikas.fleet.stores import store
from mikas.i18n import Text

ROWS = "SELECT count(*), count(DISTINCT drive) FROM samples"
FAILURES = (errno.EIO, errno.EACCES, errno.EMFILE, errno.ETIMEDOUT)


@pytest.fixture
def home(tmp_path) -> Path:
    other = {"began": BEGAN + DAY, "plate": "Е777КХ99"}
    return make_dataset(tmp_path, {"one.pcapng": {}, "other.pcapng": other})


@pytest.mark.parametrize("number", FAILURES)
def test_no_entry_is_dropped_for_a_failure_of_the_disk(home, tmp_path, monkeypatch, number) -> None:
    """One error of a network disk let `fleet add` remove every entry of the ledger."""
    entries = sorted((home / "_ledger").iterdir())
    status = Path.lstat

    def failing(path: Path) -> os.stat_result:
        if path.suffix == ".parquet":
            raise OSError(number, os.strerror(number), str(path))
        return status(path)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "lstat", failing)
        for use in (lambda: ask(home, ROWS), lambda: add_here(tmp_path / "in", to=home)):
            with pytest.raises(FleetError):
                use()
    assert sorted((home / "_ledger").iterdir()) == entries
    assert counts(add_here(tmp_path / "in", to=home)) == (0, 0, 2, 0)


class _Answer(Exception):
    """The answer of a web server, as aiohttp raises it."""

    def __init__(self, status: int) -> None:
        super().__init__(f"{status}, the server's words")
        self.status = status


@pytest.mark.parametrize("cause", [_Answer(401), _Answer(403), _Answer(500), TimeoutError("words")])
def test_what_a_web_server_refuses_is_not_called_missing(home, monkeypatch, cause) -> None:
    """It was said that this is no dataset: fsspec has `FileNotFoundError` for every failure."""
    system = fsspec.filesystem("memory")
    system.put(str(home), "/web", recursive=True)
    info = type(system).info

    def refused(self, path: str, **more: object) -> dict:
        if path.endswith((".json", ".parquet")):
            raise FileNotFoundError(path) from cause
        return info(self, path, **more)

    monkeypatch.setattr(type(system), "info", refused)
    with pytest.raises(FleetError, match=r"words|timed out") as failed:
        ask("memory://web", ROWS)
    assert "no dataset" not in str(failed.value)
    for missing in (_Answer(404), _Answer(410), FileNotFoundError(), None):
        cause = missing
        with pytest.raises(FleetError, match="no dataset"):
            ask("memory://web", ROWS)
    system.rm("/web", recursive=True)


@pytest.mark.parametrize("number", FAILURES)
@pytest.mark.parametrize("when", ["open", "read"])
def test_a_table_that_the_system_does_not_give_is_not_called_damaged(
    home, monkeypatch, number, when
) -> None:
    """An answer without its rows came, and the advice to remove the file."""
    whole = table_system.open_regular

    class Failing:
        def __init__(self, file) -> None:
            self.file = file

        def read(self, _: int = -1) -> bytes:
            raise OSError(number, os.strerror(number))

        def __getattr__(self, name: str):
            return getattr(self.file, name)

    def failing(path: Path, **given):
        if "A101MP52" not in str(path):
            return whole(path, **given)
        if when == "open":
            raise OSError(number, os.strerror(number), str(path))
        return Failing(whole(path, **given))

    with monkeypatch.context() as patch:
        patch.setattr(table_system, "open_regular", failing)
        with pytest.raises(FleetError, match="A101MP52") as failed:
            ask(home, ROWS)
    assert "amaged" not in str(failed.value)
    assert ask(home, ROWS) == [(2 * 239, 2)]


class NoSizes(LocalFileSystem):
    """A file system like a web server's: the lists of its folders have no sizes."""

    protocol = "nosizes"

    def ls(self, path: str, detail: bool = False, **given):
        found = super().ls(path, detail=detail, **given)
        return [{**it, "size": None} for it in found] if detail else found


def test_a_list_of_files_without_sizes_costs_no_recording(home, tmp_path) -> None:
    """Over HTTP every recording was left out as changed."""
    fsspec.register_implementation("nosizes", NoSizes, clobber=True)
    with opened(f"nosizes://{home}") as database:
        assert list(database.ask(ROWS).rows) == [(2 * 239, 2)]
        assert database.ledger.refused == {}


def test_what_a_question_has_left_out_is_named(home, monkeypatch, capsys) -> None:
    asked = Database.ask

    def finding(database: Database, sql: str):
        entry = next(iter(database.ledger.entries.values()))
        database.ledger.refuse(entry, Text("it is odd", "она странная"))
        return asked(database, sql)

    monkeypatch.setattr(Database, "ask", finding)
    assert run(["fleet", "sql", str(home), ROWS]) == 0
    assert "it is odd" in capsys.readouterr().err


@pytest.mark.parametrize("command", [["sql", "x", "SELECT 1"], ["report", "x"]])
def test_without_fsspec_the_extra_to_install_is_named(command, monkeypatch, capsys) -> None:
    monkeypatch.setitem(sys.modules, "fsspec", None)
    assert run(["fleet", *command]) == 2
    assert "mikas[fleet]" in capsys.readouterr().err


def test_threads_that_read_one_table_each_get_their_own_part(home) -> None:
    """A seek came between another thread's seek and read: intact files were called damaged."""
    (path, *_) = home.rglob("samples/**/*.parquet")
    whole, name = path.read_bytes(), path.relative_to(home).as_posix()
    files = table_system.DatasetFileSystem(store(str(home)), {name: len(whole)})
    with ThreadPoolExecutor(1) as other:
        file = files.open(f"dataset://{name}")
        file.seek(100)
        other.submit(file.seek, 7).result()
        assert file.read(20) == whole[100:120]
        assert other.submit(file.read, 5).result() == whole[7:12]
        assert (file.read(5), file.tell()) == (whole[120:125], 125)
        assert file.seek(-3, os.SEEK_END) == len(whole) - 3
        del file
