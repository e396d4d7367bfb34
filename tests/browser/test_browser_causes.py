"""Causes on the page: of the connected car and of a recording, by a complaint in one touch."""

from __future__ import annotations

from playwright.sync_api import expect


def test_causes_are_ranked_by_a_touch_and_a_recording_has_its_own(served, visitor):
    served.nobody_controls()
    served.post("/recording/start", {"name": "ride"})
    served.until(lambda: served.get("/state")["recording"]["samples"] > 20)
    served.post("/recording/stop")
    tab = visitor(served.url).show("causes")
    expect(tab.find("[data-verdict]")).to_be_visible()
    chip = tab.find("#screen [role=group] [aria-pressed]").first
    chip.click()
    expect(chip).to_have_attribute("aria-pressed", "true")
    expect(tab.find("[data-verdict]")).to_be_visible()
    tab.find("#screen select").select_option("ride.pcapng")
    expect(tab.find("h1")).to_contain_text("recording ride")
    expect(tab.find("[data-verdict]")).to_be_visible()
    expect(chip).to_have_attribute("aria-pressed", "true")


def recorded(served, name: str) -> None:
    served.post("/recording/start", {"name": name})
    served.until(lambda: served.get("/state")["recording"]["samples"] > 20)
    served.post("/recording/stop")


def test_two_recordings_of_a_car_count_together_on_a_phone(served, visitor):
    served.nobody_controls()
    for name in ("first", "second"):
        recorded(served, name)
    tab = visitor(served.url, viewport={"width": 390, "height": 844}).show("causes/second.pcapng")
    expect(tab.find("[data-verdict]")).to_be_visible()
    tab.find("#screen summary", has_text="With other recordings of this car:").click()
    box = tab.page.get_by_role("checkbox", name="first")
    box.check()
    expect(tab.find("h1")).to_contain_text("recording second and 1 more")
    expect(tab.find("[data-verdict]")).to_be_visible()
    wide = tab.page.evaluate("document.documentElement.scrollWidth")
    assert wide <= 390
    box.uncheck()
    expect(tab.find("h1")).not_to_contain_text("more")
