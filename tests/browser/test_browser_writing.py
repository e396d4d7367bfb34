"""A parameter is written from its card: stepped, confirmed, read back, put back by one touch."""

from __future__ import annotations

from playwright.sync_api import expect

from browser.test_browser_channels import violations


def opened(tab):
    """The sheet that writes RCOD, over its card; writing is unlocked."""
    tab.find('#screen [data-opens="RCOD"]').first.click()
    tab.page.get_by_role("button", name="Write to the unit…").click()
    sheet = tab.page.get_by_role("dialog").last
    expect(sheet.locator("[data-now] b")).to_have_text("−0.4688")
    if (unlock := sheet.get_by_role("button", name="Unlock writing")).is_visible():
        unlock.click()
        tab.page.get_by_role("button", name="Unlock", exact=True).click()
    return sheet


def test_a_parameter_is_written_and_put_back_also_after_a_reload(own, visitor):
    own.nobody_controls()
    tab = visitor(own.url).show("live")
    sheet = opened(tab)
    expect(sheet).to_contain_text("−1.0000 … −0.0039")
    sheet.get_by_role("button", name="0.0391 more").click()
    expect(sheet.get_by_label("New value")).to_have_value("−0.4297")
    assert violations(tab) == []
    sheet.get_by_role("button", name="Write…").click()
    expect(sheet.locator("[data-before]")).to_have_text("−0.4688")
    expect(sheet.locator("[data-after]")).to_have_text("−0.4297")
    assert violations(tab) == []
    sheet.get_by_role("button", name="Write −0.4297").click()
    expect(sheet).to_contain_text("Written and read back: −0.4688 → −0.4297")
    expect(sheet.locator("[data-now] code")).to_have_text("92")

    tab.page.reload()
    tab.find('#screen [data-opens="RCOD"]').first.click()
    tab.page.get_by_role("button", name="Write to the unit…").click()
    sheet = tab.page.get_by_role("dialog").last
    expect(sheet.locator("[data-now] b")).to_have_text("−0.4297")
    expect(sheet.locator("[data-start]")).to_contain_text("−0.4688")
    sheet.get_by_role("button", name="Back to −0.4688").click()
    expect(sheet).to_contain_text("Written and read back: −0.4297 → −0.4688")
    expect(sheet.get_by_role("button", name="Back to")).to_have_count(0)
    expect(sheet.locator("[data-now] code")).to_have_text("88")
    done = [it for it in own.get("/journal")["entries"] if it["state"] == "done"]
    assert [(it["before"], it["outcome"]) for it in done] == [("92", "88"), ("88", "92")]


def test_a_tab_that_lost_control_is_told_what_to_do(own, visitor):
    own.nobody_controls()
    first = visitor(own.url).show("live")
    sheet = opened(first)
    sheet.get_by_role("button", name="0.0039 more").click()
    first.refused = True  # it asks for the value until it knows that control has gone
    second = visitor(own.url).show("live")
    own.nobody_controls()
    other = opened(second)
    expect(other.get_by_role("button", name="Write…")).to_be_enabled()
    expect(sheet.get_by_role("button", name="Write…")).to_be_disabled()
    expect(first.find("header[data-line]")).to_contain_text("control")
