"""Drives of recordings: exact sums, and that a drive in two parts has the sums of the whole."""

from __future__ import annotations

from dataclasses import fields
from itertools import pairwise
from math import cos, radians

import numpy as np
import pytest
from drive_rig import Road, Session, Unit, recorded
from hypothesis import given
from hypothesis import strategies as st

from mikas.catalog import shipped
from mikas.drives import Trip, joined_trips, since_mark, trips
from mikas.drives.curves import SampledCurve, sampled_curve
from mikas.drives.finding import drives_of
from mikas.drives.measuring import DriveCurves
from mikas.drives.ways import way_of
from mikas.drives.wording import NO_FUEL, NO_SPEED, SHORT, left_out
from mikas.errors import UsageError
from mikas.i18n import Text
from mikas.recording.recording import Recording

STOPPED = 0


def near(values):
    """A capture has whole microseconds."""
    return pytest.approx(values, abs=1e-5)


def steady(begin: int, end: int, rpm: int = 1200, flow: float | None = 7.2) -> list[Unit]:
    return [Unit(float(at), rpm, flow) for at in range(begin, end + 1)]


def test_a_drive_has_exactly_its_fuel_distance_and_idle_time(tmp_path):
    road = [Road(at + 0.25, 0.0) for at in range(9, 61)]
    road += [Road(at + 0.25, 72.0) for at in range(61, 162)]
    recording = recorded(tmp_path / "a.pcapng", Session(steady(10, 160), road))
    (trip,) = trips(recording)
    assert (trip.begin, trip.end, trip.seconds) == near((10.0, 160.0, 150.0))
    assert (trip.gap_seconds, trip.fuel_seconds, trip.speed_seconds) == near((0.0, 150.0, 150.0))
    assert trip.litres == pytest.approx(7.2 * 150 / 3600, rel=1e-6)
    assert trip.litres_from == "JQT"
    # From 60.25 to 61.25 the speed rises from 0 to 72: 10 m.
    metres = 10 + (160 - 61.25) * 20
    assert trip.kilometres == pytest.approx(metres / 1000, rel=1e-6)
    assert trip.idle_seconds == pytest.approx(50.25, abs=1e-3)
    assert trip.idle_known == near(150.0)
    assert trip.mean_speed == pytest.approx(metres / 150 * 3.6, rel=1e-6)
    assert trip.litres_per_100_km == pytest.approx(100 * trip.litres / trip.kilometres, rel=1e-12)
    assert (trip.highest_speed, trip.highest_rpm) == (72.0, 1200.0)
    assert trip.mean_rpm == pytest.approx(1200.0, rel=1e-12)


def test_what_a_gap_leaves_out_is_no_part_of_a_sum(tmp_path):
    road = [Road(float(at), 36.0) for at in range(301)]
    unit = [*steady(0, 100), *steady(200, 300)]
    (trip,) = trips(recorded(tmp_path / "a.pcapng", Session(unit, road)))
    assert (trip.seconds, trip.gap_seconds, trip.fuel_seconds) == near((300.0, 100.0, 200.0))
    assert trip.litres == pytest.approx(7.2 * 200 / 3600, rel=1e-6)
    assert trip.kilometres == pytest.approx(3.0, rel=1e-4)  # the receiver heard all of it
    # 7.2 litres an hour at 36 km/h, whatever was left out.
    assert trip.litres_per_100_km == pytest.approx(20.0, rel=1e-6)


def test_a_drive_ends_where_the_engine_stops_and_in_a_long_gap(tmp_path):
    unit = [
        Unit(0.0, STOPPED, 0.0), *steady(1, 50), Unit(51.0, STOPPED, 0.0), *steady(60, 90),
        *steady(400, 420), Unit(421.0, 200, 0.0),
    ]  # fmt: skip
    recording = recorded(tmp_path / "a.pcapng", Session(unit), Session(steady(500, 510)))
    found = trips(recording)
    assert [each.session for each in found] == [0, 0, 0, 1]
    assert [each.begin for each in found] == near([1.0, 60.0, 400.0, 500.0])
    assert [each.end for each in found] == near([50.0, 90.0, 420.0, 510.0])
    whole = joined_trips(found)
    assert whole.seconds == near(49 + 30 + 20 + 10)
    assert whole.litres == pytest.approx(7.2 * whole.seconds / 3600, rel=1e-6)
    assert (whole.kilometres, whole.mean_speed, whole.litres_per_100_km) == (None, None, None)


def test_without_a_receiver_the_unit_s_flag_says_when_the_car_stands(tmp_path):
    unit = [Unit(float(at), 800, 1.0, idle=True) for at in range(31)]
    unit += [Unit(float(at), 2400, 5.0, idle=at >= 41) for at in range(31, 51)]  # coasts at last
    (trip,) = trips(recorded(tmp_path / "a.pcapng", Session(unit)))
    assert (trip.idle_seconds, trip.idle_known) == near((30.0, 50.0))
    (trip,) = trips(recorded(tmp_path / "b.pcapng", Session(steady(0, 10))))
    assert (trip.idle_seconds, trip.idle_known) == (None, 0.0)


def test_litres_on_100_km_need_a_kilometre(tmp_path):
    road = [Road(float(at), 36.0) for at in range(91)]
    (trip,) = trips(recorded(tmp_path / "a.pcapng", Session(steady(0, 90), road)))
    assert trip.kilometres == pytest.approx(0.9, rel=1e-3)
    assert trip.litres_per_100_km is None


def test_a_recording_without_fuel_has_no_litres_and_none_without_speed_is_refused(tmp_path):
    (trip,) = trips(recorded(tmp_path / "a.pcapng", Session(steady(0, 20, flow=None))))
    assert (trip.litres, trip.litres_from, trip.fuel_seconds) == (None, None, 0.0)
    alone = [Unit(float(at), None, 1.0) for at in range(20)]
    with pytest.raises(UsageError, match="FREQ: not in this recording"):
        trips(recorded(tmp_path / "b.pcapng", Session(alone)))
    silent = [Unit(float(at), STOPPED, 0.0) for at in range(20)]
    assert trips(recorded(tmp_path / "c.pcapng", Session(silent))) == []


def test_since_a_mark_only_what_comes_after_it_counts(tmp_path):
    marks = [(20.0, "Filled up"), (40.0, ""), (60.0, "filled up")]
    first = Session(steady(0, 100), marks=marks)
    recording = recorded(tmp_path / "a.pcapng", first, Session(steady(200, 210)))
    assert since_mark([recording], " FILLED up")[1].time == 60.0
    assert since_mark([recording, recording], "2") == since_mark([recording], "2")
    assert since_mark([recording, recording], "4")[0] == 1
    found = trips(recording, since_mark([recording], "filled up")[1])
    assert [each.begin for each in found] == near([60.0, 200.0])
    assert [each.end for each in found] == near([100.0, 210.0])
    assert found[0].litres == pytest.approx(7.2 * 40 / 3600, rel=1e-6)
    for wrong in ("4", "0", "filled", ""):
        with pytest.raises(UsageError, match="1 Filled up, 2, 3 filled up"):
            since_mark([recording], wrong)
    plain = recorded(tmp_path / "b.pcapng", Session(steady(0, 10)))
    with pytest.raises(UsageError, match="no mark"):
        since_mark([plain], "1")


def test_a_clock_that_was_set_back_ends_a_drive(tmp_path):
    late, early = Session(steady(100, 150)), Session(steady(20, 60))
    heads = len(Session([]).blocks())
    (tmp_path / "a.pcapng").write_bytes(late.blocks() + early.blocks()[heads:])
    found = trips(Recording(tmp_path / "a.pcapng", shipped()))
    assert [each.seconds for each in found] == near([50.0, 40.0])


# Whatever the curves are

_times = st.lists(st.integers(1, 40), min_size=2, max_size=30).map(
    lambda steps: np.cumsum(np.array(steps, np.float64)) / 8
)


@st.composite
def _curve(draw, most):
    times = draw(_times)
    value = st.one_of(st.integers(0, most), st.just(float("nan")))
    values = draw(st.lists(value, min_size=len(times), max_size=len(times)))
    return SampledCurve(times, np.array(values, np.float64), 2.0)


@st.composite
def _curves(draw):
    optional = st.none() | _curve(120)
    fuel = draw(optional)
    return DriveCurves(
        0, draw(_curve(6000)), fuel, "JQT" if fuel is not None else None, draw(optional),
        draw(st.none() | _curve(1)),
    )  # fmt: skip


@given(_curves(), st.lists(st.integers(0, 1200).map(lambda at: at / 8), min_size=3, max_size=6))
def test_splitting_a_drive_changes_no_sum(curves, moments):
    moments = sorted(set(moments))
    whole = curves.trip(moments[0], moments[-1])
    parts = joined_trips(curves.trip(begin, end) for begin, end in pairwise(moments))
    if parts is None:
        return
    for each in fields(Trip):
        one, other = getattr(whole, each.name), getattr(parts, each.name)
        assert (one is None) == (other is None), each.name
        if isinstance(one, float):
            assert one == pytest.approx(other, rel=1e-9, abs=1e-9), each.name
        else:
            assert one == other, each.name
    assert 0 <= whole.gap_seconds <= whole.seconds
    assert (whole.idle_seconds or 0.0) <= whole.idle_known + 1e-9 <= whole.seconds + 2e-9


@given(_curve(100), st.floats(0.1, 50))
def test_the_curve_meets_its_samples_and_is_unknown_in_a_pause(curve, longest):
    known = SampledCurve(curve.times, curve.values, longest)
    pieces = known.over(curve.times)
    for at, step in enumerate(np.diff(curve.times)):
        ends = curve.values[at], curve.values[at + 1]
        if step <= longest and np.isfinite(ends).all():
            assert (pieces.begins[at], pieces.ends[at]) == pytest.approx(ends)
        else:
            assert np.isnan(pieces.begins[at])
            assert np.isnan(pieces.ends[at])


def test_a_slow_method_s_usual_step_is_no_pause():
    times = np.arange(33) * 3.0
    assert sampled_curve(times, np.ones(len(times))).longest == 7.5
    assert sampled_curve(times / 10, np.ones(len(times))).longest == 2.0


def test_the_sums_of_a_recording_are_those_of_its_parts(tmp_path):
    road = [Road(at + 0.25, 50.0 + at % 7) for at in range(301)]
    unit = [Unit(at / 2, 800 + 40 * (at % 30), (at % 50) / 10) for at in range(601)]
    recording = recorded(tmp_path / "a.pcapng", Session(unit, road))
    (running,) = drives_of(recording)
    (whole,) = trips(recording)
    at = [running.begin, 33.3, 100.0, 100.1, 299.0, running.end]
    parts = joined_trips(running.curves.trip(*both) for both in pairwise(at))
    assert parts.litres == pytest.approx(whole.litres, rel=1e-12)
    assert parts.kilometres == pytest.approx(whole.kilometres, rel=1e-12)
    assert parts.turns == pytest.approx(whole.turns, rel=1e-12)


def test_left_out_says_each_missing_sum_in_both_languages(tmp_path):
    (trip,) = trips(recorded(tmp_path / "a.pcapng", Session(steady(0, 20, flow=None))))
    assert list(left_out(trip)) == [NO_FUEL, NO_SPEED]
    road = [Road(float(at), 36.0) for at in range(51)]
    unit = [*steady(0, 30), *steady(60, 90)]
    (trip,) = trips(recorded(tmp_path / "b.pcapng", Session(unit, road)))
    fuel, speed, short = left_out(trip)
    assert "30 s of 90 s" in fuel.en
    assert "40 s of 90 s" in speed.en
    assert short is SHORT
    assert all(isinstance(each, Text) and each.ru for each in (fuel, speed))


@pytest.mark.parametrize("sign", [1, -1])
def test_a_way_over_the_180th_meridian_is_one_line(tmp_path, sign):
    """As that from Egvekinot: it was drawn around the Earth."""
    degrees = [179.999, 179.9995, 180.0, -179.9995, -179.999]
    road = [Road(1000.0 + at, 70, 66.0, sign * each) for at, each in enumerate(degrees)]
    unit = [Unit(1000.0 + at, rpm=2000) for at in range(5)]
    (way,) = way_of(recorded(tmp_path / "a.pcapng", Session(unit, road)), 0)
    step = 0.0005 * 111_195 * cos(radians(66))
    assert way.east.tolist() == pytest.approx([sign * step * at for at in range(5)], abs=0.01)
