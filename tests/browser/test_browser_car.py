"""Whose car: asked once at the first recording, in the list, on the report."""

from __future__ import annotations

from playwright.sync_api import expect


def test_asked_once_and_shown_in_list_and_report(own, visitor):
    tab = visitor(own.url).show("live")
    own.until(lambda: own.state()["model"])
    page = tab.page
    page.keyboard.press("r")
    page.get_by_role("button", name="Add car details…").click()
    sheet = page.get_by_role("dialog")
    sheet.get_by_label("Car", exact=True).fill("Волга 3110")
    sheet.get_by_label("Number plate").fill("А123ВС 52")
    mileage = sheet.get_by_label("Mileage now, km")
    mileage.fill("many")
    expect(sheet.get_by_role("button", name="Save")).to_be_disabled()
    mileage.fill("154 000 km")
    sheet.get_by_role("button", name="Save").click()
    expect(sheet).to_have_count(0)
    page.get_by_role("button", name="Stop recording").click()
    row = tab.show("recordings").find("tbody tr")
    expect(row).to_contain_text("Волга 3110 · А123ВС 52 · 154000 km")
    expect(page.get_by_role("button", name="Record", exact=True)).to_be_visible()
    page.keyboard.press("r")  # not asked again
    page.get_by_role("button", name="Stop recording").click()
    expect(row).to_have_count(2)
    expect(page.get_by_role("button", name="Add car details…")).to_have_count(0)
    second = row.filter(has_not_text="154000")
    expect(second).to_contain_text("Волга 3110 · А123ВС 52")
    second.get_by_role("button", name="Car details of").click()
    sheet.get_by_label("Mileage now, km").fill("155000")
    sheet.get_by_role("button", name="Save").click()
    expect(row.filter(has_text="155000 km")).to_have_count(1)
    tab.show("report")
    head = page.frame_locator("iframe").locator("header")
    expect(head).to_contain_text("А123ВС 52")
    expect(head).to_contain_text("154")
