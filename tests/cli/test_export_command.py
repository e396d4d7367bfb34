"""`mikas export`: a recording made by `log`, in each format, read back by the format's library."""

from __future__ import annotations

import json
import re
import sys

import numpy as np
import pytest
from cli_harness import is_one_short_paragraph, is_russian
from pyarrow import parquet

from csv_columns import columns_of
from mikas.catalog import shipped
from mikas.cli.commands.recordings.export import MOST_PROBLEMS
from mikas.recording.annotations.events import note_of
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.notes import block_of
from mikas.recording.recording import Recording
from mikas.sampling.events import Marker

SUFFIXES = ("csv", "mf4", "parquet", "msl", "mlg")
NAMES = ("TWAT", "FREQ", "INJ", "RXX")
SAME_BYTE = ("BITPOW", "RDET")  # they come with RXX
DERIVED = ("FUEL_STROKE", "FUEL_FLOW", "FUEL_USED", "DUTY")


@pytest.fixture
def drive(mikas, tmp_path):
    assert mikas("log", "-o", "drive.pcapng", *NAMES, "--count", "40").status == 0
    return tmp_path / "drive.pcapng"


def cells(path, separator=","):
    return [line.split(separator) for line in path.read_text("utf-8-sig").splitlines()]


def column(path, name):
    """The texts of one column of a CSV."""
    return columns_of(path.read_text("utf-8-sig"))[name]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_every_format_is_written_and_the_recording_left_alone(mikas, tmp_path, drive, suffix):
    before = drive.read_bytes()
    ran = mikas("export", "drive.pcapng", "-o", f"drive.{suffix}", "--json")
    assert (ran.status, ran.err) == (0, "")
    rows = ran.object["rows"]
    assert rows >= 40  # what was asked before the first sample is there as well
    assert ran.object == {"schema": 1, "rows": rows, "channels": 10, "out": f"drive.{suffix}"}
    assert drive.read_bytes() == before
    assert (tmp_path / f"drive.{suffix}").stat().st_size
    ran = mikas("export", "drive.pcapng", "-o", f"again.{suffix}")
    assert (ran.status, ran.out, ran.err) == (0, "", f"again.{suffix}: {rows} rows, 10 channels\n")


def test_a_marker_is_in_the_table(mikas, tmp_path, drive):
    times = np.concatenate([rows.times for rows in Recording(drive, shipped()).rows()])
    with drive.open("ab") as file:
        file.write(pcapng.encode(block_of(note_of(Marker(float(times[20]), "knock"))), "<"))
    assert mikas("export", "drive.pcapng", "-o", "drive.msl").status == 0
    lines = (tmp_path / "drive.msl").read_text("utf-8").splitlines()
    assert lines.index("MARK 000 - knock") == 4 + 20  # behind the heading and twenty rows


def test_all_formats_have_the_same_values(mikas, tmp_path, drive):
    for suffix in SUFFIXES:
        assert mikas("export", "drive.pcapng", "-o", f"drive.{suffix}").status == 0
    table = parquet.read_table(tmp_path / "drive.parquet")
    assert set(table.column_names) == {"time", *NAMES, *SAME_BYTE, *DERIVED}
    from asammdf import MDF  # here: its import takes 2 s

    with MDF(tmp_path / "drive.mf4") as mdf:
        for name in ("TWAT", "INJ", "FUEL_FLOW"):
            signal = mdf.get(name)
            np.testing.assert_array_equal(signal.samples, table[name].to_numpy())
            np.testing.assert_array_equal(signal.timestamps, table["time"].to_numpy())
        assert mdf.get("TWAT").unit == "°C"
    expected = [f"{value:.0f}" for value in table["TWAT"].to_pylist()]
    assert column(tmp_path / "drive.csv", "TWAT") == expected
    _, _, names, _, *rows = cells(tmp_path / "drive.msl", "\t")
    assert [row[names.index("CLT")] for row in rows] == expected
    about = json.loads(parquet.read_metadata(tmp_path / "drive.parquet").metadata[b"mikas"])[
        "about"
    ]
    assert about["recording"] == "drive.pcapng"
    assert about["port"].startswith("sim:")
    assert about["reading"] == "corrected"
    assert about["catalog"]
    assert about["recorded by"].startswith("mikas ")


def test_chosen_channels_stand_in_the_order_of_the_command_line(mikas, tmp_path, drive):
    ran = mikas("export", "drive.pcapng", "-o", "a.csv", "fuel_flow", "TWAT", "TWAT", "--json")
    assert ran.object["channels"] == 2
    titles = [title.split(" ")[0] for title in cells(tmp_path / "a.csv")[0]]
    assert titles.index("FUEL_FLOW") < titles.index("TWAT")
    assert titles.count("TWAT") == 1
    assert not {"INJ", "FREQ"} & set(titles)
    assert all(column(tmp_path / "a.csv", "FUEL_FLOW"))


def test_a_channel_that_was_not_recorded_is_an_empty_column_with_a_notice(mikas, tmp_path, drive):
    ran = mikas("export", "drive.pcapng", "-o", "a.csv", "TWAT", "UACC", "AIR_STROKE")
    assert ran.status == 0
    assert "Not in this recording: UACC, AIR_STROKE." in ran.err
    assert set(column(tmp_path / "a.csv", "UACC")) == {""}
    assert set(column(tmp_path / "a.csv", "AIR_STROKE")) == {""}
    mikas.speaks("ru")
    ran = mikas("export", "drive.pcapng", "-o", "b.csv", "UACC")
    assert "В этой записи нет: UACC." in ran.err


@pytest.mark.parametrize("language", ["en", "ru"])
@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["-o", "drive.xlsx"], ".parquet"),
        (["-o", "old.csv"], "old.csv"),
        (["-o", "nowhere/a.csv"], "a.csv"),
        (["-o", "a.csv", "TWATT"], "TWAT"),
        (["-o", "a.csv", "0x1A"], "0x1A"),
        (["-o", "a.msl", "--dialect", "excel"], "--dialect"),
        (["-o", "a.csv", "--dialect", "french"], "plain, excel"),
        (["-o", "./drive.pcapng", "--overwrite"], "drive.pcapng"),
        ([], "--out"),
    ],
    ids=" ".join,
)
def test_a_wrong_export_is_refused_and_no_file_is_touched(
    mikas, tmp_path, drive, argv, message, language
):
    (tmp_path / "old.csv").write_text("precious")
    before = drive.read_bytes()
    mikas.speaks(language)
    ran = mikas("export", "drive.pcapng", *argv)
    assert (ran.status, ran.out) == (2, "")
    assert message in ran.err
    is_one_short_paragraph(ran.err)
    if language == "ru":
        is_russian(ran.err, names=("plain", "excel", "french"))
    assert drive.read_bytes() == before
    assert (tmp_path / "old.csv").read_text() == "precious"
    assert not (tmp_path / "a.csv").exists()


def test_a_file_that_is_there_is_replaced_if_asked(mikas, tmp_path, drive):
    (tmp_path / "old.csv").write_text("old")
    assert mikas("export", "drive.pcapng", "-o", "old.csv", "--overwrite").status == 0
    assert len(cells(tmp_path / "old.csv")) > 40


@pytest.mark.parametrize("content", [b"", b"Time,TWAT\n0,85\n", bytes(100)])
def test_a_file_that_is_no_recording_is_refused_by_name(mikas, tmp_path, content):
    (tmp_path / "drive.pcapng").write_bytes(content)
    ran = mikas("export", "drive.pcapng", "-o", "drive.csv")
    assert (ran.status, ran.out) == (2, "")
    assert "drive.pcapng" in ran.err
    assert not (tmp_path / "drive.csv").exists()


def test_a_recording_without_readings_has_no_channels_to_export(mikas, tmp_path):
    mikas("faults", "--capture", "drive.pcapng")
    ran = mikas("export", "drive.pcapng", "-o", "drive.csv")
    assert ran.status == 2
    assert "no channels" in ran.err
    ran = mikas("export", "drive.pcapng", "-o", "drive.csv", "TWAT", "--json")
    assert ran.object["rows"] == 0


def test_a_cut_recording_is_exported_up_to_the_cut(mikas, tmp_path, drive):
    whole = drive.read_bytes()
    drive.write_bytes(whole[: len(whole) * 4 // 5])
    ran = mikas("export", "drive.pcapng", "-o", "drive.csv", "--json")
    assert ran.status == 0
    assert 0 < ran.object["rows"] < 40
    problem, count = ran.err.splitlines()
    assert problem.startswith("drive.pcapng, offset ")
    assert "interrupted here" in problem
    assert "1 damaged place" in count
    ran = mikas("export", "drive.pcapng", "-o", "drive.csv", "--overwrite", "--lang", "ru")
    assert "смещение" in ran.err
    is_russian(ran.err)


def test_many_problems_are_counted_and_not_all_printed(mikas, tmp_path):
    mikas("log", "-o", "drive.pcapng", "TWAT", "--count", "400")
    data = bytearray((tmp_path / "drive.pcapng").read_bytes())
    for at in range(2000, len(data) - 2000, len(data) // 40):
        data[at : at + 40] = b"\xa5" * 40
    (tmp_path / "drive.pcapng").write_bytes(data)
    ran = mikas("export", "drive.pcapng", "-o", "drive.csv")
    assert ran.status == 0
    reported = [line for line in ran.err.splitlines() if ", offset " in line]
    assert len(reported) == MOST_PROBLEMS
    count = int(ran.err.splitlines()[MOST_PROBLEMS].split(": ")[1].split()[0])
    assert count > MOST_PROBLEMS


def test_a_changed_formula_changes_an_old_recording(mikas, tmp_path, drive):
    before = drive.read_bytes()
    (tmp_path / "mine.toml").write_text(
        '[parameter.TWAT]\nscale = "9/5"\noffset = -40\nrange = [-40, 266]\n'
        "[derived.FUEL_STROKE.constants]\ninjector = 5\n"
    )
    mikas("export", "drive.pcapng", "-o", "ours.csv")
    ran = mikas("export", "drive.pcapng", "-o", "mine.csv", "--catalog", "mine.toml")
    assert ran.status == 0, ran.err
    for ours, mine in zip(
        column(tmp_path / "ours.csv", "TWAT"), column(tmp_path / "mine.csv", "TWAT"), strict=True
    ):
        assert float(mine) == (9 * (int(ours) + 40) - 200) / 5
    for ours, mine in zip(
        column(tmp_path / "ours.csv", "FUEL_STROKE"),
        column(tmp_path / "mine.csv", "FUEL_STROKE"),
        strict=True,
    ):
        assert float(mine) == pytest.approx(2 * float(ours), abs=0.2)
    assert drive.read_bytes() == before


def test_the_interpretation_changes_the_exported_values(mikas, tmp_path, drive):
    mikas("export", "drive.pcapng", "-o", "a.csv", "--interpretation", "literal")
    mikas("export", "drive.pcapng", "-o", "b.csv")
    literal, corrected = cells(tmp_path / "a.csv"), cells(tmp_path / "b.csv")
    assert any("(1/s)" in title for title in literal[0])  # E1
    assert any("(rpm)" in title for title in corrected[0])
    assert literal[1:] == corrected[1:]


def test_excel_with_a_decimal_comma_gets_its_own_dialect(mikas, tmp_path, drive):
    argv = ("export", "drive.pcapng", "-o", "a.csv", "--dialect", "EXCEL", "INJ", "--lang", "ru")
    ran = mikas(*argv)
    assert re.search(r"строк: 4\d, каналов: 1\n", ran.err)
    assert (tmp_path / "a.csv").read_bytes().startswith(b"\xef\xbb\xbf")
    assert "впрыск" in (tmp_path / "a.csv").read_text("utf-8-sig").splitlines()[0].lower()
    assert "," in columns_of((tmp_path / "a.csv").read_text("utf-8-sig"), ";")["INJ"][0]


def test_two_sessions_in_one_file_are_exported_one_behind_the_other(mikas, tmp_path, drive):
    once = mikas("export", "drive.pcapng", "-o", "once.csv", "--json").object["rows"]
    drive.write_bytes(drive.read_bytes() * 2)
    ran = mikas("export", "drive.pcapng", "-o", "a.csv", "--json")
    assert (ran.status, ran.object["rows"]) == (0, 2 * once)
    assert "Times run back in this table (times: 1)" in ran.err
    used = column(tmp_path / "a.csv", "FUEL_USED")
    assert used[:once] == used[once:]  # each session counts from zero


def test_times_that_run_back_are_reported_once(mikas, tmp_path, drive):
    drive.write_bytes(drive.read_bytes() * 6)
    message = mikas("export", "drive.pcapng", "-o", "a.csv", "TWAT").err
    assert message.count("run back") == message.count("run back in this table (times: 5)") == 1
    message = mikas("export", "drive.pcapng", "-o", "b.csv", "TWAT", "--lang", "ru").err
    assert message.count("идёт назад") == message.count("идёт назад (раз: 5)") == 1


def test_a_recording_without_values_is_refused_with_advice(mikas, tmp_path):
    mikas("raw", "01", "--port", "sim:?clock=simulated", "--capture", "raw.pcapng")
    ran = mikas("export", "raw.pcapng", "-o", "a.csv")
    assert ran.status == 2
    assert "no parameter was read in this recording" in ran.err
    assert "mikas log -o" in ran.err
    assert not (tmp_path / "a.csv").exists()


def test_a_recording_that_lost_its_beginning_is_exported_from_there(mikas, tmp_path):
    drive = tmp_path / "drive.pcapng"
    watched = ("watch", "INJ", "TWAT", "--method", "batch", "--count", "90")
    mikas(*watched, "--port", "sim:?clock=simulated", "--capture", "drive.pcapng")
    whole = mikas("export", "drive.pcapng", "-o", "a.csv", "--json").object["rows"]
    drive.write_bytes(bytes(5000) + drive.read_bytes()[5000:])
    ran = mikas("export", "drive.pcapng", "-o", "b.csv", "--json")
    assert (ran.status, 0 < ran.object["rows"] < whole) == (0, True)
    assert "drive.pcapng, offset 0: damaged bytes" in ran.err
    rows = column(tmp_path / "b.csv", "INJ")
    assert rows == column(tmp_path / "a.csv", "INJ")[-len(rows) :]
    assert mikas("decode", "drive.pcapng").status == 0
    assert mikas("read", "TWAT", "INJ", "--port", "replay:drive.pcapng").status == 0


@pytest.mark.parametrize(
    ("suffix", "library", "extra"), [("mf4", "asammdf", "mdf"), ("parquet", "duckdb", "parquet")]
)
def test_a_missing_library_is_an_error_with_its_command(
    mikas, tmp_path, monkeypatch, drive, suffix, library, extra
):
    for name in [n for n in sys.modules if n.startswith("duckdb.")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, library, None)
    ran = mikas("export", "drive.pcapng", "-o", f"drive.{suffix}")
    assert (ran.status, ran.out) == (2, "")
    assert f'pip install "mikas[{extra}]"' in ran.err
    is_one_short_paragraph(ran.err)
    assert (
        f'pip install "mikas[{extra}]"'
        in mikas("export", "drive.pcapng", "-o", f"drive.{suffix}", "--lang", "ru").err
    )
