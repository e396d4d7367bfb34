"""Pulls: exact power of a made one, what is no pull, and the virtual car's own engine."""

from __future__ import annotations

import re
from collections import defaultdict
from math import nan, pi
from pathlib import Path

import pytest
from drive_rig import Road, Session, Unit, recorded
from hypothesis import given
from hypothesis import strategies as st

import mikas
from mikas.drives.pulls import FULL_THROTTLE, PullSettings, pulls, rotating_factor
from mikas.errors import UsageError
from mikas.virtual.model.vehicle import MASS, RATIOS, WHEEL, Vehicle

GEAR = 24.0  # km/h at 1000 rpm


def rise(begin, low, high, seconds, throttle=100, rate=20):
    """Steps of 40 rpm, as the unit sends them."""
    count = round(seconds * rate)
    return [
        Unit(
            begin + at / rate,
            round((low + (high - low) * at / count) / 40) * 40,
            throttle=throttle,
        )
        for at in range(count + 1)
    ]


def expected(settings, rpm, rpm_per_second, per_1000=GEAR):
    speed = rpm * per_1000 / 3600
    acceleration = rpm_per_second * per_1000 / 3600
    rotating = settings.rotating or rotating_factor(per_1000)
    force = settings.mass * rotating * acceleration
    force += settings.mass * 9.81 * (settings.rolling + settings.slope)
    force += 0.6 * settings.drag_area * speed**2
    return force * speed / 1000


@pytest.mark.parametrize(
    "settings",
    [
        PullSettings(1600, GEAR),
        PullSettings(1200, GEAR, drag_area=0.6, slope=0.02),
        PullSettings(1600, GEAR, rolling=0.02, rotating=1.2),
    ],
)
def test_a_steady_rise_has_the_power_of_the_formula(tmp_path, settings):
    recording = recorded(tmp_path / "a.pcapng", Session(rise(1, 2000, 5000, 10)))
    (pull,) = pulls(recording, settings)
    assert (pull.speed_from, pull.per_1000, pull.slip) == ("FREQ", GEAR, 0.0)
    assert pull.end - pull.begin == pytest.approx(10, abs=0.2)
    assert len(pull.points) >= 10
    for point in pull.points:
        power = expected(settings, point.rpm, 300)
        assert point.power == pytest.approx(power, rel=0.02)
        assert point.torque == pytest.approx(1000 * power / (point.rpm * pi / 30), rel=0.02)
        assert point.speed == pytest.approx(point.rpm * GEAR / 1000, rel=0.01)
        assert 0.03 * power < point.doubt < 0.2 * power
        assert point.torque_doubt / point.torque == pytest.approx(point.doubt / point.power)
    assert pull.most_power == max(pull.points, key=lambda point: point.power)


def test_a_receiver_finds_the_gear_by_itself(tmp_path):
    road = [Road(at / 5, (2000 + 300 * (at / 5 - 1)) * GEAR / 1000) for at in range(5, 56)]
    recording = recorded(tmp_path / "a.pcapng", Session(rise(1, 2000, 5000, 10), road))
    (pull,) = pulls(recording, PullSettings(1600))
    assert pull.speed_from == "GPS_SPEED"
    assert pull.per_1000 == pytest.approx(GEAR, rel=0.02)
    assert pull.slip < 0.05
    for point in pull.points:
        assert point.power == pytest.approx(expected(PullSettings(1600), point.rpm, 300), rel=0.05)


def test_a_slipping_clutch_shows(tmp_path):
    road = [Road(at / 5, 60 + at / 5) for at in range(5, 56)]
    recording = recorded(tmp_path / "a.pcapng", Session(rise(1, 2000, 5000, 10), road))
    (pull,) = pulls(recording, PullSettings(1600))
    assert pull.slip > 0.3


def test_what_is_no_pull(tmp_path):
    for name, unit in enumerate((
        rise(1, 2000, 5000, 10, throttle=int(FULL_THROTTLE) - 1),
        rise(1, 2000, 2800, 10),  # too small a rise
        rise(1, 2000, 4000, 2),  # too short
        rise(1, 2000, 4000, 60),  # too slow: a hill, a tow
        rise(1, 5000, 2000, 10),
    )):  # fmt: skip
        recording = recorded(tmp_path / f"{name}.pcapng", Session(unit))
        assert pulls(recording, PullSettings(1600, GEAR)) == []


def test_a_change_of_gear_and_a_gap_make_two_pulls(tmp_path):
    both = [*rise(1, 2500, 5000, 5), *rise(6.5, 3200, 5000, 6)]
    found = pulls(recorded(tmp_path / "a.pcapng", Session(both)), PullSettings(1600, GEAR))
    assert [each.begin for each in found] == pytest.approx([1, 6.5], abs=0.15)
    gap = [*rise(1, 1600, 3000, 4), *rise(9, 4000, 5400, 4)]
    found = pulls(recorded(tmp_path / "b.pcapng", Session(gap)), PullSettings(1600, GEAR))
    assert [each.begin for each in found] == pytest.approx([1, 9], abs=0.15)


def test_a_pull_begins_where_the_speed_was_lowest(tmp_path):
    unit = [*rise(1, 3000, 2000, 4), *rise(5.1, 2000, 5000, 8)]
    (pull,) = pulls(recorded(tmp_path / "a.pcapng", Session(unit)), PullSettings(1600, GEAR))
    assert pull.begin == pytest.approx(5.1, abs=0.3)


def test_what_is_missing_is_said(tmp_path):
    recording = recorded(tmp_path / "a.pcapng", Session(rise(1, 2000, 5000, 10)))
    with pytest.raises(UsageError, match="--per-1000"):
        pulls(recording, PullSettings(1600))
    alone = recorded(tmp_path / "b.pcapng", Session([Unit(1.0, None, 1.0), Unit(2.0, None, 1.0)]))
    with pytest.raises(UsageError, match="FREQ: not in this recording"):
        pulls(alone, PullSettings(1600, GEAR))


@given(st.lists(st.tuples(st.integers(0, 150), st.integers(0, 100)), min_size=1, max_size=60))
def test_whatever_was_recorded_the_figures_are_finite(tmp_path_factory, told):
    unit = [Unit(at / 4, rpm * 40, throttle=throttle) for at, (rpm, throttle) in enumerate(told)]
    path = tmp_path_factory.mktemp("pulls") / "a.pcapng"
    for pull in pulls(recorded(path, Session(unit)), PullSettings(1600, GEAR)):
        assert pull.points
        assert pull.end > pull.begin
        assert all(point.power > 0 and point.doubt > 0 for point in pull.points)


SCENARIO = """
name = "pull"
duration = 40
text = { en = "A pull", ru = "Разгон" }
[start]
ambient = 20
coolant = 86
coolant_at_start = 86
running = true
[timeline]
key = 1
gear = [[0, 0], [2, 1], [6, 3], [40, 3]]
throttle = [[0, 0], [2, 30], [6, 20], [11, 20], [11.2, 100], [29, 100], [29.3, 0], [40, 0]]
"""


def test_the_virtual_engine_is_found_within_the_doubt(tmp_path, monkeypatch):
    """Its engine's torque, less what the drive takes, is what the wheels have."""
    (tmp_path / "pull.toml").write_text(SCENARIO, encoding="utf-8")
    made: dict[int, list[float]] = defaultdict(list)
    turn = Vehicle.turn

    def watched(self, omega, torque):
        if self.gear == 3 and self.throttle > 95:
            made[int(omega * 30 / pi / 250)].append(torque)
        return turn(self, omega, torque)

    monkeypatch.setattr(Vehicle, "turn", watched)
    path = Path(tmp_path / "a.pcapng")
    url = f"sim:?clock=simulated&seed=3&scenario={tmp_path / 'pull.toml'}"
    with mikas.session(
        url, ["FREQ", "THR"], record=path, duration=32, instruments=["nmea=sim:"]
    ) as session:
        for _ in session:
            pass
    per_1000 = 1000 * pi / 30 / RATIOS[3] * WHEEL * 3.6
    inertia = 1 + 0.26 * RATIOS[3] ** 2 * 0.93 / (MASS * WHEEL**2)
    car = {"drag_area": 1 / 1.2, "rotating": inertia}
    for settings in (PullSettings(MASS, per_1000, **car), PullSettings(MASS, **car)):
        (pull,) = pulls(mikas.open(path), settings)
        assert pull.per_1000 == pytest.approx(per_1000, rel=0.01)
        assert len(pull.points) > 8
        for point in pull.points[1:]:  # in the first one the throttle still opens
            torque = made[int(point.rpm / 250)]
            assert point.torque == pytest.approx(
                0.93 * sum(torque) / len(torque), abs=point.torque_doubt
            )


def test_wheels_that_spin_at_a_standstill_are_no_gear(tmp_path):
    """For most of the rise the car stands: the median of the gears is none."""
    road = [Road(at / 5, 0.0 if at < 40 else 30.0) for at in range(5, 56)]
    recording = recorded(tmp_path / "a.pcapng", Session(rise(1, 2000, 5000, 10), road))
    assert pulls(recording, PullSettings(1600)) == []


@pytest.mark.parametrize(
    ("figures", "said"),
    [
        (
            {"mass": 1.6},
            "load, kg: 1.6 is not possible; it must be from 400 to 20000",
        ),
        ({"mass": nan}, "Mass with driver and load, kg: nan is not possible"),
        ({"mass": 1600, "per_1000": 0.024}, "Speed at 1000 rpm, km/h: 0.024 is not possible"),
        ({"mass": 1600, "drag_area": 0}, "Drag area, m²: 0 is not possible"),
        ({"mass": 1600, "slope": -3}, "Slope, %: −300 is not possible; it must be from −30 to 30"),
    ],
)
def test_figures_that_no_car_has_are_refused(figures, said):
    with pytest.raises(UsageError, match=re.escape(said)):
        PullSettings(**figures)
