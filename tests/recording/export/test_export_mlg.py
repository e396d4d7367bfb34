"""MegaLogViewer's binary log, read back."""

from __future__ import annotations

import numpy as np
import pytest
from export_tables import (
    ALL_FLOATS,
    CHANNELS,
    EVENTS,
    FIXED,
    NAN,
    START,
    TWAT,
    exported,
    from_start,
    rows,
    tables,
)
from hypothesis import given

from mikas.errors import ExportError
from mikas.i18n import Text
from mikas.recording.export import export
from mikas.recording.export import sheet as sheets
from mikas.recording.table.channels import Channel
from mikas.sampling.events import Marker
from viewer_logs import read_mlg


def test_an_mlg_file_has_these_bytes(tmp_path):
    out = tmp_path / "log.mlg"
    export(out, [TWAT], [rows([START, START + 0.25], TWAT=[85, NAN])])
    data = out.read_bytes()
    assert data[:22].hex(" ") == (
        "4d 4c 56 4c 47 00 00 01 65 53 f1 00 00 84 "  # 22 + 2 × 55 = 0x84
        f"{len(data) - 26:08x} 00 08 00 02"
    ).replace(f"{len(data) - 26:08x}", (len(data) - 26).to_bytes(4).hex(" "))
    assert data[22:77] == (
        b"\x05"
        + b"Time".ljust(34, b"\0")
        + b"s".ljust(10, b"\0")
        + b"\0"
        + bytes.fromhex("3a83126f 00000000 03")
    )
    assert data[77:132] == (
        b"\x07"
        + b"CLT".ljust(34, b"\0")
        + "°C".encode().ljust(10, b"\0")
        + b"\0"
        + bytes.fromhex("3f800000 00000000 00")
    )
    assert data[132:].startswith(b'"mikas ')
    assert data[-27:-26] == b"\0"
    assert data[-26:].hex(" ") == (
        "00 00 00 00 00 00 00 00 42 aa 00 00 ec "  # 0 s, 85
        "00 01 61 a8 00 00 00 fa 7f c0 00 00 39"  # 25,000 × 10 µs, 250 ms, NaN
    )


def test_the_fixed_table_is_read_back_from_mlg(tmp_path):
    out = tmp_path / "log.mlg"
    export(out, CHANNELS, FIXED, about={"unit": "Микас 7.1"})
    log = read_mlg(out.read_bytes())
    assert log.timestamp == START
    assert log.names == ["Time", "CLT", "Batt V", "IDLE"]
    assert log.units == ["s", "°C", "V", ""]
    assert log.digits == [3, 0, 1, 0]
    assert "unit: Микас 7.1; CLT = TWAT = Coolant temperature / Температура" in log.info
    assert log.info.endswith('"Capture Date: Tue Nov 14 22:13:20 UTC 2023"\n')


def test_no_rows_are_a_header(tmp_path):
    out = tmp_path / "log.mlg"
    export(out, [TWAT], [])
    log = read_mlg(out.read_bytes())
    assert (log.timestamp, log.names, log.values) == (0, ["Time", "CLT"], [])


@given(drawn=tables(ALL_FLOATS))
def test_what_was_exported_is_read_back(tmp_path_factory, drawn):
    log = read_mlg(exported(drawn, tmp_path_factory.getbasetemp() / "log.mlg").read_bytes())
    times = from_start(drawn)
    assert [row[0] for row in log.values] == pytest.approx(times, abs=0.0005, rel=1e-7)
    assert log.names[1:] == [
        channel.name.encode()[:33].decode(errors="ignore") for channel in drawn.channels
    ]
    assert log.units[1:] == [
        channel.unit.encode()[:9].decode(errors="ignore") for channel in drawn.channels
    ]
    for number, channel in enumerate(drawn.channels, 1):
        with np.errstate(over="ignore"):
            expected = drawn.values[channel.name].astype(np.float32)
        np.testing.assert_array_equal([row[number] for row in log.values], expected)


def test_counter_and_clock_roll_over_from_batch_to_batch(tmp_path, monkeypatch):
    monkeypatch.setattr(sheets, "BATCH", 100)
    out = tmp_path / "log.mlg"
    export(out, [TWAT], [rows([n / 8], TWAT=[n]) for n in range(700)])
    log = read_mlg(out.read_bytes())  # which checks the counter
    assert [row[1] for row in log.values] == list(range(700))
    assert log.clocks == [n * 12_500 % 65_536 for n in range(700)]


def test_ten_hours_keep_their_milliseconds(tmp_path):
    out = tmp_path / "log.mlg"
    export(out, [TWAT], [rows([0, 35_999.971], TWAT=[1, 2])])
    assert read_mlg(out.read_bytes()).values[1][0] == pytest.approx(35_999.971, abs=0.002)
    assert (35_999_971).to_bytes(4) in out.read_bytes()


def test_marks_stand_between_the_rows(tmp_path):
    out = tmp_path / "log.mlg"
    export(out, CHANNELS, FIXED, events=EVENTS)
    log = read_mlg(out.read_bytes())
    assert [round(row[0], 3) for row in log.values] == [0, 0.029, 0.75, 1.5, 9.5]
    assert log.marks == [
        (0, -50_000 % 65_536, "MARK 000 - стук"),
        (2, 25_000, "MARK 001 - gap of 1.0 s: no answer"),
        (3, 100_000 % 65_536, "MARK 002 - Batt V 18.1 > 18: danger"),
        (3, 150_000 % 65_536, 'MARK 003 - a "note" with two lines'),
        (4, 900_000 % 65_536, "MARK 004 - marker"),
        (4, 950_000 % 65_536, "MARK 005 - gap to the end: nothing came"),
    ]


def test_a_mark_byte_by_byte_as_tunerstudio_writes_it(tmp_path):
    out = tmp_path / "log.mlg"
    export(out, [TWAT], [rows([START], TWAT=[85])], events=[Marker(START + 0.25, "Manual")])
    assert out.read_bytes()[-54:] == bytes.fromhex("01 01 61 a8") + b"MARK 000 - Manual".ljust(
        50, b"\0"
    )


def test_long_marks_keep_begin_and_end_between_two_letters(tmp_path):
    out = tmp_path / "log.mlg"
    export(
        out,
        [TWAT],
        [rows([START], TWAT=[85])],
        events=[Marker(START, "Ж" * 40 + end) for end in ("1", "22")],
    )
    marks = [text for *_, text in read_mlg(out.read_bytes()).marks]
    assert marks == [f"MARK 000 - {'Ж' * 9}…{'Ж' * 8}1", f"MARK 001 - {'Ж' * 9}…{'Ж' * 7}22"]


def test_long_names_are_cut_between_characters_and_stay_different(tmp_path):
    out = tmp_path / "log.mlg"
    channels = [Channel("Ж" * 20 + str(n), "ЖЖЖЖЖЖ", Text("", "")) for n in range(3)]
    export(out, channels, [])
    log = read_mlg(out.read_bytes())
    assert log.names[1:] == ["Ж" * 16, "Ж" * 14 + "~2", "Ж" * 14 + "~3"]
    assert log.units[1:] == ["ЖЖЖЖ"] * 3


def test_more_channels_than_an_mlg_holds_are_refused(tmp_path):
    channels = [Channel(f"c{n}", "", Text("", "")) for n in range(1190)]
    export(tmp_path / "most.mlg", channels, [])
    assert len(read_mlg((tmp_path / "most.mlg").read_bytes()).names) == 1191
    with pytest.raises(ExportError, match=r"more\.mlg: an \.mlg holds 1190 channels"):
        export(tmp_path / "more.mlg", [*channels, TWAT], [])
