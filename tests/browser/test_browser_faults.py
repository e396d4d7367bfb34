"""Faults: read, and erased in two steps; what was there stays in the journal."""

from __future__ import annotations

from playwright.sync_api import expect


def test_faults_are_read_and_erased_and_kept_in_the_journal(own, visitor):
    tab = visitor(own.url).show("faults")
    cards = tab.find("ol.cards article")
    expect(cards).to_have_count(2)
    expect(cards.nth(0)).to_contain_text("17")
    expect(cards.nth(1)).to_contain_text("41")
    tab.press("Erase…")
    sheet = tab.page.get_by_role("dialog")
    expect(sheet).to_contain_text("17")
    assert own.garage.car.faults == [17, 41]
    sheet.get_by_role("button", name="Cancel").click()
    assert own.garage.car.faults == [17, 41]
    tab.press("Erase…")
    sheet.get_by_role("button", name="Erase", exact=True).click()
    tab.says("No faults are stored")
    assert own.garage.car.faults == []
    expect(tab.find('nav a[data-screen="faults"] .count')).to_have_count(0)
    tab.find("summary", has_text="Journal").click()
    expect(tab.find("details li").first).to_contain_text("were stored: 17, 41")


def test_a_list_that_changed_meanwhile_is_shown_again_not_erased(own, visitor):
    tab = visitor(own.url).show("faults")
    tab.refused = True
    expect(tab.find("ol.cards article")).to_have_count(2)
    tab.press("Erase…")
    sheet = tab.page.get_by_role("dialog")
    expect(sheet).to_contain_text("41")
    own.garage.car.faults.append(53)
    sheet.get_by_role("button", name="Erase", exact=True).click()
    expect(sheet).to_contain_text("nothing was erased")
    expect(sheet).to_contain_text("53")
    assert own.garage.car.faults == [17, 41, 53]
