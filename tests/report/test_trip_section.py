"""The report's section of the trip: its table, and the way drawn on its own grid."""

from __future__ import annotations

import re
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_harness import found

from drives.drive_rig import Road, Session, Unit, recorded
from mikas.drives.ways import WayStretch, way_of
from mikas.report.from_recording import find_in_recording
from mikas.report.page import render
from mikas.report.sections.drive import drive_section
from mikas.report.way_drawing import LEAST_HEIGHT, MOST_HEIGHT, WIDTH, way_drawing

NAN = float("nan")


def unit(begin, end):
    return [Unit(float(at), 1200, 7.2) for at in range(begin, end + 1)]


def east(begin, end, speed=36.0):
    """To the east, 62 m a second."""
    return [Road(at + 0.5, speed, 56.0, 44 + at / 1000) for at in range(begin, end)]


def test_the_section_has_a_row_a_drive_the_total_and_the_way(tmp_path):
    told = [*unit(0, 120), Unit(121.0, 0, 0.0), *unit(130, 140)]
    recording = recorded(tmp_path / "a.pcapng", Session(told, east(0, 140)))
    page = render(find_in_recording(recording), "en")
    assert "<h2>Trip</h2>" in page
    rows = re.findall(r"<tr><td>(.*?)</tr>", page.split("<h2>Trip</h2>")[1])
    cells = [re.sub("<.*?>", "|", row).replace("||", "|").strip("|").split("|") for row in rows[:3]]
    assert [row[3:] for row in cells] == [
        ["0.24", "1.2", "20.0", "36 (36)"], ["0.02", "0.1", "–", "36 (36)"],
        ["0.26", "1.3", "20.0", "36 (36)"],
    ]  # fmt: skip
    assert cells[2][0] == "All 2"
    assert '<svg class="track"' in page
    assert "http" not in page.split('<svg class="track"')[1].split("</svg>")[0]
    russian = render(find_in_recording(recording), "ru")
    assert "<h2>Поездка</h2>" in russian
    assert "Все 2" in russian


def test_a_recording_without_a_receiver_has_no_such_section(tmp_path):
    recording = recorded(tmp_path / "a.pcapng", Session(unit(0, 20)))
    assert find_in_recording(recording).subject.drive is None
    assert drive_section(found(), "en") is None


def test_a_stopped_engine_leaves_the_way_and_no_speed_of_the_engine_no_row(tmp_path):
    road = east(0, 30)
    for name, told in (
        ("a", [Unit(float(at), 0, 0.0) for at in range(30)]),
        ("b", [Unit(float(at), None, 1.0) for at in range(30)]),
    ):
        recording = recorded(tmp_path / f"{name}.pcapng", Session(told, road))
        section = drive_section(find_in_recording(recording), "en")
        assert "<table>" not in section.body
        assert '<svg class="track"' in section.body


def test_the_way_is_in_metres_and_interrupted_where_the_receiver_was_silent(tmp_path):
    road = [*east(0, 10), *east(40, 50), Road(70.0, 0.0, 56.0, 44.0)]
    recording = recorded(tmp_path / "a.pcapng", Session(unit(0, 80), road))
    first, second = way_of(recording, 0)
    assert len(first.times) == len(second.times) == 10
    assert float(first.east[0]) == 0.0
    assert np.diff(first.east) == pytest.approx([111.195 * np.cos(np.radians(56))] * 9, rel=1e-6)
    assert np.abs(first.north).max() == 0.0
    assert first.values.tolist() == [36.0] * 10
    assert way_of(recording, 1) == []


_metres = st.floats(-2e6, 2e6) | st.floats(-1, 1)
_place = st.tuples(_metres, _metres, st.floats(0, 300) | st.just(NAN))
_way = st.lists(st.lists(_place, min_size=2, max_size=40), min_size=1, max_size=4)


@given(_way)
def test_whatever_the_way_the_drawing_holds_it(places):
    way = [
        WayStretch(np.arange(len(each)) * 1.0, *map(np.array, zip(*each, strict=True)))
        for each in places
    ]  # fmt: skip
    drawing = ET.fromstring(str(way_drawing(way, "en", 'a <b> "c"')))
    assert drawing.find("title").text == 'a <b> "c"'
    _, _, width, height = map(float, drawing.attrib["viewBox"].split())
    assert width == WIDTH
    assert LEAST_HEIGHT <= height <= MOST_HEIGHT + 50
    for path in drawing.iter("path"):
        for x, y in re.findall(r"(-?[\d.]+) (-?[\d.]+)", path.attrib["d"]):
            assert -1 <= float(x) <= width + 1
            assert -1 <= float(y) <= height + 1
    grid = [each for each in drawing.iter("line") if each.attrib["class"] == "grid"]
    assert 4 <= len(grid) <= 30


def test_the_colour_is_the_speed_and_a_long_way_stays_small():
    speeds = np.array([10.0, 10, 30, 30, 50, 70, 100, 100, NAN, NAN])
    at = np.arange(10.0)
    drawn = str(way_drawing([WayStretch(at, at * 100, at * 0, speeds)], "en", ""))
    assert re.findall('class="way (.*?)"', drawn) == [
        "speed0", "speed1", "speed2", "speed3", "speed4", "unknown",
    ]  # fmt: skip
    at = np.arange(100_000.0)
    slow = WayStretch(at, np.sin(at / 9000) * 9000, np.cos(at / 9000) * 9000, at * 0 + 50)
    assert len(str(way_drawing([slow], "en", ""))) < 60_000
