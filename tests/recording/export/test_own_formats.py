"""Formats that other distributions bring, with real metadata."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from export_tables import CHANNELS, EVENTS, FIXED

import mikas
from link_rig import brought
from mikas.errors import ExportError, UsageError
from mikas.framing import encode
from mikas.link.base import Direction
from mikas.recording import CaptureWriter
from mikas.recording.export import SUFFIXES, TRACKS, export, formats

HERE = __name__
EXAMPLE = Path(__file__).parents[3] / "examples/own_export"
NOON = 1_700_000_000.0


def count(path, sheet):
    """A format that a test brings: the numbers of channels and rows."""
    rows = sum(len(times) for times, _ in sheet.batches())
    path.write_text(f"{len(sheet.channels)} {rows}")


def needs_more(path, sheet, colour):
    """No writer."""


def fails(path, sheet):
    """A writer with a bug."""
    path.write_text("half of it")
    raise KeyError("TWAT")


def full(path, sheet):
    """A writer on a full disk."""
    raise OSError(28, "No space left on device")


NOTHING = 3


def with_format(folder, name="count", place=None):
    return brought(folder, "own-format", "mikas.exports", {name: place or f"{HERE}:count"})


def test_a_format_of_another_distribution_is_that_of_its_suffix(tmp_path):
    with with_format(tmp_path / "site"):
        result = export(tmp_path / "a.Count", CHANNELS, FIXED, events=EVENTS)
        assert formats() == ("csv", "mf4", "parquet", "msl", "mlg", "gpx", "geojson", "count")
    assert (tmp_path / "a.Count").read_text() == f"{len(CHANNELS)} {result.rows}"
    assert formats() == tuple(suffix[1:] for suffix in (*SUFFIXES, *TRACKS))
    with pytest.raises(ExportError, match="the suffix must be one of"):
        export(tmp_path / "b.count", CHANNELS, FIXED)


def test_a_format_by_name_is_written_whatever_the_suffix(tmp_path):
    with with_format(tmp_path / "site"):
        export(tmp_path / "a.txt", CHANNELS, FIXED, format_name="count")
        assert (tmp_path / "a.txt").read_text()[0] == str(len(CHANNELS))
    export(tmp_path / "b.txt", CHANNELS, FIXED, format_name="csv")
    assert (tmp_path / "b.txt").read_text("utf-8").startswith("Time (msec),TWAT")
    with pytest.raises(ExportError, match=r"“parket”.*Did you mean parquet") as caught:
        export(tmp_path / "c.txt", CHANNELS, FIXED, format_name="parket")
    assert "Может быть, parquet" in caught.value.text.ru


def test_a_name_of_two_distributions_names_both(tmp_path):
    with (
        with_format(tmp_path / "a"),
        brought(tmp_path / "b", "other", "mikas.exports", {"count": f"{HERE}:count"}),
    ):
        with pytest.raises(UsageError, match=r"brings count: other 1\.0, own-format 1\.0"):
            export(tmp_path / "a.count", CHANNELS, FIXED)
        export(tmp_path / "a.csv", CHANNELS, FIXED)  # others are not concerned


def test_a_name_that_mikas_has_itself_names_the_distribution(tmp_path):
    with with_format(tmp_path / "site", "csv"):
        with pytest.raises(UsageError, match=r"csv: of the distribution own-format 1\.0 has the"):
            export(tmp_path / "a.csv", CHANNELS, FIXED)
        assert formats().count("csv") == 1


@pytest.mark.parametrize(
    ("place", "why"),
    [
        ("no_such_module:write", "can't be loaded (ModuleNotFoundError"),
        (f"{HERE}:absent", "can't be loaded (AttributeError"),
        (f"{HERE}:NOTHING", "is not a function of a path and a sheet (3 is not a callable"),
        (f"{HERE}:needs_more", "(missing a required argument: 'colour')"),
        (f"{HERE}:fails", "could not write the file (KeyError: 'TWAT')"),
    ],
)
def test_a_format_that_does_not_work_names_its_distribution(tmp_path, place, why):
    named = pytest.raises(UsageError, match=r"odd: of the distribution own-format 1\.0")
    with with_format(tmp_path / "site", "odd", place), named as caught:
        export(tmp_path / "a.odd", CHANNELS, FIXED)
    assert why in str(caught.value)
    assert "из пакета own-format 1.0" in caught.value.text.ru
    assert list(tmp_path.glob("a.odd*")) == []


def test_a_full_disk_is_an_error_of_the_file(tmp_path):
    refused = pytest.raises(ExportError, match=r"a\.odd: can't be written")
    with with_format(tmp_path / "site", "odd", f"{HERE}:full"), refused:
        export(tmp_path / "a.odd", CHANNELS, FIXED)


@pytest.fixture
def drive(tmp_path):
    path = tmp_path / "drive.pcapng"
    with CaptureWriter(path, url="/dev/ttyUSB0") as sink:
        for number in range(4):
            begin = NOON + number / 4
            sink.record(Direction.SENT, encode(bytes((0x61, 0x29))), begin)
            sink.record(Direction.RECEIVED, encode(bytes((21,))), begin + 0.01)
    return path


def test_a_recording_exports_itself(drive, tmp_path):
    recording = mikas.open(drive, language="ru")
    result = recording.export(tmp_path / "a.csv", dialect="excel")
    assert (result.rows, result.channels) == (4, ("FREQ",))
    assert "об/мин" in (tmp_path / "a.csv").read_text("utf-8")
    with pytest.raises(ExportError, match="there already"):
        recording.export(str(tmp_path / "a.csv"))
    assert recording.export(tmp_path / "a.csv", format="msl", overwrite=True).rows == 4
    with pytest.raises(UsageError, match="plain, excel"):
        recording.export(tmp_path / "b.csv", dialect="german")


def entries_of_the_example():
    project = tomllib.loads((EXAMPLE / "pyproject.toml").read_text("utf-8"))["project"]
    return project["entry-points"]["mikas.exports"]


def test_the_shipped_example_writes_json_lines(drive, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLE)
    with brought(tmp_path / "site", "jsonlines", "mikas.exports", entries_of_the_example()):
        mikas.open(drive).export(tmp_path / "a.jsonl")
    head, *rows = map(json.loads, (tmp_path / "a.jsonl").read_text("utf-8").splitlines())
    assert head["units"] == {"FREQ": "rpm"}
    assert head["started"].startswith("2023-11-14T22:13:20")
    assert rows[1] == {"time": 0.25, "FREQ": 840.0}


@pytest.mark.realtime
def test_the_command_has_the_format_and_its_help_names_it(drive, tmp_path):
    def run(*arguments):
        return subprocess.run(
            [sys.executable, "-m", "mikas", *arguments],
            capture_output=True, text=True, encoding="utf-8", timeout=60, check=False, cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": path, "MIKAS_LANG": "en", "COLUMNS": "200"},
        )  # fmt: skip

    with brought(tmp_path / "site", "jsonlines", "mikas.exports", entries_of_the_example()):
        path = os.pathsep.join([str(tmp_path / "site"), str(EXAMPLE), *sys.path])
        shown = " ".join(run("export", "--help").stdout.split())
        assert "csv, mf4, parquet, msl, mlg, gpx, geojson, jsonl" in shown
        done = run("export", str(drive), "-o", "a.jsonl", "--json")
        assert json.loads(done.stdout)["rows"] == 4
        assert run("export", str(drive), "-o", "b", "--format", "jsonl").returncode == 0
        refused = run("export", str(drive), "-o", "c", "--format", "jsonl", "--dialect", "excel")
        assert (refused.returncode, "for .csv files only" in refused.stderr) == (2, True)
        unknown = run("export", str(drive), "-o", "d", "--format", "jsnl")
        assert (unknown.returncode, "Did you mean jsonl?" in unknown.stderr) == (2, True)
    assert (tmp_path / "a.jsonl").read_bytes() == (tmp_path / "b").read_bytes()


def test_a_command_beside_the_export_does_not_look_for_them():
    """The metadata of all distributions are read for a help, a completion or an export only."""
    code = (
        "import sys; from mikas.cli.main import run; status = run(['decode', '--help']); "
        "sys.stderr.write(f\"{status} {'importlib.metadata' in sys.modules}\")"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr == "0 False"
