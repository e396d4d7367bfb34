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
    raw = sheet.locator("[data-now] code")
    expect(raw).to_have_text("88")
    sheet.get_by_role("button", name="0.0039 more").click()
    sheet.get_by_role("button", name="Write…").click()
    expect(sheet.locator("[data-after]")).to_be_visible()
    wide = tab.page.evaluate("() => document.documentElement.scrollWidth - innerWidth")
    assert wide <= 0
    sheet.get_by_role("button", name="Write −").click()
    expect(sheet).to_contain_text("Written and read back")
    expect(raw).to_have_text("89")
    expect(sheet.locator("[data-start]")).to_contain_text("−0.4688")
    sheet.get_by_role("button", name="Back to −0.4688").click()
    expect(sheet.get_by_role("button", name="Back to")).to_have_count(0)
    expect(raw).to_have_text("88")
    done = [it for it in tab.get("/journal")["entries"] if it["state"] == "done"]
    assert [it["change"]["en"] for it in done[:2]] == ["write parameter RCOD"] * 2
