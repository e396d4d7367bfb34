"""The way as lines: what is thinned away, what has which level, and that nothing is lost."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from drive_rig import Road, Session, Unit, recorded
from hypothesis import given
from hypothesis import strategies as st

from mikas.drives.overview import overview_of_live, overview_of_recording
from mikas.drives.way_lines import SPEEDS, level_ends, way_lines
from mikas.drives.ways import WayStretch, way_since
from mikas.recording.table.channels import Rows
from mikas.sampling.events import Marker

METRES = st.floats(-5000, 5000)
PLACES = st.lists(st.tuples(METRES, METRES, st.floats(0, 150) | st.just(np.nan)), min_size=2)


def stretch(places) -> WayStretch:
    east, north, values = (np.array(each) for each in zip(*places, strict=True))
    return WayStretch(np.arange(len(places)) * 1.0, east, north, values)


@given(PLACES, st.floats(0.1, 50))
def test_lines_join_keep_both_ends_and_every_place_is_near_one(places, near):
    lines = list(way_lines([stretch(places)], SPEEDS, near))
    drawn = [point for line in lines for point in line.points]
    assert drawn[0] == places[0][:2]
    assert drawn[-1] == places[-1][:2]
    assert all(before.points[-1] == after.points[0] for before, after in pairwise(lines))
    for east, north, _ in places:
        assert min(max(abs(east - e), abs(north - n)) for e, n in drawn) < near + 1e-9
    assert all(line.level is None or 0 <= line.level <= len(SPEEDS) for line in lines)


def test_levels_are_of_equal_height_and_one_value_has_none():
    way = [stretch([(0, 0, 10.0), (1, 0, np.nan), (2, 0, 60.0)])]
    assert level_ends(way) == (20, 30, 40, 50)
    assert level_ends([stretch([(0, 0, 7.0), (1, 0, 7.0)])]) == ()
    assert level_ends([]) == ()


def test_sessions_of_a_file_have_one_home_and_a_mark_cuts_both(tmp_path):
    def session(begin: int, latitude: float) -> Session:
        times = [float(at) for at in range(begin, begin + 21)]
        road = [Road(at, 36.0, round(latitude + at / 10_000, 6)) for at in times]
        return Session([Unit(at, 1200) for at in times], road)

    recording = recorded(tmp_path / "a.pcapng", session(0, 56), session(100, 56.01))
    one, two = way_since(recording, {})
    assert float(one.north[0]) == 0
    assert float(two.north[0]) == pytest.approx(0.02 * 111_195, rel=1e-6)
    (cut,) = way_since(recording, {}, Marker(110.5, recording=1))
    assert float(cut.times[0]) > 110.5
    assert (float(cut.north[0]), float(cut.north[-1])) == (0, pytest.approx(9 * 11.1195, abs=0.1))
    found = overview_of_recording(recording, colour="FREQ")
    assert found.way.ends == ()
    assert {line.level for line in found.way.lines} == {0}


@given(st.integers(1, 8))
def test_rows_of_a_running_connection_give_the_places_once_whatever_their_rate(rate):
    times = np.arange(60 * rate) / rate + 1000
    second = np.floor(times) - 1000
    rows = Rows(
        times,
        {
            "FREQ": times * 0 + 2000,
            "JQT": times * 0 + 7.2,
            "GPS_LAT": 56 + second * 10 / 111_195,
            "GPS_LON": times * 0 + 44,
            "GPS_SPEED": times * 0 + 36,
        },
    )
    found = overview_of_live(rows)
    (line,) = found.way.lines
    assert len(line.points) == 60
    assert line.points[-1][1] == pytest.approx(590)
    (trip,) = found.trips
    assert trip.seconds == pytest.approx(60, abs=1)
    assert trip.litres == pytest.approx(7.2 * trip.seconds / 3600)
    assert trip.kilometres == pytest.approx(trip.seconds / 100)
    later = overview_of_live(rows, 1030.0)
    assert later.trips[0].begin == 1030
    assert len(later.way.lines[0].points) == 30
    assert later.way.lines[0].points[0] == (0, 0)


def test_rows_without_a_receiver_or_the_engines_speed_say_so():
    found = overview_of_live(Rows(np.arange(5) * 1.0, {"TWAT": np.arange(5) * 1.0}))
    assert (found.trips, found.way, found.mixture) == ([], None, None)
    assert "FREQ" in found.why.en
    found = overview_of_live(Rows(np.zeros(0), {"FREQ": np.zeros(0)}))
    assert (found.trips, found.why, found.way) == ([], None, None)
