"""CSV: what RomRaider's readers and spreadsheets expect, cell by cell."""

from __future__ import annotations

import csv
import math

import numpy as np
from export_tables import CHANNELS, FIXED, MODERATE, TWAT, exported, from_start, rows, tables
from hypothesis import given
from hypothesis import strategies as st

from csv_columns import columns_of
from mikas.catalog import shipped
from mikas.cleaning import spreadsheet_text
from mikas.i18n import Text
from mikas.recording.export import EXCEL, PLAIN, Dialect, export
from mikas.recording.table.channels import Channel, all_channels


def test_a_csv_file_has_these_bytes(tmp_path):
    """Of both dialects."""
    out = tmp_path / "log.csv"
    export(out, CHANNELS, FIXED)
    assert out.read_bytes().decode() == (
        "Time (msec),TWAT Coolant temperature (°C),UACC Board voltage (V),IDLE Idle\n"
        "0,85,13.84,1\n"
        "29,,-0.04,\n"
        "1500,-40,,0\n"
    )
    export(out, CHANNELS, FIXED, dialect=EXCEL, language="ru", overwrite=True)
    assert out.read_bytes().decode() == (
        "\ufeffTime (msec);TWAT Температура охлаждающей жидкости (°C);"
        "UACC Напряжение бортсети (V);IDLE Холостой ход\n"
        "0;85;13,84;1\n"
        "29;;-0,04;\n"
        "1500;-40;;0\n"
    )


def test_units_are_in_the_header_s_language(tmp_path):
    channels = all_channels({}, shipped(), ["FREQ", "SSM"], {}).values()
    for language, units in (("en", ["(rpm)", "(step)"]), ("ru", ["(об/мин)", "(шаг)"])):
        out = tmp_path / f"{language}.csv"
        export(out, channels, [], language=language)
        line = out.read_text("utf-8").splitlines()[0]
        assert [each.split()[-1] for each in line.split(",")[1:]] == units


def test_time_counts_from_the_first_row(tmp_path):
    out = tmp_path / "log.csv"
    export(out, [TWAT], [rows([2.5, 4], TWAT=[1, 2])])
    columns = columns_of(out.read_text())
    assert (columns["Time"], columns["TWAT"]) == (["0", "1500"], ["1", "2"])


def test_no_rows_are_a_header(tmp_path):
    out = tmp_path / "log.csv"
    assert export(out, [TWAT], []).rows == 0
    assert out.read_text("utf-8").count("\n") == 1
    assert columns_of(out.read_text("utf-8"))["TWAT"] == []


def test_a_header_never_needs_quotes(tmp_path):
    out = tmp_path / "log.csv"
    export(out, [Channel("A", "m,s", Text('one, "two"\n three', ""))], [])
    assert "A one two three (m s)" in out.read_text().strip().split(",")
    assert '"' not in out.read_text()


def test_infinity_is_missing(tmp_path):
    out = tmp_path / "log.csv"
    export(out, [TWAT], [rows([0, 1, 2], TWAT=[math.inf, -math.inf, 1e300])])
    assert columns_of(out.read_text())["TWAT"][:2] == ["", ""]


@given(dialect=st.sampled_from([PLAIN, EXCEL, Dialect("\t")]), drawn=tables(MODERATE))
def test_what_was_exported_is_read_back(tmp_path_factory, dialect, drawn):
    out = exported(drawn, tmp_path_factory.getbasetemp() / "log.csv", dialect=dialect)
    text = out.read_bytes().decode("utf-8-sig" if dialect.mark else "utf-8")
    titles, *cells = csv.reader(text.splitlines(), delimiter=dialect.separator, strict=True)
    number = titles.index("Time (msec)")
    assert [int(row[number]) for row in cells] == np.rint(from_start(drawn) * 1000).tolist()
    for channel in drawn.channels:
        unit = f"({channel.unit})" if channel.unit else ""
        title = f"{channel.name} {channel.text.en} {unit}".replace(dialect.separator, " ")
        title = spreadsheet_text(" ".join(title.replace('"', " ").split()))
        number = titles.index(title, number + 1)
        for row, value in zip(cells, drawn.values[channel.name], strict=True):
            if math.isnan(value):
                assert row[number] == ""
            else:
                read = row[number].replace(dialect.decimal, ".")
                assert float(read) == value
                assert "e" not in read
                assert not read.endswith((".0", "."))
                assert not (read.startswith("-") and float(read) == 0)
