"""A trip on the page: the connected car's with a GPS beside it, and that of its recording."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import expect

from browser.rig import dashboard
from browser.test_browser_channels import violations

PHONE = {"width": 390, "height": 844}


@pytest.fixture
def city(chromium, tmp_path):
    with dashboard(tmp_path, scenario="city") as dash:
        yield dash.samples()


def test_a_drive_with_a_gps_has_its_way_on_the_screen_and_as_a_file(city, visitor):
    city.nobody_controls()
    city.post("/instruments", {"definition": "nmea", "port": "sim:"})
    city.post("/instruments", {"definition": "aem", "port": "sim:"})
    city.post("/recording/start", {"name": "ride"})
    city.until(lambda: len((city.get("/trip")["way"] or {"lines": []})["lines"]) > 1)
    tab = visitor(city.url).show("recordings/trip/live")
    expect(tab.find("[data-way] path").first).to_be_visible()
    expect(tab.find("[data-sum=kilometres] dd")).to_contain_text("km")
    city.post("/recording/stop")
    tab.show("recordings")
    tab.page.get_by_role("link", name="Trip in ride.pcapng").click()
    expect(tab.find("h1")).to_contain_text("Trip: recording ride")
    expect(tab.find("[data-sum=litres] dd")).to_contain_text(" l")
    tab.find("#screen").get_by_label("Colour").first.select_option("FREQ")
    expect(tab.find("#screen ul").first).to_contain_text("and more")
    assert violations(tab) == []
    with tab.page.expect_download() as saved:
        tab.button("Save for maps: .gpx").click()
    assert saved.value.suggested_filename == "ride.gpx"
    assert Path(saved.value.path()).read_text("utf-8").count("<trkpt ") > 1
    tab = visitor(city.url, viewport=PHONE, locale="ru-RU").show("recordings/trip/ride.pcapng")
    expect(tab.find("[data-way] path").first).to_be_visible()
    assert tab.page.evaluate("document.documentElement.scrollWidth") <= 390
