"""Markers, notes, gaps and alarms in the files, read back as other programs read them."""

from __future__ import annotations

import json

import duckdb
import pyarrow.parquet as pq
import pytest
from export_tables import CHANNELS, EVENTS, FIXED, START, TWAT, rows
from hypothesis import given
from hypothesis import strategies as st

from csv_columns import columns_of
from mikas.recording.export import SUFFIXES, export
from mikas.recording.export import sheet as sheets
from mikas.sampling.events import Marker

ALARM = {
    "name": "UACC", "level": "danger", "before": "none", "side": "high", "value": 18.1, "limit": 18,
}  # fmt: skip


def test_parquet_has_them_in_its_metadata(tmp_path):
    out = tmp_path / "log.parquet"
    export(out, CHANNELS, FIXED, events=EVENTS)
    reported = json.loads(pq.read_metadata(out).metadata[b"mikas"])["events"]
    words = [(it.pop("en"), it.pop("ru")) for it in reported]
    assert reported == [
        {"kind": "marker", "time": -0.5},
        {"kind": "gap", "time": 0.25, "ended": 1.25},
        {"kind": "alarm", "time": 1, **ALARM},
        {"kind": "note", "time": 1.5},
        {"kind": "marker", "time": 9},
        {"kind": "gap", "time": 9.5, "ended": None},
    ]
    assert words == [
        ("стук", "стук"),
        ("gap of 1.0 s: no answer", "разрыв 1,0 с: нет ответа"),
        (
            "Board voltage 18.1 V is above 18 V: danger",
            "Напряжение 18,1 В выше 18 В: опасность",
        ),
        ('a "note" with two lines', 'a "note" with two lines'),
        ("marker", "отметка"),
        ("gap to the end: nothing came", "разрыв до конца: ничего не пришло"),
    ]
    key = f"SELECT decode(value) FROM parquet_kv_metadata('{out}') WHERE decode(key) = 'mikas'"
    ((by_duckdb,),) = duckdb.sql(key).fetchall()
    assert len(json.loads(by_duckdb)["events"]) == len(reported)


def test_msl_has_them_as_lines_between_the_rows(tmp_path):
    out = tmp_path / "log.msl"
    export(out, CHANNELS, FIXED, events=EVENTS)
    units, *lines = out.read_bytes().decode().splitlines()[-12:]
    assert units == "s\t°C\tV\t"
    assert [line.split("\t")[0] for line in lines] == [
        "MARK 000 - стук",
        "0.000",
        "0.029",
        "MARK 001 - gap of 1.0 s: no answer",
        "0.750",
        "MARK 002 - Board voltage 18.1 V is above 18 V: danger",
        'MARK 003 - a "note" with two lines',
        "1.500",
        "MARK 004 - marker",
        "MARK 005 - gap to the end: nothing came",
        "9.500",
    ]
    assert lines[4].split("\t")[1:] == ["NaN", "NaN", "NaN"]


def test_marks_are_in_the_requested_language(tmp_path):
    out = tmp_path / "log.msl"
    export(out, CHANNELS, FIXED, events=EVENTS, language="ru")
    assert "MARK 001 - разрыв 1,0 с: нет ответа" in out.read_text("utf-8").splitlines()


POINT, BEGINNING, END = 0, 1, 2
INTERRUPT, MARKER = 2, 6
ERROR, TOOL, USER = 1, 2, 4


def test_mdf_has_them_as_events(tmp_path):
    out = tmp_path / "log.mf4"
    export(out, CHANNELS, FIXED, events=EVENTS)
    from asammdf import MDF  # here: its import takes 2 s

    with MDF(out) as mdf:
        events = mdf.events
        shape = [(it.event_type, it.cause, it.range_type) for it in events]
        times = [it.value for it in events]
        names = [it.name for it in events]
        (beginning,) = [it for it in events if it.range_type == BEGINNING]
        (end,) = [it for it in events if it.range_type == END]
        assert end.range_start_ev_addr == beginning.address
        assert [value == value for value in mdf.get("TWAT").samples] == [
            True, False, False, True, False,  # two rows of gaps
        ]  # fmt: skip
        assert events[3].comment == (
            "alarm: Board voltage 18.1 V is above 18 V: danger / "
            "Напряжение 18,1 В выше 18 В: опасность"
        )
        assert events[0].comment == "marker: стук"
    assert shape == [
        (MARKER, USER, POINT),
        (INTERRUPT, ERROR, BEGINNING),
        (INTERRUPT, ERROR, END),
        (MARKER, TOOL, POINT),
        (MARKER, USER, POINT),
        (MARKER, USER, POINT),
        (INTERRUPT, ERROR, POINT),
    ]
    assert times == pytest.approx([-0.5, 0.25, 1.25, 1, 1.5, 9, 9.5])
    assert names[0] == "стук"
    assert names[1] == names[2] == "gap of 1.0 s: no answer"


def test_mdf_with_many_events_is_read_back(tmp_path):
    out = tmp_path / "log.mf4"
    events = [Marker(START + number, f"отметка {number}") for number in range(300)]
    export(out, [TWAT], [rows([START], TWAT=[85])], events=events)
    from asammdf import MDF  # here: its import takes 2 s

    with MDF(out) as mdf:
        assert [it.name for it in mdf.events] == [it.label for it in events]
        assert mdf.get("TWAT").samples.tolist() == [85]


def test_csv_has_but_the_rows_of_gaps(tmp_path):
    for name, events in (("with.csv", EVENTS), ("without.csv", [])):
        export(tmp_path / name, CHANNELS, FIXED, events=events)
    wanted = ["Time", *(channel.name for channel in CHANNELS)]
    without, more = (
        list(zip(*(columns[name] for name in wanted), strict=True))
        for name in ("without.csv", "with.csv")
        for columns in [columns_of((tmp_path / name).read_text("utf-8"))]
    )
    assert [row for row in more if row not in without] == [("750", *3 * [""]), ("9500", *3 * [""])]
    assert [row for row in more if row in without] == without


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_events_without_rows_are_exported(tmp_path, suffix):
    out = tmp_path / f"log{suffix}"
    assert export(out, CHANNELS, [], events=EVENTS).rows == 0
    if suffix == ".msl":
        assert out.read_text("utf-8").count("MARK ") == 6
    if suffix == ".parquet":
        reported = json.loads(pq.read_metadata(out).metadata[b"mikas"])
        assert reported["started"] == "2023-11-14T22:13:19+00:00"
        assert [it["time"] for it in reported["events"]] == [0.5, 1.25, 2, 2.5, 10, 10.5]


@given(
    times=st.lists(st.integers(0, 40), max_size=8),
    steps=st.lists(st.integers(0, 5), min_size=1, max_size=30),
    stretch=st.integers(1, 7),
)
def test_a_mark_stands_before_the_first_row_that_is_not_older(
    tmp_path_factory, times, steps, stretch
):
    out = tmp_path_factory.getbasetemp() / "marks.msl"
    at = [sum(steps[: count + 1]) for count in range(len(steps))]
    pieces = [rows([START + time], TWAT=[time]) for time in at]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sheets, "BATCH", stretch)
        events = [Marker(START + time, str(time)) for time in times]
        export(out, [TWAT], pieces, events=events, overwrite=True)
    lines = out.read_text("utf-8").splitlines()[4:]
    expected = sorted(
        [(time, 0) for time in times] + [(time, 1) for time in at],
    )
    assert [
        (int(line.rpartition(" ")[2]), 0) if line.startswith("MARK") else (int(line[-2:]), 1)
        for line in lines
    ] == expected
    assert [line[5:8] for line in lines if line.startswith("MARK")] == [
        f"{number:03d}" for number in range(len(times))
    ]
