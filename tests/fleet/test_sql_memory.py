"""The memory of a question is bounded, and nothing of it comes to a disk."""

from __future__ import annotations

import sys

import pytest

from fleet_rig import add_here, ask, make
from mikas.errors import UsageError
from mikas.fleet.query import database as module
from mikas.fleet.query.database import opened
from mikas.fleet.query.memory import bounded_memory

BOUNDED = pytest.mark.skipif(sys.platform != "linux", reason="only Linux bounds a process")
SORT = "SELECT * FROM (SELECT hash(range) h, md5(range::VARCHAR) FROM range(2000000)) ORDER BY h"


@pytest.fixture(scope="module")
def dataset(tmp_path_factory) -> str:
    home = tmp_path_factory.mktemp("fleet")
    add_here(make(home / "drive.pcapng"), to=home / "set")
    return str(home / "set")


def test_a_sort_that_has_no_room_is_an_error_and_spills_nothing(
    dataset, tmp_path, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(module, "memory_limit", lambda: 32 << 20)
    with pytest.raises(UsageError, match=r"more than .* GB of memory; ask for less"):
        ask(dataset, SORT)
    assert not list(tmp_path.iterdir())
    assert ask(dataset, "SELECT current_setting('temp_directory')") == [("",)]


@BOUNDED
def test_a_value_of_gigabytes_is_an_error_before_it_is_made(dataset) -> None:
    import resource

    before = resource.getrlimit(resource.RLIMIT_DATA)
    with opened(dataset) as database:
        with pytest.raises(UsageError, match=r"more than .* GB"), bounded_memory():
            list(database.ask("SELECT range(1000000000)").rows)  # 8 GB, uncounted by duckdb
        assert list(database.ask("SELECT count(*) FROM drives").rows) == [(1,)]
    assert resource.getrlimit(resource.RLIMIT_DATA) == before


@BOUNDED
def test_rows_that_python_has_no_room_for_are_the_same_error() -> None:
    with pytest.raises(UsageError, match=r"more than .* GB"), bounded_memory():
        bytearray(100 << 30)
