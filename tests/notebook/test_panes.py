"""The panes of a plot are those of the dashboard's chart: channels, colours, axes, times."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from mikas.catalog import shipped
from mikas.i18n import Text
from mikas.notebook.panes import DAY, FIRST, MOST, NIGHT, by_unit, coloured, first_panes
from mikas.notebook.time_axis import elapsed, round_times, step_of, time_of_day
from mikas.notebook.value_axes import AxisLine, Scale, axes_of, scale_of, stacked_axes
from mikas.recording.table.channels import Channel

WEB = Path(__file__).parents[2] / "web" / "src"
CHART = WEB / "screens" / "chart" / "time"


def channel(name):
    each = shipped().channel(name)
    return Channel(name, each.unit, each.text, each.is_flag, each.decimals)


def names(panes):
    return [[each.name for each in pane] for pane in panes]


def test_the_first_panes_are_those_of_the_page():
    source = (CHART / "view.svelte.ts").read_text("utf-8")
    assert json.loads(re.search(r"FIRST: string\[\]\[\] = (.*);", source)[1]) == list(
        map(list, FIRST)
    )
    assert int(re.search(r"MOST_PANES = (\d+);", source)[1]) == MOST


@pytest.mark.parametrize(("theme", "palette"), [("day", DAY), ("night", NIGHT)])
def test_the_colours_are_those_of_the_page(theme, palette):
    css = (WEB / "styles" / "tokens.css").read_text("utf-8")
    block = css.split(f':root[data-theme="{theme}"] {{')[1].split("}")[0]
    tokens = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", block))
    assert palette.traces == tuple(tokens[f"trace-{number}"] for number in range(1, 9))
    assert (palette.text, palette.muted, palette.hatch, palette.warning, palette.danger) == tuple(
        tokens[name] for name in ("text", "muted", "strong-line", "warning", "danger")
    )


def test_only_what_is_recorded_is_drawn():
    recorded = [channel(name) for name in ("UOZ", "FREQ", "INJ", "RXX")]
    assert names(first_panes(recorded)) == [["FREQ"], ["INJ"], ["UOZ"]]
    others = [channel(name) for name in ("TAIR", "RXX", "VALF", "TWATI", "DET", "RCOD")]
    assert names(first_panes(others)) == [["TAIR", "TWATI"], ["RXX", "DET"], ["VALF"], ["RCOD"]]
    assert first_panes([]) == []


def test_by_unit_every_channel_is_in_one_pane():
    channels = [
        Channel(each.name, each.unit, each.text, each.is_flag) for each in shipped().parameters
    ]
    panes = by_unit(channels)
    assert sorted(each for pane in names(panes) for each in pane) == sorted(
        each.name for each in channels
    )
    for pane in panes:
        assert len({(each.unit, each.is_flag) for each in pane}) == 1


def test_colours_go_on_through_the_panes():
    text = Text("", "")
    panes = coloured([[Channel(str(n), "", text) for n in range(5)]] * 2)
    assert [trace.colour for pane in panes for trace in pane] == [0, 1, 2, 3, 4, 5, 6, 7, 0, 1]


def test_the_axes_are_those_of_the_page():
    cases = json.loads((WEB / "lib" / "series" / "valueAxis.test.json").read_text("utf-8"))
    assert len(cases) > 50
    for case in cases:
        lines = [
            AxisLine(
                Scale(
                    it["name"],
                    it["unit"] or f"own {it['name']}",
                    it["flag"],
                    it["span_least"] or 10.0,
                    it["lowest"] is None or it["lowest"] >= 0,
                ),
                it["seen"] and (it["seen"]["min"], it["seen"]["max"]),
                it["band"] and tuple(it["band"]),
            )
            for it in case["lines"]
        ]
        for axis, wanted in zip(axes_of(lines), case["axes"], strict=True):
            assert axis.low == pytest.approx(wanted["low"], abs=1e-9), case
            assert axis.high == pytest.approx(wanted["high"], abs=1e-9), case
            assert axis.floor == wanted["floor"], case


def test_a_scale_is_what_the_catalog_says():
    coolant = scale_of(shipped().channel("TWAT"), "°C")
    assert (coolant.least_span, coolant.never_negative) == (20, False)
    assert scale_of(shipped().channel("FREQ"), "rpm").never_negative
    assert scale_of(shipped().channel("FUEL_FLOW"), "l/h").never_negative
    assert scale_of(shipped().channel("RXX"), "own RXX").is_flag
    labelled = shipped().described("GPS_SPEED_ROOF")
    assert (labelled.name, scale_of(labelled, "km/h").least_span) == ("GPS_SPEED", 10)
    assert shipped().described("BOOST_BAR") is None
    own = scale_of(Channel("BOOST_BAR", "bar", Text("Boost", "Наддув"), decimals=2), "bar")
    assert (own.least_span, own.never_negative) == (pytest.approx(0.1), False)


def test_stacked_lines_have_lanes_from_the_top():
    scales = [Scale("A", "x"), Scale("B", "x"), Scale("C", "own C", is_flag=True)]
    seen = [(0.0, 100.0), (5.0, 5.0), (0.0, 1.0)]
    axes = stacked_axes([AxisLine(*both) for both in zip(scales, seen, strict=True)])
    for lane, (axis, (low, high)) in enumerate(zip(axes, seen, strict=True)):
        for value in (low, high):
            height = (value - axis.low) / (axis.high - axis.low)
            assert (2 - lane) / 3 < height < (3 - lane) / 3


def test_the_labels_of_time_are_those_of_the_page():
    for case in json.loads((CHART / "plot" / "timeAxis.test.json").read_text("utf-8")):
        begin, end, zero = case["from"], case["to"], case["zero"]
        times = round_times(begin, end, zero)
        assert times == pytest.approx([label["time"] for label in case["labels"]])
        step = step_of(begin, end)
        texts = [elapsed(time - zero, step, "en") for time in times]
        assert texts == [label["text"] for label in case["labels"]]


def test_times_of_day_have_the_parts_that_their_step_needs():
    noon = 1_700_000_000.25
    assert re.fullmatch(r"\d\d:\d\d", time_of_day(noon, 60, "en"))
    assert re.fullmatch(r"\d\d:\d\d:20", time_of_day(noon, 5, "en"))
    assert re.fullmatch(r"\d\d:\d\d:20,2", time_of_day(noon, 0.1, "ru"))
    assert re.fullmatch(r"\d\d:\d\d:20\.250", time_of_day(noon, 0.05, "en"))
    assert time_of_day(1e300, 1, "en") == ""
