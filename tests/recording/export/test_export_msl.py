"""MegaLogViewer's text log."""

from __future__ import annotations

import math

import pytest
from export_tables import CHANNELS, FIXED, MODERATE, NAN, TWAT, exported, from_start, rows, tables
from hypothesis import given

from mikas.cleaning import spreadsheet_text
from mikas.i18n import Text
from mikas.recording.export import export
from mikas.recording.table.channels import Channel
from viewer_logs import read_msl


def test_an_msl_file_has_these_bytes(tmp_path):
    out = tmp_path / "log.msl"
    export(out, CHANNELS, FIXED, about={"unit": 'Mikas\n"7.1"'})
    head, _, body = out.read_text(encoding="utf-8").partition("\n")
    assert head.startswith('"mikas ')
    assert head.endswith(
        ": unit: Mikas '7.1'; CLT = TWAT = Coolant temperature / Температура охлаждающей жидкости; "
        'Batt V = UACC = Board voltage / Напряжение бортсети; IDLE = Idle / Холостой ход"'
    )
    assert body == (
        '"Capture Date: Tue Nov 14 22:13:20 UTC 2023"\n'
        "Time\tCLT\tBatt V\tIDLE\n"
        "s\t°C\tV\t\n"
        "0.000\t85\t13.84\t1\n"
        "0.029\tNaN\t-0.04\tNaN\n"
        "1.500\t-40\tNaN\t0\n"
    )


@pytest.mark.parametrize(
    ("begin", "date"), [(12.5, "unknown"), (1.7e9, "Tue Nov 14 22:13:20 UTC 2023")]
)
def test_the_date_is_the_recording_s_not_today_s(tmp_path, begin, date):
    out = tmp_path / "log.msl"
    export(out, [TWAT], [rows([begin], TWAT=[1])])
    assert read_msl(out)[1] == f"Capture Date: {date}"


def test_no_rows_are_a_heading(tmp_path):
    out = tmp_path / "log.msl"
    export(out, [TWAT], [])
    _, date, names, units, data = read_msl(out)
    assert (date, names, units, data) == (
        "Capture Date: unknown",
        ["Time", "CLT"],
        ["s", "°C"],
        [],
    )


def test_a_tab_in_a_name_does_not_make_a_column(tmp_path):
    out = tmp_path / "log.msl"
    export(out, [Channel('a\tb"', "m\ts", Text("x\ny", ""))], [rows([0], **{'a\tb"': [NAN]})])
    assert read_msl(out)[2:] == (["Time", "a b"], ["s", "m s"], [["0.000", "NaN"]])


@given(drawn=tables(MODERATE))
def test_what_was_exported_is_read_back(tmp_path_factory, drawn):
    out = exported(drawn, tmp_path_factory.getbasetemp() / "log.msl")
    _, _, names, units, data = read_msl(out)
    names_of = [" ".join(channel.name.split()) for channel in drawn.channels]
    assert names == ["Time", *map(spreadsheet_text, names_of)]
    assert units == ["s", *(spreadsheet_text(channel.unit) for channel in drawn.channels)]
    assert [float(row[0]) for row in data] == [float(f"{t:.3f}") for t in from_start(drawn)]
    for number, channel in enumerate(drawn.channels, 1):
        for row, value in zip(data, drawn.values[channel.name], strict=True):
            if math.isnan(value):
                assert row[number] == "NaN"
            else:
                assert float(row[number]) == value


def test_the_viewer_s_name_is_left_to_a_channel_that_has_it(tmp_path):
    out = tmp_path / "log.msl"
    own = [Channel(name, "", Text("", "")) for name in ("CLT", "BATT_V", "MINE")]
    export(out, [*CHANNELS, *own], [])
    assert read_msl(out)[2] == ["Time", "TWAT", "UACC", "IDLE", "CLT", "BATT_V", "MINE"]
