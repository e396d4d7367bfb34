"""A parameter is written in the page without installation, on a phone: the gate is there, too."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

pytestmark = pytest.mark.realtime

PHONE = {"width": 390, "height": 844}


def test_a_parameter_is_written_over_the_cable_and_put_back(tab):
    tab.page.set_viewport_size(PHONE)
    tab.show("live")
    tab.find('#screen [data-opens="RCOD"]').first.click()
    tab.page.get_by_role("button", name="Write to the unit…").click()
    sheet = tab.page.get_by_role("dialog").last
    sheet.get_by_role("button", name="Unlock writing").click()
    tab.page.get_by_role("button", name="Unlock", exact=True).click()
    before = tab.get("/parameters/RCOD")["now"]["raw"]
    sheet.get_by_role("button", name="0.0039 more").click()
    sheet.get_by_role("button", name="Write…").click()
    expect(sheet.locator("[data-after]")).to_be_visible()
    wide = tab.page.evaluate("() => document.documentElement.scrollWidth - innerWidth")
    assert wide <= 0
    sheet.get_by_role("button", name="Write −").click()
    expect(sheet).to_contain_text("Written and read back")
    shown = tab.get("/parameters/RCOD")
    assert int(shown["now"]["raw"], 16) == int(before, 16) + 1
    assert shown["start"]["raw"] == before
    sheet.get_by_role("button", name="Back to").click()
    expect(sheet.get_by_role("button", name="Back to")).to_have_count(0)
    assert tab.get("/parameters/RCOD")["now"]["raw"] == before
    done = [it for it in tab.get("/journal")["entries"] if it["state"] == "done"]
    assert [it["change"]["en"] for it in done[:2]] == ["write parameter RCOD"] * 2
