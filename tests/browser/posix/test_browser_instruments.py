"""A λ meter behind a pty beside the unit: added, shown, recorded, unplugged, kept, removed."""

from __future__ import annotations

import os
import pty
import threading
import tty
from contextlib import suppress

import pytest
from playwright.sync_api import expect

from browser.rig import dashboard
from mikas.link.ports import Port


class Meter:
    """A λ meter that sends five lines a second, at a port that keeps its name."""

    def __init__(self, folder):
        self._name = folder / "ttyMeter"
        self.port = Port(str(self._name), "CH340", "CH340", likely=True)
        self._ended = threading.Event()
        self._using = threading.Lock()  # the number of a closed file is another one's
        self._own = None
        self.plug()
        self._thread = threading.Thread(target=self._send)
        self._thread.start()

    def plug(self):
        own, other = pty.openpty()
        tty.setraw(other)
        self._name.symlink_to(os.ttyname(other))
        os.close(other)
        self._own = own

    def unplug(self):
        self._name.unlink()
        with self._using:
            os.close(self._own)
            self._own = None

    def _send(self):
        while not self._ended.wait(0.2):
            with self._using, suppress(OSError):  # while nobody has the other end open
                if self._own is not None:
                    os.write(self._own, b"0.98\r\n")

    def close(self):
        self._ended.set()
        self._thread.join()


@pytest.fixture
def meter(tmp_path):
    made = Meter(tmp_path)
    yield made
    made.close()


def test_a_meter_beside_the_unit(chromium, tmp_path, visitor, meter):
    with dashboard(tmp_path) as own:
        own.garage.ports.append(meter.port)
        tab = visitor(own.samples().url).show("connection")
        tab.press("Add an instrument…")
        form = tab.find("dialog[open]")
        form.get_by_label("Instrument").select_option("aem")
        form.get_by_label("Port").select_option(meter.port.url)
        form.get_by_role("button", name="Add", exact=True).click()
        line = tab.find("[data-instrument=aem]")
        expect(line).to_have_attribute("data-state", "values")
        expect(line).to_contain_text("0.980")

        meter.unplug()
        expect(line).to_have_attribute("data-state", "lost")
        expect(line).to_contain_text("the unit is read on")
        tab.is_line("sampling")
        meter.plug()
        expect(line).to_have_attribute("data-state", "values")

        tab.page.reload()
        expect(line).to_contain_text("0.980")
        line.get_by_role("button", name="λ, measured").click()
        expect(tab.find("dialog[open]")).to_contain_text("LAMBDA")
        tab.page.keyboard.press("Escape")
        line.get_by_role("button", name="Remove").click()
        tab.find("dialog[open]").get_by_role("button", name="Remove").click()
        expect(line).to_have_count(0)
        assert tab.complaints == []
        tab.page.close()  # the program's end would refuse what the page still asks for
