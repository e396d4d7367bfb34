"""Any window of a recording: the rows themselves, or their extremes; nothing lost between."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mikas
from mikas.catalog import shipped
from mikas.errors import UnknownParameter, UsageError
from mikas.recording import CaptureWriter
from mikas.recording.table import window as table_window
from mikas.recording.table.channels import Rows
from mikas.recording.table.window import Windows
from protocol_codes import NAMES

NAN = np.nan
PORT = "sim:?clock=simulated&scenario=city"
CONVERSIONS = {p.name: p.interpretation("corrected") for p in shipped().parameters}


@pytest.fixture(params=["as it is", "packed"], autouse=True)
def kept(request, monkeypatch):
    """A recording of any length is kept like a short one, and like one of ten hours."""
    if request.param == "packed":
        monkeypatch.setattr(table_window, "_SHORT", 100)


@pytest.fixture
def drive(recorded_drive):
    return mikas.open(recorded_drive)


@pytest.fixture(scope="module")
def recorded_drive(tmp_path_factory):
    path = tmp_path_factory.mktemp("drive") / "a.pcapng"
    with CaptureWriter(path, url=PORT) as sink, mikas.connect(PORT, sink=sink) as ecu:
        for _ in ecu.watch(*NAMES, method="list", count=300):
            pass
    return path


def test_few_rows_are_given_as_they_are_to_the_bit(drive):
    (rows,) = drive.rows()
    window, decimated = drive.window(*drive.span, points=1000)
    assert not decimated
    np.testing.assert_array_equal(window.times, rows.times)
    assert list(window.values) == [channel.name for channel in drive.channels]
    for name, column in rows.values.items():
        np.testing.assert_array_equal(window.values[name], column)
    part, _ = drive.window(rows.times[10], rows.times[12], names=["freq"])
    assert list(part.values) == ["FREQ"]
    np.testing.assert_array_equal(part.times, rows.times[10:13])


def test_wrong_names_and_less_than_two_points_are_refused(drive):
    with pytest.raises(UnknownParameter):
        drive.window(0, 1, names=["TWATT"])
    with pytest.raises(UsageError, match="not among"):
        mikas.open(drive.path, names=["TWAT"]).window(0, 1, names=["FREQ"])
    with pytest.raises(ValueError, match="two points"):
        drive.window(0, 1, points=1)


def test_a_window_where_nothing_is_has_no_rows(drive):
    for begin, end in ((-9.0, -5.0), (1e6, 2e6), (5.0, 1.0)):
        rows, decimated = drive.window(begin, end)
        assert not len(rows.times)
        assert not decimated


def made(times, **columns):
    return Windows([Rows(np.array(times, float), columns)], CONVERSIONS)


@pytest.mark.parametrize("count", [500, 5_000, 70_000])
def test_a_spike_stays_and_so_does_its_order(count):
    speed = np.full(count, 840.0)
    speed[count // 2], speed[count // 2 + 1] = 6000.0, 0.0
    level = np.linspace(0, 1, count)
    rows, decimated = made(np.arange(count) / 30, FREQ=speed, OWN=level).window(
        0, 1e9, 100, ["FREQ", "OWN"]
    )
    assert decimated
    assert len(rows.times) <= 100
    assert (np.diff(rows.times) >= 0).all()
    assert rows.values["FREQ"].max() == 6000.0
    assert rows.values["FREQ"].min() == 0.0
    assert rows.values["FREQ"].argmax() < rows.values["FREQ"].argmin()
    assert (np.diff(rows.values["OWN"]) >= 0).all()
    assert (rows.values["OWN"][0], rows.values["OWN"][-1]) == (0.0, 1.0)


def test_a_time_without_values_is_a_hole():
    times = np.concatenate((np.arange(2000) / 100, 40 + np.arange(2000) / 100))
    speed = np.full(4000, 840.0)
    speed[1000:1500] = NAN
    rows, decimated = made(times, FREQ=speed).window(0, 99, 200, ["FREQ"])
    assert decimated
    empty = np.isnan(rows.values["FREQ"])
    assert (empty & (rows.times > 20) & (rows.times < 40)).any()
    assert empty[(rows.times > 10.5) & (rows.times < 14.5)].all()
    assert not empty[(rows.times < 9) | (rows.times > 41)].any()


def test_sessions_whose_times_run_back_are_put_in_order():
    rows = [
        Rows(np.array([10.0, 11.0]), {"FREQ": np.array([40.0, 80.0])}),
        Rows(np.array([5.0, 10.5]), {"FREQ": np.array([120.0, NAN])}),
    ]
    found, _ = Windows(rows, CONVERSIONS).window(0, 20, 100, ["FREQ"])
    assert found.times.tolist() == [5, 10, 10.5, 11]
    np.testing.assert_array_equal(found.values["FREQ"], [120, 40, NAN, 80])


columns = st.lists(st.sampled_from([NAN, 0.0, 40.0, 840.0, 10200.0, 0.3]), min_size=1, max_size=900)


@settings(max_examples=60)
@given(columns, st.integers(2, 40), st.floats(0, 1), st.floats(0, 1), st.randoms())
def test_extremes_are_those_of_the_rows_in_the_window(column, points, a, b, random):
    steps = [random.choice([0.0, 0.03, 0.03, 5.0]) for _ in column]
    times = np.cumsum(steps)
    values = np.array(column)
    begin, end = sorted((a * times[-1], b * times[-1]))
    inside = values[(times >= begin) & (times <= end)]
    rows, decimated = made(times, FREQ=values).window(begin, end, points, ["FREQ"])
    assert decimated == (len(inside) > points)
    shown = rows.values["FREQ"]
    assert (np.diff(rows.times) >= 0).all()
    if np.isnan(inside).all():
        assert np.isnan(shown).all()
        return
    assert (np.nanmin(shown), np.nanmax(shown)) == (np.nanmin(inside), np.nanmax(inside))
    assert set(shown[~np.isnan(shown)]) <= set(inside)
