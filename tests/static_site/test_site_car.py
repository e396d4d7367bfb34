"""The site on a car: the adapter is found, values are the unit's; faults, passport, memory."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from browser.test_browser_memory import dump, read, space

from .site_rig import PORT

pytestmark = pytest.mark.realtime


def test_an_adapter_that_the_browser_allows_is_listed_and_connected(visit, car):
    visit.show("connection")
    expect(visit.button("Choose the cable…")).to_be_visible()
    one = visit.find("#screen li", has_text="0403:6001")
    expect(one).to_contain_text("FT232R")
    visit.press(f"Connect to {PORT}")
    visit.is_line("sampling")
    expect(visit.find("header[data-line]")).to_contain_text("Mikas 7.1")
    expect(one).to_contain_text("in use")


def test_values_are_those_of_the_unit(tab, car):
    tab.show("live")
    for name, raw, shown in (
        ("TWAT", "80", "88"), ("TWAT", "7F", "87"), ("UACC", "8A", "13.8"), ("UOZ", "F9", "−3.5"),
        ("JAIR", "DC 05", "15.0"),
    ):  # fmt: skip
        car.set(name, raw)
        expect(tab.value(name)).to_have_text(shown)


def test_faults_are_read_and_erased_in_two_steps(tab, car):
    tab.show("faults")
    cards = tab.find("ol.cards article")
    expect(cards).to_have_count(2)
    expect(cards.nth(0)).to_contain_text("17")
    tab.press("Erase…")
    sheet = tab.page.get_by_role("dialog")
    expect(sheet).to_contain_text("41")
    sheet.get_by_role("button", name="Cancel").click()
    assert car.car.faults == [17, 41]
    tab.press("Erase…")
    sheet.get_by_role("button", name="Erase with the engine running").click()
    tab.says("No faults are stored")
    assert car.car.faults == []


def test_the_passport_is_the_units(tab):
    tab.show("passport")
    tab.says("17.3763.000-02")


def test_a_dump_is_downloaded_and_compared(tab, car, tmp_path):
    tab.show("memory")
    card = dump(tab, "XRAM", "8000", "803F")
    expect(card).to_contain_text("complete")
    kept = car.memory.read("xram", 0x8000, 64)
    assert tab.download(card.get_by_role("link", name="Download")) == kept
    other = tmp_path / "other.bin"
    other.write_bytes(kept[:5] + b"\x99" + kept[6:])
    card.get_by_role("button", name="Compare").click()
    sheet = tab.page.get_by_role("dialog")
    sheet.locator("[type=file]").set_input_files(other)
    expect(sheet).to_contain_text("1 byte differs")
    expect(sheet.locator(".differs")).to_have_text(["20", "99"])
    tab.page.keyboard.press("Escape")


def test_writing_is_unlocked_shown_and_confirmed(tab, car):
    tab.show("memory")
    space(tab, "XRAM")
    read(tab, "9000")
    before = car.memory.read("xram", 0x9000, 2)
    tab.press("Unlock writing for 5 minutes…")
    sheet = tab.page.get_by_role("dialog")
    sheet.get_by_role("button", name="Unlock", exact=True).click()
    tab.press("Write bytes…")
    sheet.get_by_label("Bytes, hex").fill("0D 40")
    sheet.get_by_role("button", name="Review…").click()
    expect(sheet.locator("dl")).to_contain_text(before.hex().upper())
    assert car.memory.read("xram", 0x9000, 2) == before
    sheet.get_by_label("The car stands still").check()
    sheet.get_by_role("button", name="Write", exact=True).click()
    tab.says("Written and read back")
    assert car.memory.read("xram", 0x9000, 2) == b"\x0d\x40"
    tab.press("Lock now")


def test_an_adapter_that_was_pulled_is_found_again(tab, car):
    tab.refused = True
    tab.show("live")
    car.pull()
    tab.is_line("no-port")
    expect(tab.value("TWAT")).not_to_have_text("87")
    car.put_back()
    tab.is_line("sampling")
    car.set("TWAT", "81")
    expect(tab.value("TWAT")).to_have_text("89")
