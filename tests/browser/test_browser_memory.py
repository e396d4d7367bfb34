"""Memory: read, dumped and compared; written only behind the lock, with before and after shown."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import expect

from browser.rig import dashboard


@pytest.fixture(scope="module")
def quick(chromium, tmp_path_factory):
    """A car on a faster wire: what is read is what matters here."""
    with dashboard(tmp_path_factory.mktemp("quick"), baud="57600") as dash:
        yield dash.samples()


@pytest.fixture
def fast(quick):
    quick.nobody_controls()
    return quick


def space(tab, name):
    tab.page.get_by_role("tab", name=name).click()


def read(tab, address):
    tab.find(".bar input").first.fill(address)
    tab.find(".bar [type=submit]").click()


def dump(tab, name, first, last, *, verify=False):
    form = tab.find("form", has=tab.button("Start the dump"))
    form.get_by_label("Space").select_option(label=name)
    form.get_by_label("From").fill(first)
    form.get_by_label("To").fill(last)
    form.get_by_label("Read twice").set_checked(verify)
    form.locator("[type=submit]").click()
    card = tab.find("article", has_text=f"{name} {first}–{last}")
    expect(card).to_be_visible()
    return card


def more_read(tab, card, before):
    """Waits until more than `before` percent was read; how much."""
    bar = card.locator("progress")
    expect(bar).to_be_visible()
    return tab.page.wait_for_function(
        "([bar, before]) => bar.value > before && bar.value", arg=[bar.element_handle(), before]
    ).json_value()


def downloaded(tab, where):
    with tab.page.expect_download() as download:
        where.click()
    return Path(download.value.path()).read_bytes()


def test_the_cells_are_those_of_the_unit(fast, visitor):
    tab = visitor(fast.url).show("memory")
    space(tab, "XRAM")
    read(tab, "8000")
    row = tab.find("[role=grid] tbody tr").first
    expect(row.locator("[role=gridcell]")).to_have_text(
        [
            "4D",
            "49",
            "4B",
            "41",
            "53",
            "20",
            "37",
            "2E",
            "31",
            "0D",
            "40",
            "0A",
            "FF",
            "00",
            "10",
            "80",
        ]
    )
    expect(row.locator(".characters")).to_contain_text("MIKAS 7.1")


def test_a_dump_is_compared_with_a_file(fast, visitor, tmp_path):
    tab = visitor(fast.url).show("memory")
    card = dump(tab, "XRAM", "8000", "80FF", verify=True)
    expect(card).to_contain_text("both passes agree")
    kept = fast.garage.memory.read("xram", 0x8000, 256)
    assert downloaded(tab, card.get_by_role("link", name="Download")) == kept
    other = tmp_path / "other.bin"
    other.write_bytes(kept)
    card.get_by_role("button", name="Compare").click()
    sheet = tab.page.get_by_role("dialog")
    sheet.locator("[type=file]").set_input_files(other)
    expect(sheet).to_contain_text("Identical: 256 bytes")
    other.write_bytes(kept[:5] + b"\x99" + kept[6:])
    sheet.locator("[type=file]").set_input_files([])
    sheet.locator("[type=file]").set_input_files(other)
    expect(sheet).to_contain_text("1 byte differs")
    expect(sheet.locator(".differs")).to_have_text(["20", "99"])


def test_a_reload_in_the_middle_of_a_dump_loses_nothing(dash, visitor):
    """Of all the code: that takes minutes, and is not waited for."""
    tab = visitor(dash.url).show("memory")
    card = dump(tab, "CODE", "0000", "FFFF")
    expect(card).to_contain_text("reading")
    before = more_read(tab, card, 0)
    tab.page.reload()
    expect(card).to_contain_text("reading")
    more_read(tab, card, before)
    card.get_by_role("button", name="Pause").click()
    expect(card).to_contain_text("paused")
    (kept,) = [it for it in dash.get("/dumps")["dumps"] if it["space"] == "code"]
    assert kept["done"] > before * 0xFFFF // 100
    data = downloaded(tab, card.get_by_role("link", name="Download"))
    assert len(data) >= kept["done"]  # what was under way when it was paused comes as well
    assert data == dash.garage.memory.read("code", 0, len(data))


def test_writing_is_unlocked_shown_and_confirmed(fast, visitor):
    tab = visitor(fast.url).show("memory")
    space(tab, "XRAM")
    read(tab, "9000")
    before = fast.garage.memory.read("xram", 0x9000, 2)
    expect(tab.button("Write bytes…")).to_have_count(0)
    tab.press("Unlock writing for 5 minutes…")
    sheet = tab.page.get_by_role("dialog")
    sheet.get_by_role("button", name="Unlock", exact=True).click()
    tab.press("Write bytes…")
    sheet.get_by_label("Bytes, hex").fill("0D 40")
    sheet.get_by_role("button", name="Review…").click()
    expect(sheet.locator("dl")).to_contain_text(before.hex().upper())
    expect(sheet.locator("dl")).to_contain_text("0D40")
    assert fast.garage.memory.read("xram", 0x9000, 2) == before
    sheet.get_by_label("The car stands still").check()
    sheet.get_by_role("button", name="Write", exact=True).click()
    tab.says("Written and read back")
    assert fast.garage.memory.read("xram", 0x9000, 2) == b"\x0d\x40"
    tab.press("Lock now")
    expect(tab.button("Write bytes…")).to_have_count(0)
