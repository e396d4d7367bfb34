"""A drive with a λ meter and a GPS at cables of their own, on the page without installation: its
trip with a pull, and CO set by a meter at its end.
"""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from browser.test_browser_channels import violations
from browser.test_browser_legible import SMALL_TEXT

from .computer_rig import CH340, Adapter
from .wire_rig import cable

pytestmark = pytest.mark.realtime

CP2102 = Adapter("10c4", "ea60", "CP2102_USB_to_UART")
PHONE, LAPTOP = {"width": 390, "height": 844}, {"width": 1280, "height": 720}
DRIVE = """\
duration = 30
after_end = "loop"

[start]
ambient = 20
coolant = 86
running = true

[timeline]
gear = 4
throttle = [[0, 12], [3, 12], [3.5, 100], [15, 100], [15.5, 0], [28, 0], [29, 12], [30, 12]]
speed = [[0, 45], [4, 45], [15, 110], [16, 110], [28, 45], [30, 45]]
"""
"""In fourth gear, again and again: full throttle from 1500 to 3670 rpm, and back."""


@pytest.fixture(scope="module")
def car(whole_computer, tmp_path_factory):
    """A car that does it."""
    folder = tmp_path_factory.mktemp("drive")
    file = folder / "drive.toml"
    file.write_text(DRIVE, "utf-8")
    with cable(whole_computer, folder, scenario=str(file)) as plugged:
        yield plugged


def add(tab, name, port):
    tab.press("Add an instrument…")
    form = tab.find("dialog[open]")
    form.get_by_label("Instrument").select_option(name)
    form.get_by_label("Port").select_option(port)
    form.get_by_role("button", name="Add", exact=True).click()
    expect(tab.find(f"[data-instrument={name}]")).to_have_attribute("data-state", "values")


def fits(tab):
    """On a laptop and on a phone axe has nothing against it, no text is small, and nothing is to be
    scrolled sideways.
    """
    assert violations(tab) == []
    assert tab.page.evaluate(SMALL_TEXT) == []
    tab.page.set_viewport_size(PHONE)
    assert tab.page.evaluate("() => document.documentElement.scrollWidth - innerWidth") <= 0
    assert violations(tab) == []
    assert tab.page.evaluate(SMALL_TEXT) == []
    tab.page.set_viewport_size(LAPTOP)


def test_a_drive_has_its_way_its_fuel_and_its_power(tab, car):
    with car.instrument("aem", CH340), car.instrument("nmea", CP2102):
        add(tab, "aem", "webserial:1a86:7523")
        add(tab, "nmea", "webserial:10c4:ea60")
        tab.record()
        tab.show("recordings")
        tab.page.get_by_role("link", name="Trip").first.click()
        expect(tab.find("[data-sum=ran]")).to_be_visible()
        tab.recorded(50)
        tab.press("Refresh")
        expect(tab.find("[data-way] path").first).to_be_visible()
        tab.stop_recording()
    recording = tab.recordings()[0]["id"]
    tab.show(f"recordings/trip/{recording}")
    expect(tab.find("[data-way] path").first).to_be_visible()
    expect(tab.find("[data-sum=litres] dd")).to_contain_text(" l")
    expect(tab.find("[data-sum=kilometres] dd")).to_contain_text(" km")
    gpx = tab.download(tab.button("Save for maps: .gpx")).decode()
    assert gpx.count("<trkpt ") > 20
    tab.page.get_by_label("Mass with driver").fill("1600")
    tab.press("Compute")
    expect(tab.find("[data-pull]").first).to_be_visible()
    fits(tab)


def test_co_is_set_by_a_meter_and_put_back(visit, car):
    car.pull()
    car.tune(scenario="warm-idle")
    car.put_back()
    tab = visit.connect().show("tests/co")
    screen = tab.find("#screen")
    expect(screen.get_by_text("Warm idle:")).to_be_visible()
    fits(tab)
    screen.get_by_label("Figure to reach").fill("0.8")
    screen.get_by_role("button", name="Unlock writing").click()
    tab.page.get_by_role("button", name="Unlock", exact=True).click()
    tab.press("Begin")
    raw = screen.locator("[data-now] code")
    expect(raw).to_have_text("88")
    measured(screen, "2.0")
    screen.get_by_role("button", name="Write −").click()
    expect(raw).not_to_have_text("88")
    back = screen.get_by_role("button", name="Back to")
    back.click()
    expect(back).to_have_count(0)
    expect(raw).to_have_text("88")
    done = [it for it in tab.get("/journal")["entries"] if it["state"] == "done"]
    assert [it["change"]["en"] for it in done[:2]] == ["write parameter RCOD"] * 2
    measured(screen, "2.0")
    fits(tab)


def measured(screen, figure):
    screen.get_by_role("textbox").fill(figure)
    screen.get_by_role("button", name="Next step").click()
    expect(screen.locator("[data-proposal]")).to_be_visible()
