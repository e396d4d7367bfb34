"""Instruments beside the unit on the page without installation: a second and a third cable by Web
Serial, and the browser's own position.
"""

from __future__ import annotations

import threading
from contextlib import contextmanager

import pytest
from playwright.sync_api import expect

from .computer_rig import CH340, Adapter
from .wire_rig import wire

pytestmark = pytest.mark.realtime

CP2102 = Adapter("10c4", "ea60", "CP2102_USB_to_UART")
SENTENCE = b"$GPRMC,120000.00,A,5545.0000,N,03737.2000,E,19.4,90.0,011226,,,A*55\r\n"


@contextmanager
def sending(far_end, message):
    """Send `message` over and over, as an instrument does."""
    ended = threading.Event()

    def send():
        while not ended.wait(0.2):
            far_end.send(message)

    thread = threading.Thread(target=send)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def checked(sentence):
    """The sentence with its checksum."""
    body = sentence[1 : sentence.index(b"*")]
    total = 0
    for byte in body:
        total ^= byte
    return b"$%b*%02X\r\n" % (body, total)


def add(tab, name, port):
    tab.press("Add an instrument…")
    form = tab.find("dialog[open]")
    form.get_by_label("Instrument").select_option(name)
    if port:
        expect(form.get_by_role("button", name="Choose the cable…")).to_be_visible()
        form.get_by_label("Port").select_option(port)
    form.get_by_role("button", name="Add", exact=True).click()
    expect(form).to_have_count(0)


def test_a_meter_and_a_gps_at_cables_of_their_own_and_the_browsers_position(tab, whole_computer):
    with (
        wire(whole_computer, CH340) as meter,
        wire(whole_computer, CP2102) as gps,
        sending(gps, checked(SENTENCE)),
    ):
        tab.show("connection")
        with sending(meter, b"1.02\r\n"):
            add(tab, "aem", "webserial:1a86:7523")
            add(tab, "nmea", "webserial:10c4:ea60")
            for name in ("aem", "nmea"):
                line = tab.find(f"[data-instrument={name}]")
                expect(line).to_have_attribute("data-state", "values")
            expect(tab.find("[data-instrument=aem]")).to_contain_text("1.020")
            expect(tab.find("[data-instrument=nmea]")).to_contain_text("55.75")
            tab.is_line("sampling")

        meter.vanish()
        expect(tab.find("[data-instrument=aem]")).to_have_attribute("data-state", "lost")
        tab.is_line("sampling")

        tab.again().connect()  # the choice is kept; they are read beside the unit
        expect(tab.find("[data-instrument=nmea]")).to_have_attribute("data-state", "values")
        for name in ("aem", "nmea"):
            tab.find(f"[data-instrument={name}]").get_by_role("button", name="Remove").click()
            tab.find("dialog[open]").get_by_role("button", name="Remove").click()
            expect(tab.find(f"[data-instrument={name}]")).to_have_count(0)

    context = tab.page.context
    context.grant_permissions(["geolocation"])
    context.set_geolocation({"latitude": 55.5, "longitude": 37.25})
    add(tab, "phone", "")
    expect(tab.find("[data-instrument=phone]")).to_contain_text("55.5")
    expect(tab.find("[data-position]")).to_have_attribute("data-position", "sent")
    tab.find("[data-instrument=phone]").get_by_role("button", name="Remove").click()
    tab.find("dialog[open]").get_by_role("button", name="Remove").click()
    expect(tab.find("[data-position]")).to_have_count(0)
