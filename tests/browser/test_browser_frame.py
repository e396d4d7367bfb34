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
