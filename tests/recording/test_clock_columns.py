"""The clock of a recording's tables, their rows and their end."""

from __future__ import annotations

import json
from datetime import UTC, datetime, timedelta

import numpy as np
import pyarrow as pa
import pytest

import mikas
from mikas.errors import UnknownParameter, UsageError
from mikas.framing import encode
from mikas.link.base import Direction
from mikas.recording import CaptureWriter
from mikas.recording.annotations.events import note_of
from mikas.recording.table.dates import checked_zone, microseconds
from mikas.sampling.events import Gap

NOON = 1_700_000_000.0  # 2023-11-14 22:13:20 UTC
FIRST = datetime(2023, 11, 14, 22, 13, 20, 6_875, tzinfo=UTC)


def drive(path, *events, zero=NOON, count=4):
    """Record FREQ 840 rpm, four times a second."""
    with CaptureWriter(path, url="/dev/ttyUSB0") as sink:
        for number in range(count):
            begin = zero + number / 4
            sink.record(Direction.SENT, encode(bytes((0x61, 0x29))), begin)
            sink.record(Direction.RECEIVED, encode(bytes((21,))), begin + 0.01)
        for event in events:
            sink.note(note_of(event))
    return path


@pytest.fixture
def recording(tmp_path):
    return mikas.open(drive(tmp_path / "drive.pcapng"))


def test_the_clock_of_a_table_is_utc(recording):
    index = recording.to_pandas(time="clock").index
    assert index.name == "time"
    assert str(index.tz) == "UTC"
    assert index[0].to_pydatetime() == FIRST
    assert (index[-1] - index[0]).total_seconds() == 0.75


def test_the_clock_is_shown_in_a_zone(recording):
    pandas = recording.to_pandas(time="clock", zone="Europe/Moscow")
    polars = recording.to_polars(time="clock", zone="Europe/Moscow")
    arrow = recording.to_arrow(time="clock", zone="Europe/Moscow")
    assert pandas.index[0].isoformat() == "2023-11-15T01:13:20.006875+03:00"
    for first in (polars["time"][0], arrow["time"][0].as_py()):
        assert first == FIRST
        assert first.utcoffset() == timedelta(hours=3)
    assert arrow.schema.field("time").type == pa.timestamp("us", "Europe/Moscow")
    assert arrow.schema.field("time").metadata[b"en"] == b"Date and time"
    assert json.loads(arrow.schema.metadata[b"mikas"])["started"].startswith("2023-11-14T22")


def test_a_drive_is_joined_with_another_log_by_its_clock(recording):
    import pandas as pd

    track = pd.DataFrame(
        {"lat": [56.1, 56.2]}, index=pd.to_datetime([FIRST, FIRST + timedelta(seconds=0.5)])
    )
    joined = pd.merge_asof(
        recording.to_pandas(time="clock"), track, left_index=True, right_index=True
    )
    assert joined.lat.tolist() == [56.1, 56.1, 56.2, 56.2]


def test_a_recording_without_a_date_has_no_clock(tmp_path):
    undated = mikas.open(drive(tmp_path / "simulated.pcapng", zero=0.0))
    for convert in (undated.to_pandas, undated.to_polars, undated.to_arrow):
        with pytest.raises(UsageError, match=r'no date.*time="elapsed"') as caught:
            convert(time="clock")
        assert "нет даты" in caught.value.reason.ru
    assert undated.to_pandas().index[0] == 0


def test_one_session_without_a_date_is_enough():
    with pytest.raises(UsageError, match="no date"):
        microseconds(np.array([NOON, 12.0, NOON + 1]))
    assert microseconds(np.empty(0)).tolist() == []
    assert microseconds(np.array([NOON + 0.1])).tolist() == [1_700_000_000_100_000]


def test_a_wrong_zone_or_time_names_what_there_is(recording):
    with pytest.raises(UsageError, match=r"Did you mean Europe/Moscow\?"):
        recording.to_pandas(time="clock", zone="Europe/Moskow")
    for name in ("", "../etc/passwd", "Europe", "Москва"):
        with pytest.raises(UsageError, match="UTC, Europe/Moscow"):
            checked_zone(name)
    with pytest.raises(UsageError, match="elapsed, clock"):
        recording.to_polars(time="wall")
    with pytest.raises(UsageError, match='Europe/Moscow is of time="clock"'):
        recording.to_arrow(zone="Europe/Moscow")


def test_its_length_is_that_of_its_tables(tmp_path):
    gap = Gap(NOON + 0.4, NOON + 0.26, NOON + 0.4)
    with_gap = mikas.open(drive(tmp_path / "gap.pcapng", gap))
    assert len(with_gap) == len(with_gap.to_pandas()) == 5
    assert with_gap.duration == pytest.approx(0.75)
    empty = mikas.open(drive(tmp_path / "empty.pcapng", count=0))
    assert (len(empty), empty.duration) == (0, 0)


def test_a_closed_recording_has_no_rows(tmp_path):
    with mikas.open(drive(tmp_path / "drive.pcapng")) as recording:
        assert recording.window(NOON, NOON + 9)[0].times.size == 4
        held = recording.held
    assert recording.held < held
    for read in (recording.to_pandas, lambda: recording.window(NOON, NOON + 9)):
        with pytest.raises(UsageError, match=r"drive\.pcapng is closed"):
            read()
    assert recording.about["port"] == "/dev/ttyUSB0"
    recording.close()


def test_a_misspelt_channel_names_the_nearest(tmp_path):
    path = drive(tmp_path / "drive.pcapng")
    with pytest.raises(UnknownParameter, match="FREQ"):
        mikas.open(path, names=["FREQQ"])
    assert [each.name for each in mikas.open(path, names="FREQ").channels] == ["FREQ"]
