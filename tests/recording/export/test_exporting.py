"""What holds for every format: OUT is whole or not there, and what is refused says why."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from export_tables import CHANNELS, FIXED, NAN, START, TWAT, UACC, rows

from mikas.errors import CaptureError, ExportError, MissingExtra, UsageError
from mikas.i18n import Text
from mikas.recording.export import SUFFIXES, Result, export
from mikas.recording.export import sheet as sheets
from mikas.recording.table.channels import Channel, Rows

every_format = pytest.mark.parametrize("suffix", SUFFIXES)


def left_in(folder):
    return sorted(path.name for path in folder.iterdir())


@every_format
def test_the_result_says_what_was_written(tmp_path, suffix):
    out = tmp_path / f"поездка{suffix.upper()}"
    assert export(out, CHANNELS, FIXED) == Result(3, ("TWAT", "UACC", "IDLE"), out)
    assert left_in(tmp_path) == [out.name]
    assert out.stat().st_size > 0


def test_the_suffixes_are_those_of_the_contract():
    assert SUFFIXES == (".csv", ".mf4", ".parquet", ".msl", ".mlg")


@pytest.mark.parametrize("name", ["log.xlsx", "log", ".csv"])
def test_an_unknown_suffix_is_answered_with_the_known_ones(tmp_path, name):
    with pytest.raises(UsageError, match=r"\.csv \.mf4 \.parquet \.msl \.mlg") as caught:
        export(tmp_path / name, CHANNELS, FIXED)
    assert ".parquet" in caught.value.text.ru
    assert left_in(tmp_path) == []


@every_format
def test_a_file_that_is_there_stays(tmp_path, suffix):
    out = tmp_path / f"log{suffix}"
    out.write_text("precious")
    with pytest.raises(ExportError, match="is there already"):
        export(out, CHANNELS, FIXED)
    assert out.read_text() == "precious"
    assert left_in(tmp_path) == [out.name]


@every_format
def test_a_file_that_may_be_overwritten_is_replaced(tmp_path, suffix):
    out = tmp_path / f"log{suffix}"
    out.write_text("old")
    export(out, CHANNELS, FIXED, overwrite=True)
    assert out.read_bytes() != b"old"
    assert left_in(tmp_path) == [out.name]


@every_format
def test_a_file_created_during_the_export_stays(tmp_path, suffix):
    out = tmp_path / f"log{suffix}"

    def source():
        yield FIXED[0]
        out.write_text("precious")

    with pytest.raises(ExportError, match="is there already"):
        export(out, CHANNELS, source())
    assert out.read_text() == "precious"
    assert left_in(tmp_path) == [out.name]


@every_format
@pytest.mark.parametrize("interruption", [KeyboardInterrupt, CaptureError])
def test_an_interrupted_export_leaves_nothing(tmp_path, suffix, monkeypatch, interruption):
    monkeypatch.setattr(sheets, "BATCH", 2)

    def source():
        yield from FIXED
        yield from FIXED
        assert all(name.startswith(f"log{suffix}.part") for name in left_in(tmp_path))
        raise interruption("a.pcapng", Text("cut", "обрыв"))

    with pytest.raises(interruption):
        export(tmp_path / f"log{suffix}", CHANNELS, source())
    assert left_in(tmp_path) == []


@every_format
def test_an_interrupted_export_leaves_what_was_there(tmp_path, suffix):
    out = tmp_path / f"log{suffix}"
    out.write_text("precious")

    def source():
        yield FIXED[0]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        export(out, CHANNELS, source(), overwrite=True)
    assert out.read_text() == "precious"
    assert left_in(tmp_path) == [out.name]


@every_format
def test_a_folder_that_is_not_there_is_an_error_and_leaves_nothing(tmp_path, suffix):
    with pytest.raises(ExportError, match="can't be written: No such file") as caught:
        export(tmp_path / "nowhere" / f"log{suffix}", CHANNELS, FIXED)
    assert "нет такого файла" in caught.value.text.ru
    assert left_in(tmp_path) == []


@every_format
def test_a_folder_that_is_a_file_is_an_error(tmp_path, suffix):
    (tmp_path / "file").write_text("")
    with pytest.raises(ExportError, match="can't be written"):
        export(tmp_path / "file" / f"log{suffix}", CHANNELS, FIXED)


@pytest.mark.parametrize(
    ("suffix", "library", "extra"),
    [
        (".mf4", "asammdf", "mdf"),
        (".parquet", "duckdb", "parquet"),
    ],
)
def test_a_missing_library_is_named_by_its_extra(tmp_path, monkeypatch, suffix, library, extra):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(MissingExtra, match=rf"mikas\[{extra}\]"):
        export(tmp_path / f"log{suffix}", CHANNELS, FIXED)
    assert left_in(tmp_path) == []


@pytest.mark.parametrize("name", ["twat", "TIME", "Time"])
def test_two_columns_of_one_name_are_refused(tmp_path, name):
    channels = [TWAT, Channel(name, "", Text("", ""))]
    with pytest.raises(ExportError, match=f"two columns would be called {name}"):
        export(tmp_path / "log.csv", channels, [])


def test_no_channels_are_refused(tmp_path):
    with pytest.raises(ExportError, match="no channels"):
        export(tmp_path / "log.csv", [], [])


@every_format
def test_a_channel_that_a_stretch_lacks_is_missing_there(tmp_path, suffix):
    whole, lacking = tmp_path / f"whole{suffix}", tmp_path / f"lacking{suffix}"
    export(whole, [TWAT, UACC], [rows([START], TWAT=[85], UACC=[NAN])])
    export(lacking, [TWAT, UACC], [rows([START], TWAT=[85])])
    if suffix != ".mf4":  # asammdf notes in the file when it was made
        assert whole.read_bytes() == lacking.read_bytes()


def test_values_that_do_not_match_their_times_are_a_mistake(tmp_path):
    with pytest.raises(ValueError, match="UACC: values: 2, times: 1"):
        export(tmp_path / "log.csv", [UACC], [rows([1.0], UACC=[1, 2])])


@every_format
@pytest.mark.parametrize("length", [1, 7, 64, 1000])
def test_a_file_does_not_depend_on_how_its_rows_arrived(tmp_path, monkeypatch, suffix, length):
    monkeypatch.setattr(sheets, "BATCH", 64)
    times = START + np.arange(300) / 35
    values = {"TWAT": np.arange(300.0) % 256 - 40, "UACC": np.where(times % 2 < 1, NAN, times % 20)}
    whole = tmp_path / f"whole{suffix}"
    pieces = tmp_path / f"pieces{suffix}"
    export(whole, [TWAT, UACC], [Rows(times, values)])
    parts = (
        Rows(times[a : a + length], {name: v[a : a + length] for name, v in values.items()})
        for a in range(0, 300, length)
    )
    assert export(pieces, [TWAT, UACC], parts).rows == 300
    if suffix != ".mf4":
        assert pieces.read_bytes() == whole.read_bytes()
    else:
        assert _mdf(pieces) == _mdf(whole)


def _mdf(path: Path):
    from asammdf import MDF

    with MDF(path) as mdf:
        return [
            (mdf.get(name).timestamps.tobytes(), mdf.get(name).samples.tobytes())
            for name in ("TWAT", "UACC")
        ]
