"""Messages shown on every screen: alarms of values that are not shown; of the line,
while a recording is; the unit and the wire, on a phone; and the keys that belong to what is shown.
"""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

PHONE = {"viewport": {"width": 390, "height": 844}, "locale": "ru-RU"}
HOT, WARM = "9E", "7F"  # TWAT, 118 °C and 87 °C


@pytest.fixture
def car(dash):
    dash.garage.set("TWAT", WARM)
    dash.until(lambda: dash.state()["alarms"] == [])
    return dash


def first(dash):
    """The channels that come first."""
    return dash.state()["plan"]["first"]


def record(dash):
    """A recording that is over: some ten samples."""
    dash.post("/recording/start", {"name": "drive"})
    dash.until(lambda: dash.state()["recording"]["samples"] > 10)
    dash.post("/recording/stop")


def test_an_alarm_stays_when_another_preset_is_chosen(car, visitor):
    tab = visitor(car.url).show("live")
    alarm = tab.find("header[data-line]").get_by_role("button", name="1 alarm")
    tab.comes_first("TWAT")
    car.garage.set("TWAT", HOT)
    expect(alarm).to_be_visible()
    tab.page.get_by_role("tab", name="Fuel").click()
    car.until(lambda: "TWAT" not in first(car))
    before = car.state()["samples"]
    car.until(lambda: car.state()["samples"] > before + 25)
    (reported,) = car.state()["alarms"]
    assert reported["name"] == "TWAT"
    expect(alarm).to_be_visible()
    expect(tab.value("TWAT")).to_have_count(0)
    # It ends, and comes again, while something else is looked at.
    car.garage.set("TWAT", WARM)
    expect(alarm).to_have_count(0)
    car.garage.set("TWAT", HOT)
    expect(alarm).to_be_visible()
    tab.page.get_by_role("tab", name="Idle").click()
    expect(tab.value("TWAT")).to_have_text("118")
    car.until(lambda: "TWAT" in first(car))


def test_showing_what_is_watched_has_its_price(car, visitor):
    tab = visitor(car.url).show("live")
    tab.page.get_by_role("tab", name="Fuel").click()
    tab.press("Edit")
    tab.press("Add…")
    line = tab.page.get_by_role("dialog").get_by_role("button", name="Coolant temperature, ")
    expect(line).to_contain_text("readings/s")


def test_the_loop_has_its_key_on_the_chart_too(own, visitor):
    record(own)
    tab = visitor(own.url).show("recordings")
    tab.press("Open")
    player = tab.page.get_by_role("region", name="Player")
    expect(player).to_be_visible()
    tab.show("chart")
    tab.page.keyboard.press("?")
    keys = tab.page.get_by_role("dialog").locator("kbd", has_text="L")
    expect(keys).to_have_text(["L"])
    tab.page.keyboard.press("Escape")
    expect(tab.page.get_by_role("dialog")).to_have_count(0)
    tab.page.keyboard.press("l")
    expect(player).to_contain_text("loop from")
    player.get_by_role("slider").press("End")
    tab.page.keyboard.press("l")
    expect(player).to_contain_text("loops")
    tab.page.keyboard.press("l")
    expect(player.get_by_role("button", name="Loop from here")).to_be_visible()


def test_a_phone_shows_the_recording_while_the_line_is_down(own, visitor):
    record(own)
    tab = visitor(own.url, **PHONE).show("recordings")
    tab.press("Открыть")
    expect(tab.page.get_by_role("region", name="Проигрыватель")).to_be_visible()
    tab.show("chart")
    own.garage.pull()
    advice = tab.find("header").get_by_role("alert").get_by_role("button")
    expect(advice).to_contain_text("Подключите его снова, и опрос продолжится.")
    room = tab.find("#screen").bounding_box()
    assert room["height"] > 844 * 0.4
    brief = advice.bounding_box()["height"]
    assert brief < 50
    advice.click()
    expect(advice).to_have_attribute("aria-expanded", "true")
    expect(tab.find("header").get_by_role("link", name="Связь")).to_be_visible()
    assert advice.bounding_box()["height"] >= brief
    own.garage.put_back()
    expect(advice).to_have_count(0)


@pytest.mark.parametrize(
    ("language", "model", "rate", "wire"),
    [
        ("en-GB", "Mikas 7.1", "readings/s", "line load"),
        ("ru-RU", "Микас 7.1", "опр/с", "линия"),
    ],
)
def test_a_phone_shows_the_unit_and_the_wire(car, visitor, language, model, rate, wire):
    tab = visitor(car.url, **PHONE | {"locale": language}).show("live")
    band = tab.find("header[data-line]")
    expect(band).to_contain_text(rate)
    assert tab.until("() => document.documentElement.scrollWidth <= innerWidth")
    band.locator("button.figure").first.click()  # the rest stands above the errors
    expect(tab.page.get_by_role("dialog")).to_contain_text(model)
    expect(tab.page.get_by_role("dialog")).to_contain_text(wire)
    assert tab.until("() => document.documentElement.scrollWidth <= innerWidth")
