"""Datasets that a stranger made: what is wrong in them is named and left out, the rest is used.

No place that a dataset names is opened, and nothing outside of it is read, written or removed.
"""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Iterator
from pathlib import Path

import duckdb
import pytest

from fleet_rig import BEGAN, DAY, add_here, ask, counts, make, make_dataset
from mikas.cleaning import terminal_text
from mikas.cli.main import run
from mikas.errors import FleetError
from mikas.fleet import entries
from mikas.fleet.ledger import FOLDER, MARKER
from mikas.fleet.query.database import opened

ROWS = "SELECT count(*), count(DISTINCT drive) FROM samples"


@pytest.fixture
def home(tmp_path) -> Path:
    """A dataset of two recordings of two cars, and a file outside of it."""
    (tmp_path / "outside").mkdir()
    (tmp_path / "outside" / "keep.parquet").write_bytes(b"keep")
    bad = {"began": BEGAN + DAY, "plate": "Е777КХ99"}
    return make_dataset(tmp_path, {"good.pcapng": {}, "bad.pcapng": bad})


@pytest.fixture(autouse=True)
def no_network(monkeypatch) -> None:
    def refuse(*_: object) -> None:
        raise AssertionError("a place in the network was asked")

    monkeypatch.setattr(socket.socket, "connect", refuse)
    monkeypatch.setattr(socket, "getaddrinfo", refuse)


def entry_of(home: Path, name: str = "bad.pcapng") -> Path:
    for path in (home / FOLDER).iterdir():
        if any(source.endswith(name) for source in json.loads(path.read_bytes())["sources"]):
            return path
    raise KeyError(name)


def tables_of(home: Path) -> list[Path]:
    return [home / name for name in json.loads(entry_of(home).read_bytes())["files"]]


def left_out(home: Path, table: str = "drives") -> str:
    """The reason that the bad one is left out, alone; the good one is read."""
    key = entry_of_key(home)
    with opened(str(home)) as database:
        assert list(database.ask(f"FROM {table}").rows)
        assert list(database.ask(ROWS).rows) == [(239, 1)]
        ((name, reason),) = database.ledger.refused.items()
    assert name == key
    assert reason.ru
    return reason.en


def entry_of_key(home: Path) -> str:
    """The entry that is not that of the good recording."""
    (bad,) = {it.name for it in (home / FOLDER).iterdir()} - {entry_of_good(home)}
    return f"{FOLDER}/{bad}"


def entry_of_good(home: Path) -> str:
    (table,) = home.glob("drives/car=A101MP52/*/*.parquet")
    return f"{table.name.partition('-')[0]}.json"


def test_an_address_in_the_ledger_is_not_asked(home, tmp_path) -> None:
    """The user's keys went with the request; 3 GB came into the temporary folder."""
    whole = make(tmp_path / "drive.pcapng").read_bytes()
    entry = entry_of(home, "good.pcapng")
    value = json.loads(entry.read_bytes())
    for place in (
        "http://169.254.169.254/latest",
        "s3://elsewhere/x.pcapng",
        "/etc/passwd",
        "../x",
    ):
        entry.write_text(json.dumps(value | {"sources": {place: "1-1"}}))
        beginning = tmp_path / "new" / "beginning.pcapng"
        beginning.parent.mkdir(exist_ok=True)
        beginning.write_bytes(whole[: len(whole) // 2])
        add_here(tmp_path / "new", to=home)


@pytest.mark.posix
@pytest.mark.parametrize("kind", ["device", "pipe", "link", "folder", "huge"])
def test_an_entry_that_is_no_file_is_left_out(home, tmp_path, kind) -> None:
    """A link to /dev/zero took 5.8 GB of memory, a pipe waited for ever."""
    entry = entry_of(home)
    sound = entry.read_bytes()
    entry.unlink()
    match kind:
        case "device":
            entry.symlink_to("/dev/zero")
        case "pipe":
            os.mkfifo(entry)
        case "link":
            (tmp_path / "outside" / "entry.json").write_bytes(sound)
            entry.symlink_to(tmp_path / "outside" / "entry.json")
        case "folder":
            entry.mkdir()
        case "huge":
            with entry.open("wb") as file:
                file.truncate(5 << 30)
    assert left_out(home)
    result = add_here(tmp_path / "in", to=home)
    assert result.added == (kind != "folder")
    assert len(result.bad) == (2 if kind == "folder" else 0)
    assert (tmp_path / "outside" / "keep.parquet").read_bytes() == b"keep"
    if kind == "link":
        assert (tmp_path / "outside" / "entry.json").read_bytes() == sound
    if kind != "folder":
        assert ask(home, ROWS) == [(2 * 239, 2)]


@pytest.mark.posix
@pytest.mark.parametrize("kind", ["device", "pipe", "link", "folder", "huge", "gone"])
def test_a_table_that_is_no_file_costs_its_own_recording_only(home, tmp_path, kind) -> None:
    table = tables_of(home)[0]
    sound = table.read_bytes()
    table.unlink()
    match kind:
        case "device":
            table.symlink_to("/dev/zero")
        case "pipe":
            os.mkfifo(table)
        case "link":
            (tmp_path / "outside" / "t.parquet").write_bytes(sound)
            table.symlink_to(tmp_path / "outside" / "t.parquet")
        case "folder":
            table.mkdir()
        case "huge":
            with table.open("wb") as file:
                file.truncate(5 << 30)
    assert table.name in left_out(home)
    result = add_here(tmp_path / "in", to=home)
    assert (result.added, len(result.bad)) == ((0, 2) if kind == "folder" else (1, 0))
    if kind == "link":
        assert (tmp_path / "outside" / "t.parquet").read_bytes() == sound


@pytest.mark.posix
@pytest.mark.parametrize("folder", [FOLDER, ".parts", "samples", "car", "day"])
def test_nothing_is_written_or_removed_through_a_link_to_a_folder(home, tmp_path, folder) -> None:
    table = next(it for it in tables_of(home) if "samples" in it.parts)
    path = {"car": table.parent.parent, "day": table.parent}.get(folder, home / folder)
    (home / ".parts").mkdir(exist_ok=True)
    moved = tmp_path / "outside" / path.name
    path.rename(moved)
    path.symlink_to(moved)
    old = moved / "old"
    old.write_bytes(b"of a day ago")
    os.utime(old, (1, 1))
    before = {it: it.stat().st_mtime_ns for it in (tmp_path / "outside").rglob("*")}
    file = tmp_path / "in" / "bad.pcapng"
    make(file, began=BEGAN + DAY, plate="Е777КХ99", faults=(13,))
    make(tmp_path / "in" / "third.pcapng", began=BEGAN + 2 * DAY)
    try:
        result = add_here(tmp_path / "in", to=home)
    except FleetError as error:
        assert folder in (FOLDER, ".parts")
        assert "link" in str(error)
    else:
        assert any("link" in bad.reason.en for bad in result.bad) or folder == ".parts"
        assert result.added >= (folder in ("car", "day"))
    assert before == {it: it.stat().st_mtime_ns for it in (tmp_path / "outside").rglob("*")}


@pytest.mark.posix
def test_the_folder_that_the_user_names_may_be_a_link(home, tmp_path) -> None:
    (tmp_path / "alias").symlink_to(home)
    make(tmp_path / "in" / "third.pcapng", began=BEGAN + 2 * DAY)
    assert counts(add_here(tmp_path / "in", to=tmp_path / "alias")) == (1, 0, 2, 0)
    assert ask(tmp_path / "alias", ROWS) == [(3 * 239, 3)]


def changes() -> Iterator[tuple[str, object]]:
    yield "files", ["samples/car=x/day=../../../../outside/keep.parquet"]
    yield "files", ["../outside/keep.parquet"]
    yield "files", ["samples/car=%2e%2e/day=2026-03-02/" + "0" * 32 + "-00000000.parquet"]
    yield "files", ["samples/car=A101MP52/day=2026-99-99/{key}-00000000.parquet"]
    yield "files", ["samples/car=OTHER/day=2026-03-02/{key}-00000000.parquet"]
    yield "files", ["samples/car=A101MP52/day=2026-03-02/" + "0" * 32 + "-00000000.parquet"]
    yield "files", 7
    yield "obsolete", ["../outside/keep.parquet"]
    yield "obsolete", [f"{FOLDER}/{{key}}.json"]
    yield "replaces", ["{key}"]
    yield "sha256", "0" * 64
    yield "key", "../x"
    yield "car", "OTHER"
    yield "car", {"a": []}
    yield "bytes", 10**30
    yield "bytes", -1
    yield "bytes", True
    yield "rows", "many"
    yield "seconds", "1"
    yield "heads", ["x"]
    yield "heads", []
    yield "sources", {"/a": []}
    yield "version", None


@pytest.mark.parametrize(("name", "value"), list(changes()))
def test_an_entry_that_contradicts_itself_is_left_out(home, name, value) -> None:
    entry = entry_of(home)
    text = json.dumps(value).replace("{key}", entry.stem)
    entry.write_text(json.dumps(json.loads(entry.read_bytes()) | {name: json.loads(text)}))
    assert "is damaged" in left_out(home)


@pytest.mark.parametrize(
    "text",
    [
        "", "{", "[]", "7", "null", "[" * 100_000, '{"a":' * 50_000, "\xff\xfe", "NaN",
        '{"seconds": 1e999}', '{"bytes": NaN}', '{"bytes": ' + "9" * 5000 + "}",
        '{"key": "a", "key": "b"}', "\\ud800",
    ],
)  # fmt: skip
def test_hostile_json_is_left_out(home, text) -> None:
    entry_of(home).write_text(text, "utf-8")
    assert "(JSON)" in left_out(home) or "(key)" in left_out(home)


@pytest.mark.parametrize(
    "text", ["", "[" * 100_000, "[]", '{"form": 1, "form": 2}', '{"form": NaN}']
)
def test_a_hostile_marker_is_said_in_words(home, text, tmp_path) -> None:
    (home / MARKER).write_text(text)
    for use in (lambda: ask(home, ROWS), lambda: add_here(tmp_path / "in", to=home)):
        with pytest.raises(FleetError, match="no dataset"):
            use()


@pytest.mark.posix
def test_a_marker_that_is_no_file_is_said_in_words(home) -> None:
    (home / MARKER).unlink()
    os.mkfifo(home / MARKER)
    with pytest.raises(FleetError, match="a pipe or a device"):
        ask(home, ROWS)


def crafted(path: Path, select: str, options: str = "") -> None:
    duckdb.sql(f"COPY ({select}) TO '{path}' (FORMAT parquet, COMPRESSION zstd{options})")


def same_with(path: Path, change: str) -> None:
    """Write a table again, with another column."""
    other = path.with_suffix(".new")
    crafted(other, f"SELECT * REPLACE ({change}) FROM read_parquet('{path}', hive_partitioning=0)")
    other.replace(path)


@pytest.mark.parametrize(
    ("table", "change"),
    [
        ("drives", "'x' AS began"), ("drives", "[1, 2] AS seconds"), ("drives", "{'a': 1} AS rows"),
        ("samples", "'x' AS TWAT"), ("samples", "'x' AS time"), ("statistics", "'x' AS median"),
        ("faults", "'x' AS code"), ("faults", "1 AS utc"),
    ],
)  # fmt: skip
def test_a_table_with_a_column_of_another_type_costs_its_own_recording_only(
    home, table, change
) -> None:
    (path,) = (it for it in tables_of(home) if table in it.parts)
    same_with(path, change)
    assert path.name in left_out(home, table)


def test_a_table_of_far_more_rows_than_bytes_is_left_out(home) -> None:
    rows = 1_000_000
    (path,) = (it for it in tables_of(home) if "gaps" in it.parts or "alarms" in it.parts)
    columns = ", ".join(
        f"'{'x'}' AS {name}" if kind == "VARCHAR" else f"NULL::{kind} AS {name}"
        for name, kind in columns_of(path).items()
    )
    crafted(path, f"SELECT {columns} FROM range({rows})")
    for entry in (home / FOLDER).iterdir():  # a stranger may have written a fitting one too
        entry.write_text(json.dumps({**json.loads(entry.read_text()), "tables": {}}))
    assert path.stat().st_size < rows / 20
    with opened(str(home)) as database:
        assert len(database.rows("FROM alarms")) < 10
        ((_, reason),) = database.ledger.refused.items()
    assert f"{rows} rows" in reason.en


def columns_of(path: Path) -> dict[str, str]:
    rows = duckdb.sql(f"DESCRIBE FROM read_parquet('{path}', hive_partitioning=0)").fetchall()
    return {row[0]: row[1] for row in rows}


@pytest.mark.parametrize("data", [b"", b"PAR1", b"PAR1" + b"\xff" * 64 + b"\xff\xff\xff\x7fPAR1"])
def test_a_damaged_table_costs_its_own_recording_only(home, data) -> None:
    path = tables_of(home)[-1]
    path.write_bytes(data)
    assert path.name in left_out(home)


def test_hostile_values_are_none_in_the_report(home, tmp_path, capsys) -> None:
    """Times out of the calendar, endless lengths, NaN, names with controls and HTML."""
    hostile = "chr(27) || '[31m<script>alert(1)</script>' || repeat('x', 100000)"
    for path in tables_of(home):
        if "drives" in path.parts:
            same_with(
                path,
                f"""
                'infinity'::TIMESTAMP AS began, 'inf'::DOUBLE AS seconds, {hostile} AS name,
                {hostile} AS plate, 'nan'::DOUBLE AS warm_idle_seconds
            """,
            )
        elif "statistics" in path.parts:
            same_with(path, "'nan'::DOUBLE AS median, 'inf'::DOUBLE AS mean, 1000::BIGINT AS count")
        elif "faults" in path.parts:
            same_with(path, "-5::INTEGER AS code, TIMESTAMP '290000-01-01' AS utc")
    page = tmp_path / "page.html"
    assert run(["fleet", "report", str(home), "-o", str(page)]) == 0
    assert run(["fleet", "report", str(home), "--json"]) == 0
    out = capsys.readouterr()
    for line in (out.out + out.err).splitlines():
        assert line == terminal_text(line)
    text = page.read_text("utf-8")
    assert "<script" not in text
    assert "\x1b" not in text
    assert len(text) < 200_000


def test_what_is_left_out_is_said_by_sql_and_by_the_report(home, tmp_path, capsys) -> None:
    entry = entry_of(home)
    entry.write_text("{")
    assert run(["fleet", "sql", str(home), "SELECT count(*) FROM drives"]) == 0
    out = capsys.readouterr()
    assert out.out.split() == ["count_star()", "1"]
    assert entry.name in out.err
    assert "Left out of the dataset: 1 recording" in out.err
    assert run(["fleet", "report", str(home), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert [it["file"] for it in said["refused"]] == [f"{FOLDER}/{entry.name}"]
    assert any("Left out: 1 recording" in text["en"] for text in said["unknown"])
    assert run(["fleet", "add", str(tmp_path / "in"), "--to", str(home), "--workers", "1"]) == 0


def test_a_report_on_a_car_of_many_years_is_linear() -> None:
    from mikas.fleet.report.comparing import trend

    assert trend([float(number % 7) for number in range(20_000)], 0.5) is None


def test_an_entry_that_is_too_long_is_cut_however_its_length_is_spread() -> None:
    long = "x" * (entries.LONGEST + 1)
    for fields in (
        {"sources": {"one": long}},
        {"replaces": (long,)},
        {"obsolete": (long, "b"), "replaces": ("c",)},
        {"files": (long,)},  # nothing of which may go
    ):
        written = entries.LedgerEntry("key", "sha", 0, (), "1", **fields).as_json()
        assert (len(written) > entries.LONGEST) == ("files" in fields)
