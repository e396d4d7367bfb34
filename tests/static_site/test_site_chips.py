"""The built site on a phone: each of the four chips over Chromium's WebUSB, by the page's drivers.

One page for all of them, as on a phone that gets another cable. The first byte after each opening
is lost, in both directions.
"""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from browser.rig import gaps_of
from mikas.virtual.memory import pattern
from usb.chips.named import FOUR

from .site_rig import SiteTab, site_tab
from .test_site_phone import ANDROID, UPRIGHT
from .usb_sockets_rig import usb_cable

pytestmark = pytest.mark.realtime

KNOWN = "async name => (await (await fetch('api/state')).json()).model?.en === name"
"""Whether the unit is known, by its name."""


@pytest.fixture(scope="module")
def phone(usb_sockets, chromium, site, tmp_path_factory):
    """The site on a phone, which the tests share.

    It has connected by itself to the first cable, as it does once in the life of a page.
    """
    folder = tmp_path_factory.mktemp("first")
    context = chromium.new_context(
        viewport=UPRIGHT, has_touch=True, is_mobile=True, user_agent=ANDROID, locale="en-GB"
    )
    with site_tab(context, site.url) as tab:
        with usb_cable(usb_sockets, folder, "CP2102"):
            tab.open("connection")
            tab.is_line("sampling")
            disconnect(tab)
        yield tab
    context.close()


@pytest.fixture
def cable(request, phone, usb_sockets, tmp_path):
    """A cable with this chip, connected; disconnected at the end."""
    with usb_cable(usb_sockets, tmp_path, request.param) as plugged:
        plugged.fault(lambda chip: chip.uart.lose(sent=1, received=1))
        connect(phone, plugged)
        yield plugged
        disconnect(phone)
        phone.refused = False


def disconnect(phone: SiteTab) -> None:
    phone.show("connection").press("Disconnect")
    phone.is_line("off")


def connect(phone: SiteTab, cable) -> None:
    chip = cable.chip.identity
    phone.show("connection").press(f"Connect to webusb:{chip.vid:04x}:{chip.pid:04x}")
    phone.is_line("sampling")
    phone.until(KNOWN, "Mikas 7.1")


@pytest.mark.parametrize("cable", FOUR, indirect=True)
def test_values_are_the_units_also_when_the_cable_is_back(phone, cable):
    phone.show("live")
    for raw, shown in (("80", "88"), ("7F", "87")):
        cable.set("TWAT", raw)
        expect(phone.value("TWAT")).to_have_text(shown)
    phone.refused = True
    cable.pull()
    phone.is_line("no-port")
    phone.says("choose it again on Connection")  # a browser may forget a chip without a number
    cable.put_back()
    phone.is_line("sampling")
    cable.set("TWAT", "81")
    expect(phone.value("TWAT")).to_have_text("89")


@pytest.mark.parametrize("cable", ["FT232R", "CH340"], indirect=True)
def test_faults_are_erased_and_a_memory_is_dumped(phone, cable):
    phone.show("faults")
    expect(phone.find("ol.cards article")).to_have_count(2)
    phone.press("Erase…")
    sheet = phone.page.get_by_role("dialog")
    expect(sheet).to_contain_text("17")
    sheet.get_by_role("button", name="Erase with the engine running").click()
    phone.says("No faults are stored")
    assert cable.car.faults == []

    # The page keeps the dumps of all cables.
    size = 768 if cable.chip.identity.vid == 0x0403 else 512
    phone.show("memory")
    form = phone.find("form", has=phone.button("Start the dump"))
    form.get_by_label("Space").select_option(label="XRAM")
    form.get_by_label("From").fill("0000")
    form.get_by_label("To").fill(f"{size - 1:04X}")
    form.get_by_label("Read twice").check()
    form.locator("[type=submit]").click()
    card = phone.find("article", has_text=f"XRAM 0000–{size - 1:04X}")
    expect(card).to_contain_text("both passes agree")
    assert phone.download(card.get_by_role("link", name="Download")) == pattern("xram")[:size]


@pytest.mark.parametrize("cable", ["CH340"], indirect=True)
def test_a_drive_has_one_gap_and_a_reload_takes_the_cable_again(phone, cable):
    phone.show("live").record()
    recorded = phone.recorded(1.5)
    phone.refused = True
    cable.pull()
    phone.is_line("no-port")
    cable.put_back()
    phone.is_line("recording")
    phone.recorded(recorded + 1.5)
    phone.stop_recording()
    (drive, *_) = phone.recordings()
    assert drive["samples"] > 0
    assert len(gaps_of(phone, drive)) == 1
    cable.entry.calls.clear()
    phone.page.once("dialog", lambda dialog: dialog.accept())  # the phone has the cable
    phone.again()
    assert "close" in cable.entry.calls
    phone.is_line("sampling")  # by itself
    phone.until(KNOWN, "Mikas 7.1")
