"""The way of the car as GPX and GeoJSON: places, values, interruptions, marks."""

from __future__ import annotations

import json
from itertools import pairwise
from xml.etree import ElementTree as ET

import pytest
from export_tables import NAN, START, rows
from hypothesis import given
from hypothesis import strategies as st

from drives.drive_rig import Road, Session, Unit, recorded
from mikas.errors import ExportError
from mikas.i18n import Text
from mikas.recording.export import TRACKS, export, with_position
from mikas.recording.export import sheet as sheets
from mikas.recording.table.channels import Channel
from mikas.sampling.events import Gap, Marker

NAMES = ("FREQ", "GPS_LAT", "GPS_LON", "GPS_ALT", "GPS_SPEED", "GPS_COURSE")
CHANNELS = [Channel(name, "", Text(f"<{name}>", f"«{name}» & ко")) for name in NAMES]
GPX = "{http://www.topografix.com/GPX/1/1}"
OWN = "{https://github.com/mikas-diagnostics/mikas}"
GARMIN = "{http://www.garmin.com/xmlschemas/TrackPointExtension/v2}"


def way(times, places, *, rpm=None, start=START):
    """Rows at the times; of a place that is None the position is missing."""
    return rows(
        [start + time for time in times],
        FREQ=rpm or [800.0 + 40 * n for n in range(len(times))],
        GPS_LAT=[NAN if place is None else 56 + place / 1000 for place in places],
        GPS_LON=[NAN if place is None else 44 + place / 500 for place in places],
        GPS_ALT=[NAN if place is None else 84.5 for place in places],
        GPS_SPEED=[NAN if place is None else 36.0 for place in places],
        GPS_COURSE=[NAN if place is None else 360.0 for place in places],
    )


def gpx(tmp_path, pieces, **options):
    out = tmp_path / "a.gpx"
    export(out, CHANNELS, pieces, overwrite=True, **options)
    return ET.parse(out).getroot()


def geojson(tmp_path, pieces, **options):
    out = tmp_path / "a.geojson"
    export(out, CHANNELS, pieces, overwrite=True, **options)
    return json.loads(out.read_text("utf-8"))


def test_a_gpx_has_each_new_place_with_its_time_and_the_values_of_then(tmp_path):
    pieces = [way([0, 0.5, 1.0, 1.25], [0, 0, 1, 1], rpm=[800, 840, NAN, 880])]
    found = gpx(tmp_path, pieces, about={"recording": "a <b> & c"}, language="ru")
    assert found.findtext(f"{GPX}metadata/{GPX}name") == "a <b> & c"
    assert found.findtext(f"{GPX}metadata/{GPX}time") == "2023-11-14T22:13:20.000Z"
    assert "FREQ: «FREQ» & ко" in found.findtext(f"{GPX}trk/{GPX}desc")
    first, second = found.iter(f"{GPX}trkpt")
    assert first.attrib == {"lat": "56", "lon": "44"}
    assert second.attrib == {"lat": "56.001", "lon": "44.002"}
    assert [each.findtext(f"{GPX}time") for each in (first, second)] == [
        "2023-11-14T22:13:20.000Z", "2023-11-14T22:13:21.000Z",
    ]  # fmt: skip
    values = second.find(f"{GPX}extensions")
    assert second.findtext(f"{GPX}ele") == "84.5"
    assert values.findtext(f"{OWN}FREQ") == "840"  # of half a second before
    garmin = values.find(f"{GARMIN}TrackPointExtension")
    assert garmin.findtext(f"{GARMIN}speed") == "10.000"  # m/s
    assert garmin.findtext(f"{GARMIN}course") == "0.0"


def test_a_value_holds_for_a_second_and_no_longer(tmp_path):
    pieces = [way([0, 1.0, 2.5], [0, 1, 2], rpm=[800, NAN, NAN])]
    points = list(gpx(tmp_path, pieces).iter(f"{OWN}FREQ"))
    assert [each.text for each in points] == ["800", "800"]


def test_the_line_is_interrupted_by_a_gap_a_pause_and_a_missing_place(tmp_path):
    pieces = [
        way([0, 1, 2, 3, 4], [0, 1, None, 2, 3]),
        way([20, 21, 22, 25, 26], [4, 5, 6, 7, 8]),
        way([10, 11], [9, 10]),  # another session, whose clock is behind
    ]
    gap = Gap(START + 25, START + 22, START + 25, Text("no answer", "нет ответа"))
    found = geojson(tmp_path, pieces, events=[gap])
    lines = [
        each for each in found["features"] if each["geometry"]["type"] == "LineString"
    ]  # fmt: skip
    began = [[place[1] for place in each["geometry"]["coordinates"]] for each in lines]
    assert [[round((at - 56) * 1000) for at in line] for line in began] == [
        [0, 1], [2, 3], [4, 5, 6], [7, 8], [9, 10],
    ]  # fmt: skip
    assert lines[2]["properties"] == {
        "begin": {"time": "2023-11-14T22:13:40.000Z", "seconds": 20.0},
        "end": {"time": "2023-11-14T22:13:42.000Z", "seconds": 22.0},
    }
    segments = gpx(tmp_path, pieces, events=[gap]).iter(f"{GPX}trkseg")
    assert [len(list(each)) for each in segments] == [2, 2, 3, 2, 2]


def test_a_geojson_has_points_with_their_values(tmp_path):
    found = geojson(tmp_path, [way([0, 1], [0, 1])], about={"unit": "Mikas 7.1"})
    assert (found["type"], found["about"]) == ("FeatureCollection", {"unit": "Mikas 7.1"})
    assert found["channels"]["FREQ"]["ru"] == "«FREQ» & ко"
    point = found["features"][1]
    assert point["geometry"] == {"type": "Point", "coordinates": [44.002, 56.001, 84.5]}
    assert point["properties"] == {
        "time": "2023-11-14T22:13:21.000Z", "seconds": 1.0, "FREQ": 840.0, "GPS_SPEED": 36.0,
        "GPS_COURSE": 360.0,
    }  # fmt: skip


def test_a_clock_without_a_date_gives_no_time(tmp_path):
    pieces = [way([0, 1], [0, 1], start=5.0)]
    assert not list(gpx(tmp_path, pieces).iter(f"{GPX}time"))
    assert geojson(tmp_path, pieces)["features"][1]["properties"]["time"] is None


def test_a_mark_stands_at_the_nearest_place_within_ten_seconds(tmp_path):
    pieces = [way([0, 4, 8], [0, 1, 2])]
    events = [
        Marker(START + 1, "near <0>"), Marker(START + 3, "near 1"), Marker(START + 17, "near 2"),
        Marker(START + 19, "far"),
    ]  # fmt: skip
    marks = list(gpx(tmp_path, pieces, events=events).iter(f"{GPX}wpt"))
    assert [(each.findtext(f"{GPX}name"), each.attrib["lat"]) for each in marks] == [
        ("near <0>", "56"), ("near 1", "56.001"), ("near 2", "56.002"),
    ]  # fmt: skip
    found = geojson(tmp_path, pieces, events=events)["features"]
    texts = [each["properties"]["text"]["en"] for each in found if "kind" in each["properties"]]
    assert texts == ["near <0>", "near 1", "near 2"]


@pytest.mark.parametrize("suffix", TRACKS)
def test_without_a_position_it_says_what_is_needed_and_leaves_no_file(tmp_path, suffix):
    out = tmp_path / f"a{suffix}"
    for channels, pieces, reason in (
        (CHANNELS[:1], [way([0], [0])], "--instrument nmea=PORT"),
        (CHANNELS, [way([0, 1], [None, None])], "the GPS had not found its place"),
        (CHANNELS, [], "there is a GPS, but no response of the unit"),
    ):
        with pytest.raises(ExportError, match=reason) as caught:
            export(out, channels, pieces)
        assert str(out) in str(caught.value)
        assert not list(tmp_path.iterdir())


@given(
    steps=st.lists(st.tuples(st.integers(0, 120), st.none() | st.integers(0, 4)), min_size=1,
                   max_size=40),
    cuts=st.sets(st.integers(1, 39)),
    batch=st.integers(1, 9),
)  # fmt: skip
def test_how_the_rows_come_changes_nothing(tmp_path_factory, steps, cuts, batch):
    if all(place is None for _, place in steps):
        return
    folder = tmp_path_factory.mktemp("tracks")
    times = [sum(step for step, _ in steps[: n + 1]) / 10 for n in range(len(steps))]
    places = [place for _, place in steps]
    edges = [0, *sorted(cut for cut in cuts if cut < len(steps)), len(steps)]
    rpm = [NAN if n % 3 else 800.0 + 40 * n for n in range(len(steps))]
    whole = geojson(folder, [way(times, places, rpm=rpm)])
    pieces = [
        way(times[a:b], places[a:b], rpm=rpm[a:b]) for a, b in pairwise(edges)
    ]  # fmt: skip
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sheets, "BATCH", batch)
        assert geojson(folder, pieces) == whole
    points = [each for each in whole["features"] if each["geometry"]["type"] == "Point"]
    expected, last = [], None
    for n, place in enumerate(places):
        if place is None or (n and times[n] - times[n - 1] > 10):
            last = None
        if place is not None and place != last:
            expected.append(times[n] - times[0])
            last = place
    assert [each["properties"]["seconds"] for each in points] == pytest.approx(expected, abs=1e-3)


def test_named_channels_of_a_recording_get_its_position_too(tmp_path):
    road = [Road(float(at), 36.0, 56 + at / 1000, 44.0) for at in range(10)]
    unit = [Unit(at + 0.5, 1200, 7.2) for at in range(10)]
    recording = recorded(tmp_path / "a.pcapng", Session(unit, road))
    assert with_position(recording, []) == []
    assert with_position(recording, ["JQT"]) == ["JQT", "GPS_SPEED", "GPS_LAT", "GPS_LON"]
    chosen = recording.interpreted("corrected", with_position(recording, ["JQT"]))
    out = tmp_path / "a.gpx"
    assert export(out, chosen.channels, chosen.rows()).rows == 10
    points = list(ET.parse(out).getroot().iter(f"{GPX}trkpt"))
    assert len(points) == 10
    assert float(points[3].attrib["lat"]) == pytest.approx(56.003)
    assert points[3].findtext(f"{GPX}extensions/{OWN}JQT") == "7.2"
