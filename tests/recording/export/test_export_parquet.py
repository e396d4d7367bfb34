"""Parquet, read back by pyarrow and by duckdb."""

from __future__ import annotations

import json

import duckdb
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from export_tables import (
    ALL_FLOATS,
    CHANNELS,
    FIXED,
    NAN,
    TWAT,
    exported,
    from_start,
    rows,
    tables,
)
from hypothesis import given, settings

from mikas.i18n import Text
from mikas.recording.export import export
from mikas.recording.export import parquet as writer
from mikas.recording.export import sheet as sheets
from mikas.recording.table.channels import Channel


def facts(path):
    return json.loads(pq.read_metadata(path).metadata[b"mikas"])


def test_the_fixed_table_is_read_back_from_parquet(tmp_path):
    out = tmp_path / "it's «поездка».parquet"
    export(out, CHANNELS, FIXED, about={"unit": "it's a “Микас”"})
    table = pq.read_table(out)
    assert table.schema.names == ["time", "TWAT", "UACC", "IDLE"]
    assert table.schema.types == [pa.float64(), pa.float64(), pa.float64(), pa.bool_()]
    assert table["TWAT"].to_pylist() == [85, None, -40]
    assert table["UACC"].to_pylist() == [13.84, -0.04, None]
    assert table["IDLE"].to_pylist() == [True, None, False]
    reported = facts(out)
    assert reported.pop("program").startswith("mikas ")
    assert reported == {
        "started": "2023-11-14T22:13:20+00:00",
        "about": {"unit": "it's a “Микас”"},
        "time": {"unit": "s", "en": "Time since the start", "ru": "Время от начала"},
        "channels": {
            "TWAT": {
                "unit": "°C",
                "en": "Coolant temperature",
                "ru": "Температура охлаждающей жидкости",
                "decimals": 0,
            },
            "UACC": {
                "unit": "V", "en": "Board voltage", "ru": "Напряжение бортсети", "decimals": 1,
            },
            "IDLE": {"unit": "", "en": "Idle", "ru": "Холостой ход", "decimals": 0},
        },
        "events": [],
    }  # fmt: skip


def test_no_rows_are_a_file_with_its_columns(tmp_path):
    out = tmp_path / "log.parquet"
    export(out, CHANNELS, [])
    assert pq.read_table(out).num_rows == 0
    assert pq.read_schema(out).names == ["time", "TWAT", "UACC", "IDLE"]
    assert facts(out)["started"] is None


def test_a_name_with_quotes_and_sql_in_it_is_a_column(tmp_path):
    out = tmp_path / "log.parquet"
    name = "a\"b'; DROP TABLE collected; --"
    export(out, [Channel(name, "'", Text("'", '"'))], [rows([0.0], **{name: [7]})])
    assert pq.read_table(out)[name].to_pylist() == [7]
    assert facts(out)["channels"][name]["unit"] == "'"


@settings(max_examples=20)
@given(drawn=tables(ALL_FLOATS))
def test_what_was_exported_is_read_back(tmp_path_factory, drawn):
    out = exported(drawn, tmp_path_factory.getbasetemp() / "log.parquet")
    arrow = pq.read_table(out)
    quoted = ", ".join(f"t.{_quoted(channel.name)}" for channel in drawn.channels)
    with duckdb.connect() as database:
        by_duckdb = database.execute(
            f"SELECT t.time, {quoted} FROM read_parquet(?) t", [str(out)]
        ).fetchall()
    np.testing.assert_array_equal(arrow["time"].to_numpy(), from_start(drawn))
    assert [row[0] for row in by_duckdb] == from_start(drawn).tolist()
    for number, channel in enumerate(drawn.channels, 1):
        expected = [None if value != value else value for value in drawn.values[channel.name]]
        assert arrow[channel.name].to_pylist() == expected  # True == 1.0
        assert [row[number] for row in by_duckdb] == expected


def _quoted(name):
    return '"' + name.replace('"', '""') + '"'


def test_many_stretches_and_row_groups_keep_their_order(tmp_path, monkeypatch):
    monkeypatch.setattr(writer, "_GROUP", 2048)
    out = tmp_path / "log.parquet"
    times = np.arange(100_000) / 35
    values = {"TWAT": np.where(np.arange(100_000) % 10, np.arange(100_000.0), NAN)}
    pieces = (
        sheets.Rows(times[a : a + 999], {"TWAT": values["TWAT"][a : a + 999]})
        for a in range(0, 100_000, 999)
    )
    export(out, [TWAT], pieces)
    table = pq.read_table(out)
    assert pq.read_metadata(out).num_row_groups > 10
    np.testing.assert_array_equal(table["time"].to_numpy(), times)
    assert table["TWAT"].null_count == 10_000
    np.testing.assert_array_equal(table["TWAT"].to_numpy(), values["TWAT"])
