"""Scatter and Table: a recording with known values has the known statistics; a click leads to the
moments; two recordings are compared.
"""

from __future__ import annotations

import json
import re
from statistics import fmean, stdev

import pytest
from playwright.sync_api import expect

import mikas
from browser.rig import CAR, dashboard
from mikas.catalog import shipped
from mikas.recording import CaptureWriter

NAMES = ("TWAT", "JAIR", "UACC", "RXX")
CHOICE = {
    "table": {"x": "TWAT", "y": "UACC", "value": "JAIR"},
    "scatter": {"x": "TWAT", "y": "JAIR", "colour": "RXX"},
    "least": 1,
    "edges": {"TWAT": [50, 60, 80, 90], "UACC": [13, 14]},
}


def _drive(path, scenario, phases):
    """A recording of 3 s with each of the coolant's and the air's raw values."""
    url = f"sim:?clock=simulated&scenario={scenario}"
    known = shipped()
    with CaptureWriter(path, url=url) as sink, mikas.connect(url, sink=sink) as ecu:
        link = ecu.tester.link
        for coolant, air in phases:
            car = link.link.bus.ecu.responder.car
            car.write(known.parameter("TWAT").code, bytes([coolant + 40]))
            car.write(known.parameter("JAIR").code, (100 * air).to_bytes(2, "little"))
            until = link.now() + 3
            for _ in ecu.watch(*NAMES, method="batch"):
                if link.now() >= until:
                    break


@pytest.fixture(scope="module")
def drives(chromium, tmp_path_factory):
    folder = tmp_path_factory.mktemp("cells")
    recordings = folder / "recordings"
    recordings.mkdir()
    scenario = folder / "still.toml"
    scenario.write_text(CAR, "utf-8")
    _drive(recordings / "mine.pcapng", scenario, ((55, 10), (87, 20), (55, 12), (87, 20)))
    _drive(recordings / "other.pcapng", scenario, ((55, 30), (87, 17)))
    with dashboard(folder, begin=False) as dash:
        yield dash


def _opened(drives, visitor, **wishes):
    tab = visitor(drives.url, **wishes).show("recordings")
    tab.page.evaluate("text => localStorage.setItem('mikas.pairs', text)", json.dumps(CHOICE))
    tab.page.reload()
    tab.find("tr", has_text="mine.pcapng").get_by_role("button", name="Open").click()
    expect(tab.value("TWAT")).to_have_text("55")
    return tab


def _view(tab, name):
    tab.show("chart")
    tab.page.get_by_role("tab", name=name).click()


def _cell(tab, words):
    return tab.page.get_by_role("button", name=re.compile(rf"Coolant temperature, °C {words}, "))


def _measured(drives):
    """The readings by coolant: from the API, not from the page."""
    rows = drives.get("/recordings/mine.pcapng/rows?points=20000")
    columns = dict(zip(rows["names"], rows["values"], strict=True))
    cold = [
        air for air, coolant in zip(columns["JAIR"], columns["TWAT"], strict=True) if coolant == 55
    ]
    return cold, len(rows["times"]) - len(cold)


def test_a_cell_has_the_statistics_of_its_readings(drives, visitor):
    tab = _opened(drives, visitor)
    _view(tab, "Table")
    cold, warm = _measured(drives)
    expect(_cell(tab, "50–60")).to_contain_text(f"{fmean(cold):.2f}")
    expect(_cell(tab, "50–60").locator("small")).to_have_text(str(len(cold)))
    expect(_cell(tab, "80–90")).to_contain_text("20.00")
    expect(_cell(tab, "80–90").locator("small")).to_have_text(str(warm))
    expect(_cell(tab, "60–80")).to_be_disabled()
    statistic = tab.page.get_by_label("Statistic")
    for name, value in (
        ("lowest", "10.0"),
        ("highest", "12.0"),
        ("deviation σ", f"{stdev(cold):.2f}"),
    ):
        statistic.select_option(name)
        expect(_cell(tab, "50–60").locator("b")).to_have_text(value)
    least = tab.page.get_by_label("Readings that a cell needs")
    least.fill(str(len(cold) + 1))
    expect(_cell(tab, "50–60").locator("b")).to_have_text("–")
    least.fill("0")
    expect(least).to_have_attribute("aria-invalid", "true")
    statistic.select_option("mean")
    tab.page.get_by_role("button", name="Edges of Coolant").click()
    sheet = tab.page.get_by_role("dialog")
    sheet.get_by_label("Edges, ascending").fill("50 100")
    sheet.get_by_role("button", name="Apply").click()
    expect(_cell(tab, "50–100").locator("small")).to_have_text(str(len(cold) + warm))


def test_a_click_on_a_cell_leads_to_its_moments(drives, visitor):
    tab = _opened(drives, visitor)
    _view(tab, "Table")
    _cell(tab, "80–90").focus()
    tab.page.keyboard.press("ArrowLeft")  # over the empty cell between
    tab.page.keyboard.press("Enter")
    group = tab.page.get_by_role("group", name="Found moments")
    expect(group).to_contain_text("1 of 2")
    expect(tab.traced("TWAT")).to_have_text("55")
    expect(tab.traced("JAIR")).to_have_text("10.0")
    expect(tab.find(".pane .band")).to_have_count(4 * 3)  # two, and the current one's edge
    tab.page.keyboard.press("j")
    expect(group).to_contain_text("2 of 2")
    expect(tab.traced("JAIR")).to_have_text("12.0")
    tab.page.keyboard.press("j")
    expect(tab.traced("JAIR")).to_have_text("10.0")
    tab.page.keyboard.press("c")  # the second cursor stays, the first one moves: a selection
    tab.page.keyboard.press("Shift+ArrowRight")
    group.get_by_role("link", name="Back to the table").click()
    tab.says("between the cursors")
    tab.press("Use all")
    tab.says("all of the recording")


def test_a_point_of_the_cloud_leads_to_its_moment(drives, visitor):
    tab = _opened(drives, visitor)
    _view(tab, "Scatter")
    cold, warm = _measured(drives)
    plot = tab.page.get_by_role("application", name="Cloud of points")
    expect(plot).to_have_attribute("data-points", str(len(cold) + warm))
    box = plot.bounding_box()
    # The only points in the upper right corner are those of 87 °C and 20 kg/h.
    tab.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + 41)
    tab.page.mouse.down()
    for x, y in ((1, 41), (1, 120), (0.5, 120)):
        tab.page.mouse.move(box["x"] + box["width"] * x - 5, box["y"] + y)
    tab.page.mouse.up()
    group = tab.page.get_by_role("group", name="Found moments")
    expect(group).to_contain_text("1 of 2")
    expect(tab.traced("TWAT")).to_have_text("87")
    expect(tab.traced("JAIR")).to_have_text("20.0")
    group.get_by_role("link", name="Back to the cloud").click()
    expect(plot).to_have_attribute("data-points", str(len(cold) + warm))
    plot.focus()
    tab.page.keyboard.press("ArrowLeft")
    tab.page.keyboard.press("Enter")
    expect(tab.traced("TWAT")).to_have_text("55")  # the reading before the warm ones


def test_live_readings_are_counted_as_they_come(dash, visitor):
    tab = visitor(dash.url).show("chart")
    expect(tab.traced("TWAT")).to_have_text("87")
    tab.page.get_by_role("tab", name="Scatter").click()
    counted = "() => Number(document.querySelector('[data-points]')?.dataset.points ?? 0)"
    before = tab.until(f"() => ({counted})()")
    assert tab.until(f"before => ({counted})() > before + 10", before)
    tab.page.get_by_role("tab", name="Table").click()
    tab.says("live values since")


def test_a_table_of_two_recordings_shows_their_difference(drives, visitor):
    tab = _opened(drives, visitor)
    tab.press("Compare with…")
    tab.page.get_by_role("dialog").get_by_role("button", name="other.pcapng").click()
    expect(tab.page.get_by_role("group", name="Comparison")).to_be_visible()
    _view(tab, "Table")
    expect(_cell(tab, "80–90").locator("b")).to_have_text("3.00")
    tab.says("this recording minus the second one, other.pcapng")
    tab.page.get_by_label("Shown").select_option("second")
    expect(_cell(tab, "80–90").locator("b")).to_have_text("17.00")


def test_references_come_first_and_the_virtual_car_is_named_as_such(drives, visitor):
    tab = _opened(drives, visitor)
    tab.show("recordings").press("Make other.pcapng a reference")
    expect(tab.button("other.pcapng is a reference: remove the mark")).to_be_visible()
    tab.show("chart").press("Compare with…")
    sheet = tab.page.get_by_role("dialog")
    expect(sheet.locator("li").first).to_contain_text("★ other.pcapng")
    words = "virtual car, not measured on a real engine"
    idle = sheet.get_by_role("button", name="Virtual car 7.1: warm idle")
    expect(idle).to_contain_text(words)
    idle.click()
    bar = tab.page.get_by_role("group", name="Comparison")
    expect(bar).to_contain_text(f"Virtual car 7.1: warm idle ({words})")
    expect(tab.find('[data-second="TWAT"] b')).to_have_text(re.compile("8[5-9]"))
    _view(tab, "Table")
    tab.says(f"minus the second one, Virtual car 7.1: warm idle ({words})")
