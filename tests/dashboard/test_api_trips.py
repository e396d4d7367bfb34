"""Trips in the dashboard: of a recording and of the running connection, with the way as a file."""

from __future__ import annotations

import pytest

from dashboard.recordings_rig import record
from dashboard.rig import rig
from drives.drive_rig import Road, Session, Unit, recorded

NAMES = ("FREQ", "JQT", "RXX", "VALF", "THR", "FILLING")
DRIVE = "sim:?scenario=city"
GPS = {"definition": "nmea", "port": "sim:"}
METER = {"definition": "aem", "port": "sim:"}


def folder_of(tmp_path):
    folder = tmp_path / "recordings"
    folder.mkdir()
    return folder


def north(at: int) -> float:
    """20 m a second."""
    return round(56 + at * 20 / 111_195, 6)


@pytest.fixture
def drive(tmp_path):
    """Two minutes: one standing, one at 72 km/h; a mark between them."""
    folder = folder_of(tmp_path)
    road = [Road(float(at), 0.0) for at in range(61)]
    road += [Road(float(at), 72.0, north(at - 60)) for at in range(61, 121)]
    unit = [Unit(float(at), 1200, 7.2) for at in range(121)]
    recorded(
        folder / "drive.pcapng", Session(unit, road, marks=[(60.5, "off we go"), (90.5, "half")])
    )
    with rig(tmp_path, None) as it:
        yield it


def test_a_recording_has_its_sums_its_way_and_its_marks(drive):
    found = drive.get("/recordings/drive.pcapng/trip")
    total = found["total"]
    assert found["count"] == 1
    assert found["trips"] == [total]
    assert total["seconds"] == pytest.approx(120, abs=0.1)
    assert total["litres"] == pytest.approx(7.2 * 120 / 3600, rel=1e-3)
    assert (total["litres_from"], total["highest_speed"]) == ("JQT", 72)
    assert total["kilometres"] == pytest.approx(1.19, abs=0.02)
    assert total["idle_seconds"] == pytest.approx(60, abs=1)
    assert total["litres_per_100_km"] == pytest.approx(
        100 * total["litres"] / total["kilometres"], rel=1e-3
    )
    assert [each["label"] for each in found["marks"]] == ["off we go", "half"]
    way = found["way"]
    assert (way["colour"], way["ends"]) == ("GPS_SPEED", [20, 40, 60, 90])
    assert {line["level"] for line in way["lines"]} <= {0, 3}
    assert max(max(line["north"]) for line in way["lines"]) == pytest.approx(1200, rel=0.01)
    assert found["mixture"] is None  # VALF was not recorded
    assert "FREQ" in found["channels"]


def test_since_a_mark_only_what_follows_counts_in_the_sums_the_way_and_the_file(drive):
    whole = drive.get("/recordings/drive.pcapng/trip")
    mark, half = whole["marks"]
    found = drive.get("/recordings/drive.pcapng/trip", since=mark["time"])
    assert found["total"]["begin"] == mark["time"]
    assert found["total"]["seconds"] == pytest.approx(59.5, abs=0.1)
    assert found["total"]["kilometres"] == pytest.approx(1.19, abs=0.02)
    points = [
        drive.get("/recordings/drive.pcapng/trip/gpx", **since).text.count("<trkpt ")
        for since in ({}, {"since": half["time"]})
    ]
    assert points == [60, 30]
    error = drive.get("/recordings/drive.pcapng/trip", 400, since=mark["time"] + 5)
    assert "there is no mark at that time" in error["en"]


def test_the_way_has_the_colour_of_a_chosen_channel(drive):
    way = drive.get("/recordings/drive.pcapng/trip", colour="GPS_LAT")["way"]
    assert len(way["ends"]) == 4
    assert sorted({line["level"] for line in way["lines"]}) == [0, 1, 2, 3, 4]
    way = drive.get("/recordings/drive.pcapng/trip", colour="FREQ")["way"]
    assert way["ends"] == []  # 1200 all the time
    assert {line["level"] for line in way["lines"]} == {0}
    assert {
        line["level"]
        for line in drive.get("/recordings/drive.pcapng/trip", colour="NOTHING")["way"]["lines"]
    } == {None}


def test_the_way_is_a_file_for_maps_with_its_values(drive):
    answer = drive.get("/recordings/drive.pcapng/trip/gpx", lang="ru")
    assert answer.headers["content-type"] == "application/gpx+xml"
    assert "drive.gpx" in answer.headers["content-disposition"]
    assert answer.text.count("<trkpt ") > 50
    assert "off we go" in answer.text
    drive.get("/recordings/drive.pcapng/trip/kml", 400)
    drive.get("/recordings/none.pcapng/trip/gpx", 404)
    drive.get("/recordings/none.pcapng/trip", 404)


def test_what_a_recording_lacks_is_said_with_what_to_do(tmp_path):
    folder = folder_of(tmp_path)
    record(folder / "plain.pcapng", "&scenario=warm-idle", count=200)
    recorded(folder / "still.pcapng", Session([Unit(float(at), 0) for at in range(20)]))
    recorded(folder / "unread.pcapng", Session([Unit(float(at), flow=5.0) for at in range(20)]))
    recorded(folder / "dry.pcapng", Session([Unit(float(at), 1200) for at in range(20)]))
    with rig(tmp_path, None) as it:
        found = it.get("/recordings/plain.pcapng/trip")
        assert found["way"] is None
        assert found["total"]["litres"] > 0
        assert any("no GPS beside the unit" in each["en"] for each in found["lacks"])
        assert any("Связь" in each["ru"] for each in found["lacks"])
        assert "no position" in it.get("/recordings/plain.pcapng/trip/gpx", 400)["en"]
        found = it.get("/recordings/still.pcapng/trip")
        assert (found["count"], found["total"]) == (0, None)
        found = it.get("/recordings/unread.pcapng/trip")
        assert found["total"] is None
        assert found["lacks"][0]["en"].startswith("FREQ: not in this recording")
        found = it.get("/recordings/dry.pcapng/trip")
        assert found["total"]["litres"] is None
        assert any("No litres" in it["en"] and "plan" in it["en"] for it in found["lacks"])


def test_a_meter_in_a_recording_is_compared_with_what_the_unit_aimed_at(tmp_path):
    folder = folder_of(tmp_path)
    unit = [Unit(at / 10, 2000, aimed=1.0, throttle=30) for at in range(600)]
    road = [Road(at / 10 + 0.03, 50.0, 56 + at / 1e6, lambda_=1.08) for at in range(600)]
    recorded(folder / "meter.pcapng", Session(unit, road))
    with rig(tmp_path, None) as it:
        (cell,) = it.get("/recordings/meter.pcapng/trip")["mixture"]["cells"]
        assert (cell["rpm"], cell["load"], cell["verdict"]) == ([1600, 2200], [20, 35], "leaner")
        assert cell["difference"] == pytest.approx(8, abs=0.5)


def values_of(it, *names):
    """Wait for values of all these channels."""

    def has(message):
        data = message.get("data")
        return data is not None and all(
            name in data["names"] and data["values"][data["names"].index(name)][-1] is not None
            for name in names
        )

    it.until(has)


def test_the_running_connection_has_a_trip_since_the_start_and_since_a_mark(tmp_path):
    with rig(tmp_path, DRIVE, names=NAMES) as it:
        it.sampling()
        it.post("/instruments", GPS)
        it.post("/instruments", METER)
        values_of(it, "GPS_SPEED", "LAMBDA")
        begin = it.dashboard.connection.now()
        it.until(lambda _: it.dashboard.connection.now() > begin + 40)
        whole = it.get("/trip")
        assert whole["total"]["litres"] > 0
        assert whole["total"]["seconds"] > 39
        assert whole["total"]["speed_seconds"] > 30
        assert whole["way"]["lines"]
        mark = it.post("/recording/marker", {"label": "corner"})["time"]
        it.until(lambda _: it.dashboard.connection.now() > begin + 60)
        found = it.get("/trip", since=mark, colour="FREQ")
        assert [each["time"] for each in found["marks"]] == [mark]
        assert found["total"]["begin"] == pytest.approx(mark, abs=1)
        assert found["total"]["seconds"] < it.get("/trip")["total"]["seconds"] - 30
        assert found["way"]["colour"] == "FREQ"
        assert found["mixture"]["load"] in ("FILLING", "THR")
        assert it.get("/trip/gpx").text.count("<trkpt ") > 30
        assert it.get("/trip/geojson", since=mark)["features"]


def test_of_the_running_connection_what_is_not_read_is_said(tmp_path):
    with rig(tmp_path, DRIVE, names=("TWAT",)) as it:
        it.sampling()
        found = it.get("/trip")
        assert found["total"] is None
        assert found["lacks"][0]["en"].startswith("FREQ: it is not read")
        it.get("/trip/gpx", 400)


def test_without_a_connection_there_is_no_trip(tmp_path):
    with rig(tmp_path, None) as it:
        it.get("/trip", 503)
        it.get("/trip/gpx", 503)


def test_a_pull_has_power_and_torque_with_their_doubt(tmp_path):
    """At 3 m/s² in a gear of 36 km/h at 1000 rpm: the power of the mass, of rolling and of air."""
    folder = folder_of(tmp_path)
    unit = [Unit(at / 10, 40 * round(50 + at * 0.75), throttle=90) for at in range(81)]
    recorded(folder / "pull.pcapng", Session(unit))
    record(folder / "idle.pcapng", "&scenario=warm-idle", count=100)
    with rig(tmp_path, None) as it:
        asked = {"mass": 1000, "per_1000": 36}
        (pull,) = it.get("/recordings/pull.pcapng/pulls", **asked)["pulls"]
        assert (pull["speed_from"], pull["per_1000"], pull["slips"]) == ("FREQ", 36, False)
        point = min(pull["points"], key=lambda each: abs(each["rpm"] - 3500))
        speed = point["speed"] / 3.6
        rotating = 1.04 + 0.0025 * (1000 * 3.14159 / 30 * 0.31 / 10) ** 2
        watts = speed * (1000 * (rotating * 3 + 9.81 * 0.014) + 0.54 * speed**2)
        assert point["power"] == pytest.approx(watts / 1000, rel=0.05)
        assert 0 < point["doubt"] < point["power"] / 5
        assert point["torque_doubt"] / point["torque"] == pytest.approx(
            point["doubt"] / point["power"], rel=0.05
        )
        heavy = it.get("/recordings/pull.pcapng/pulls", mass=2000, per_1000=36)["pulls"][0]
        assert max(p["power"] for p in heavy["points"]) > max(p["power"] for p in pull["points"])
        assert it.get("/recordings/idle.pcapng/pulls", **asked)["pulls"] == []
        error = it.get("/recordings/pull.pcapng/pulls", 400, mass=1000)
        assert "speed at 1000 rpm" in error["en"]
        tonnes = it.get("/recordings/pull.pcapng/pulls", 400, mass=1.6, per_1000=36)
        assert "from 400 to 20000" in tonnes["en"]
        it.get("/recordings/none.pcapng/pulls", 404, **asked)
