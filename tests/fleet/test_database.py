"""Questions by SQL: the views, what is refused, and where an error is."""

from __future__ import annotations

import re
import subprocess
import sys

import duckdb
import pytest
from packaging.version import Version

from fleet_rig import BEGAN, DAY, add_here, ask, counts, make
from mikas.errors import FleetError, UsageError
from mikas.fleet.query.database import opened
from mikas.fleet.tables import PARTITIONS, TABLES


@pytest.fixture(scope="module")
def dataset(tmp_path_factory) -> str:
    """Two drives of one car, one of another; with a name that duckdb takes for a pattern."""
    home = tmp_path_factory.mktemp("fleet")
    make(home / "in" / "1.pcapng")
    make(home / "in" / "2.pcapng", began=BEGAN + DAY, gap=(20.0, 25.0))
    make(home / "in" / "3.pcapng", plate="Е777КХ99", faults=(13,))
    add_here(home / "in", to=home / "a [set]")
    (home / "a [set]" / "beside.csv").write_text("a\n1\n")
    return str(home / "a [set]")


def test_the_views_have_the_columns_of_the_tables(dataset) -> None:
    for table, columns in TABLES.items():
        got = [(row[0], row[1]) for row in ask(dataset, f"DESCRIBE {table}")]
        wanted = [*PARTITIONS.items(), *columns.items()]
        assert got[: len(wanted)] == wanted
        assert (len(got) > len(wanted)) == (table == "samples")


def test_a_table_without_a_file_is_empty(tmp_path) -> None:
    add_here(make(tmp_path / "drive.pcapng"), to=tmp_path / "set")
    assert ask(tmp_path / "set", "SELECT car, day, seconds FROM gaps") == []
    (tmp_path / "in").mkdir()
    add_here(tmp_path / "in", to=tmp_path / "none")
    for table in TABLES:
        assert ask(tmp_path / "none", f"SELECT count(*) FROM {table}") == [(0,)]


@pytest.mark.parametrize(
    "sql",
    [
        "SELECT count(*) FROM read_text('/etc/passwd')",
        "SELECT * FROM '/etc/passwd'",
        "SELECT * FROM read_csv('beside.csv')",
        "SELECT * FROM read_text('dataset://../in/1.pcapng')",
        "SELECT * FROM glob('/*')",
        "SELECT * FROM 'https://example.org/x.parquet'",
        "SELECT * FROM 's3://bucket/x.parquet'",
        "COPY drives TO '/tmp/mikas-out.csv'",
        "CREATE TABLE mine AS SELECT 1",
        "DROP VIEW drives",
        "SET enable_external_access = true",
        "INSTALL httpfs",
        "LOAD httpfs",
        "ATTACH '/tmp/x.db'",
        "PRAGMA database_list",
        "SELECT 1; DROP VIEW drives",
        "/* */ EXPLAIN ANALYZE CREATE TABLE mine AS SELECT 1",
        "EXPLAIN ANALYZE DROP VIEW drives",
        "SELECT * FROM database",
        "",
        "  ;  ",
        "-- nothing",
    ],
)
def test_nothing_but_the_views_can_be_reached_or_changed(dataset, sql) -> None:
    with opened(dataset) as database:
        with pytest.raises(UsageError):
            list(database.ask(sql).rows)
        assert len(list(database.ask("SELECT * FROM drives").rows)) == 3


@pytest.mark.parametrize(
    "sql",
    [
        "EXPLAIN SELECT car FROM drives",
        "explain analyze FROM drives",
        "EXPLAIN (FORMAT json) FROM drives",
        "DESCRIBE drives",
        "SUMMARIZE drives",
        "WITH it AS (FROM drives) FROM it",
        "VALUES (1)",
    ],
)
def test_every_question_is_answered(dataset, sql) -> None:
    assert ask(dataset, sql)


def test_explain_writes_nothing_into_the_dataset(tmp_path) -> None:
    add_here(make(tmp_path / "drive.pcapng"), to=tmp_path / "set")
    for more in ("", "/* and */ ", "(FORMAT json) "):
        sql = f"EXPLAIN ANALYZE {more}COPY drives TO '{tmp_path / 'set' / 'more.parquet'}'"
        with pytest.raises(UsageError):
            ask(tmp_path / "set", sql)
    assert not (tmp_path / "set" / "more.parquet").exists()


@pytest.mark.parametrize("parent", ["car=OTHER/day=2020-01-01", "drive=D", "a=b"])
def test_folders_above_a_dataset_are_no_columns_of_it(tmp_path, parent) -> None:
    home = tmp_path / parent / "set"
    home.mkdir(parents=True)
    add_here(make(tmp_path / "drive.pcapng"), to=home)
    ((key,),) = ask(home, "SELECT DISTINCT recording FROM drives")
    assert ask(home, "SELECT car, CAST(day AS VARCHAR), drive FROM drives") == [
        ("A101MP52", "2026-03-02", key)
    ]
    assert [row[0] for row in ask(home, "DESCRIBE gaps")] == [
        "car", "day", "drive", "time", "utc", "seconds", "en", "ru"
    ]  # fmt: skip


@pytest.mark.parametrize("verb", ["SUMMARIZE", "DESCRIBE", "FROM", "SELECT 1; FROM"])
@pytest.mark.parametrize("name", ["../recs/single.parquet", "x.parquet", "drives/*.parquet"])
def test_a_file_that_the_sql_names_is_no_damaged_one(dataset, verb, name) -> None:
    with pytest.raises(UsageError) as failed:
        ask(dataset, f"{verb} 'dataset://{name}'")
    assert not isinstance(failed.value, FleetError)
    assert "Traceback" not in str(failed.value)


def test_now_is_in_utc_as_the_dataset_is(dataset, monkeypatch) -> None:
    monkeypatch.setenv("TZ", "Asia/Vladivostok")
    asked = "SELECT TIMESTAMP '2026-03-02 12:00' = TIMESTAMPTZ '2026-03-02 12:00+00'"
    assert ask(dataset, asked) == [(True,)]
    assert ask(dataset, "SELECT now()::TIMESTAMP > max(utc) FROM samples") == [(True,)]


def test_a_time_with_a_zone_is_an_error_that_says_what_to_write(dataset, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "pytz", None)
    if Version(duckdb.__version__) >= Version("2.0.1"):  # it needs no pytz
        ((time,),) = ask(dataset, "SELECT now()")
        assert time.tzinfo is not None
        return
    with pytest.raises(UsageError, match=r"now\(\)::TIMESTAMP"):
        ask(dataset, "SELECT now()")


def test_in_a_dataset_read_by_python_a_missing_file_is_named(tmp_path) -> None:
    home = tmp_path / "a [set]"
    add_here(make(tmp_path / "drive.pcapng"), to=home)
    (table,) = home.rglob("faults/*/*/*.parquet")
    with opened(str(home)) as database:
        table.unlink()
        with pytest.raises(FleetError, match=table.name) as at_question:
            list(database.ask("FROM faults").rows)
    assert "Traceback" not in str(at_question.value)
    with opened(str(home)) as database:
        assert list(database.ask("FROM faults").rows) == []
        ((_, reason),) = database.ledger.refused.items()
        assert table.name in reason.en


def test_a_table_that_becomes_a_link_or_shorter_while_it_is_asked_is_named_with_the_reason(
    tmp_path,
) -> None:
    home = tmp_path / "set"
    add_here(make(tmp_path / "drive.pcapng"), to=home)
    (table,) = home.rglob("faults/*/*/*.parquet")
    sound = tmp_path / "elsewhere.parquet"
    sound.write_bytes(table.read_bytes())
    with opened(str(home)) as database:
        table.unlink()
        table.symlink_to(sound)
        with pytest.raises(FleetError, match=f"{table.name}.*link") as linked:
            list(database.ask("FROM faults").rows)
    table.unlink()
    table.write_bytes(sound.read_bytes())
    with opened(str(home)) as database:
        table.write_bytes(sound.read_bytes()[:10])
        with pytest.raises(FleetError, match=f"{table.name}.*shorter") as cut:
            list(database.ask("FROM faults").rows)
    for failed in (linked, cut):
        assert not re.search("Traceback|Errno", str(failed.value))


def test_a_text_that_is_not_utf_8_is_no_question(dataset) -> None:
    with pytest.raises(UsageError, match="not UTF-8"):
        ask(dataset, "SELECT '\udcff'")
    assert ask(dataset, "SELECT 's3://me@host'") == [("s3://me@host",)]


def test_a_file_of_the_dataset_that_is_gone_or_damaged_is_named(tmp_path) -> None:
    recording = make(tmp_path / "in" / "drive.pcapng")
    add_here(recording, to=tmp_path / "set")
    (table,) = (tmp_path / "set").glob("faults/*/*/*.parquet")
    with opened(str(tmp_path / "set")) as database:
        sound = table.read_bytes()
        table.write_bytes(b"PAR1")
        for question in (database.rows, lambda sql: list(database.ask(sql).rows)):
            with pytest.raises(FleetError, match="faults"):
                question("SELECT * FROM faults")
        table.write_bytes(sound)
    table.write_bytes(b"PAR1")
    with opened(str(tmp_path / "set")) as database:
        ((entry, reason),) = database.ledger.refused.items()
        assert list(database.ask("SELECT count(*) FROM drives").rows) == [(0,)]
    assert table.name.startswith(entry.split("/")[1].removesuffix(".json"))
    assert "`mikas fleet add` makes it anew" in reason.en
    table.unlink()
    assert counts(add_here(recording, to=tmp_path / "set")) == (1, 0, 0, 0)
    assert table.read_bytes() == sound
    table.unlink()
    recording.unlink()
    (bad,) = add_here(tmp_path / "in", to=tmp_path / "set").bad
    assert (bad.file, "no longer in the dataset" in bad.reason.en) == (str(recording), True)
    assert ask(tmp_path / "set", "SELECT count(*) FROM drives") == [(0,)]
    assert counts(add_here(tmp_path / "in", to=tmp_path / "set")) == (0, 0, 0, 0)


_HAS_OPENED_ALL_IT_MAY = """
import os, resource, sys
others = [os.open(os.devnull, os.O_RDONLY) for _ in range(300)]  # of the program itself
used = len(os.listdir("/dev/fd"))
hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
resource.setrlimit(resource.RLIMIT_NOFILE, (used + 1, hard))
from mikas.fleet.query.database import opened
with opened(sys.argv[1]) as database:
    print(*database.ask("SELECT count(*) FROM drives, faults").rows)
"""


@pytest.mark.posix
def test_more_files_than_a_process_may_open_are_read(tmp_path) -> None:
    """In a process of its own: a thread of another test may open files at any moment."""
    for number in range(5):
        make(tmp_path / "in" / f"{number}.pcapng", seconds=3.0, began=BEGAN + number * DAY)
    add_here(tmp_path / "in", to=tmp_path / "set")
    done = subprocess.run(
        [sys.executable, "-c", _HAS_OPENED_ALL_IT_MAY, str(tmp_path / "set")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.stdout, done.stderr) == ("(25,)\n", "")


def test_python_variables_are_no_tables(dataset) -> None:
    import pandas as pd

    secrets = pd.DataFrame({"a": [1]})
    with pytest.raises(UsageError, match="secrets"):
        ask(dataset, "SELECT * FROM secrets")
    assert len(secrets) == 1


@pytest.mark.parametrize(
    ("sql", "place", "words"),
    [
        ("SELECT * FORM drives", ", column 15", "syntax error"),
        ("SELECT speed FROM drives", ", column 8", "speed"),
        ("SELECT *\nFROM drives\nWHERE nothing > 1", ", line 3, column 7", "nothing"),
        ("SELECT car FROM drive", ", column 17", "drives"),
        ("SELECT CAST(car AS INTEGER) FROM drives", ", column 8", "Could not convert"),
        (f"SELECT {'1 + ' * 60} missing FROM drives", ", column 249", "missing"),
    ],
)
def test_an_error_has_its_place(dataset, sql, place, words) -> None:
    with pytest.raises(UsageError) as failed:
        ask(dataset, sql)
    assert str(failed.value).startswith(f"SQL{place}: ")
    assert words in str(failed.value)
    assert "\n" not in str(failed.value)


def test_files_that_no_entry_names_do_not_count(dataset, tmp_path) -> None:
    add_here(make(tmp_path / "drive.pcapng"), to=tmp_path / "set")
    (drives,) = (tmp_path / "set").glob("drives/*/*/*.parquet")
    drives.with_name("0123-0123.parquet").write_bytes(drives.read_bytes())
    assert ask(tmp_path / "set", "SELECT count(*) FROM drives") == [(1,)]


def test_a_folder_that_is_no_dataset_is_refused(tmp_path) -> None:
    with pytest.raises(FleetError, match="no dataset"), opened(str(tmp_path)):
        pass


def test_ctrl_c_ends_a_long_question(dataset, monkeypatch) -> None:
    import _thread
    import threading

    forever = (
        "SELECT count(*) FROM range(100000000) a, range(100000000) b WHERE a.range = b.range + 1"
    )
    with opened(dataset) as database:
        asked = threading.Event()
        original = database._connection.execute  # noqa: SLF001

        class Connection:
            def __getattr__(self, name):
                return getattr(inner, name)

            def execute(self, *given):
                asked.set()
                return original(*given)

        inner, database._connection = database._connection, Connection()  # noqa: SLF001
        threading.Thread(target=lambda: (asked.wait(), _thread.interrupt_main())).start()
        with pytest.raises(KeyboardInterrupt):
            database.ask(forever)
