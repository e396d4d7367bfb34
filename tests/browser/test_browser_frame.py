"""The frame of all screens: where a screen begins, the navigation of a phone, reasons in words."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

TOP = "() => document.querySelector('#screen').scrollTop"
SIZES = {"upright": (390, 844), "on its side": (844, 390)}


def test_a_screen_begins_at_its_top_and_back_returns_to_where_it_was(dash, visitor):
    tab = visitor(dash.url, viewport={"width": 844, "height": 390}).show("connection")
    expect(tab.find("#screen .columns")).to_be_visible()
    tab.page.mouse.move(400, 200)
    tab.page.mouse.wheel(0, 300)
    left = tab.until("() => document.querySelector('#screen').scrollTop || null")
    tab.find("nav a[data-screen=faults]").click()
    expect(tab.find("ol.cards article").first).to_be_visible()
    assert tab.page.evaluate(TOP) == 0
    tab.page.go_back()
    tab.until("left => document.querySelector('#screen').scrollTop >= left - 1", left)
    tab.page.go_forward()
    expect(tab.find("ol.cards article").first).to_be_visible()
    tab.until("() => document.querySelector('#screen').scrollTop === 0")


@pytest.mark.parametrize("held", SIZES)
def test_a_phone_reaches_every_screen_by_the_thumb(dash, visitor, held):
    width, height = SIZES[held]
    tab = visitor(dash.url, viewport={"width": width, "height": height}, has_touch=True)
    tab.show("live")
    seen = tab.find("nav :is(a, button):visible")
    for each in seen.all():
        box = each.bounding_box()
        assert min(box["width"], box["height"]) >= 44
        assert box["y"] + box["height"] <= height
    tab.press("More")
    sheet = tab.page.get_by_role("dialog")
    reached = {it.get_attribute("href") for it in (*seen.all(), *sheet.get_by_role("link").all())}
    every = {it.get_attribute("href") for it in tab.find("nav a").all()}
    assert every <= reached
    sheet.get_by_role("link", name="Memory").tap()
    expect(tab.find("h1")).to_have_text("Memory")
    expect(sheet).to_have_count(0)
    tab.press("More")
    sheet.get_by_role("button", name="Русский").tap()
    expect(tab.find("h1")).to_have_text("Память")


def test_an_adapter_pulled_out_leaves_the_last_faults_one_error_and_reasons_in_words(own, visitor):
    tab = visitor(own.url).show("live")
    badge = tab.find("nav a[data-screen=faults] .count")
    expect(badge).to_have_text("2")
    begin = tab.button("Record", exact=True)
    expect(begin).to_be_enabled()
    before = own.state()["errors"]  # of a computer that was too busy
    own.garage.pull()
    tab.is_line("no-port")
    expect(begin).to_be_disabled()
    tab.page.keyboard.press("r")
    tab.says("Nothing to record: the port is not open")
    tab.show("faults")  # for the first time: nothing was read by this page
    tab.says("As last read at")
    expect(tab.find("ol.cards article")).to_have_count(2)
    expect(badge).to_have_text("2")
    tab.find("header button.named").click()
    errors = tab.page.get_by_role("dialog")
    expect(errors.locator("li", has_text="unplugged")).to_have_count(1)
    expect(errors).to_contain_text(f"{before + 1} error")
    assert own.state()["errors"] == before + 1
    tab.page.keyboard.press("Escape")
    own.garage.car.faults.remove(41)
    own.garage.put_back()
    tab.is_line("sampling")
    expect(tab.find("ol.cards article")).to_have_count(1)
    expect(badge).to_have_text("1")
    expect(begin).to_be_enabled()
