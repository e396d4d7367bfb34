"""The site's drivers in Chromium's own WebUSB, on every model of a chip with the unit behind it."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from browser.rig import until
from mikas.framing import encode
from tester.tester_rig import case
from usb.chips.cp210x import KINDS as CP210X
from usb.chips.named import FOUR, NAMES, driver_of
from usb.chips.uart import Character, Damage, Settings

from .computer_rig import ORIGIN
from .usb_sockets_rig import UsbCable, usb_cable

pytestmark = pytest.mark.realtime

HERE = Path(__file__).parent
ROLLDOWN = HERE.parents[1] / "web" / "node_modules" / ".bin" / "rolldown"
ASK = """([what, given]) => new Promise(resolve => {
  const worker = window.worker ??= new Worker("worker.js", { type: "module" })
  worker.onmessage = ({ data }) => resolve(data)
  worker.postMessage({ what, given })
})"""
UACC = list(encode(bytes((0x61, 0x1E))))
ANSWER = len(UACC) + 3
REFUSED = {"PL2303 unknown"}
BREAKLESS = {"PL2303 clone", "CDC ACM without break"}


class Page:
    """The page's worker with the drivers."""

    def __init__(self, page) -> None:
        self.page = page

    def __call__(self, what: str, given: object = None):
        answer = self.page.evaluate(ASK, [what, given])
        assert "failed" not in answer, answer["failed"]
        return answer["done"]

    def fails(self, what: str, given: object = None) -> str:
        """Return the error that this ends with."""
        return self.page.evaluate(ASK, [what, given])["failed"]

    def sees(self, count: int) -> None:
        """Wait until the browser lists so many ports."""
        asked = f"async count => (await ({ASK})(['ports'])).done.length === count"
        until(self.page, asked, count)

    def is_answered(self) -> None:
        found = self("exchange", {"request": UACC, "length": ANSWER, "times": 1})
        assert found["got"][: len(UACC)] == UACC
        assert found["got"][-1] == 0x0D


@pytest.fixture(scope="module")
def bundled(tmp_path_factory):
    folder = tmp_path_factory.mktemp("web-usb")
    (folder / "index.html").write_text("<!doctype html><link rel=icon href=data:,>", "ascii")
    command = [ROLLDOWN, HERE / "web_usb_page.js", "--format", "esm", "--file"]
    subprocess.run([*command, folder / "worker.js"], check=True, capture_output=True)
    return folder


@pytest.fixture
def page(usb_sockets, host, visitor, bundled):
    tab = visitor(host(bundled).url)
    tab.page.goto(ORIGIN)
    return Page(tab.page)


@pytest.fixture
def plugged(page, usb_sockets, tmp_path):
    """Plugs a chip in, and waits until the browser has it."""

    @contextmanager
    def plug(kind: str, **settings: str) -> Iterator[UsbCable]:
        page.sees(0)
        with usb_cable(usb_sockets, tmp_path, kind, **settings) as cable:
            page.sees(1)
            yield cable

    return plug


# -- every chip ------------------------------------------------------------------------------------


def test_every_chip_is_opened_answers_breaks_and_is_opened_again(page, plugged):
    for name in (it for it in NAMES if it not in REFUSED):
        with case(name), plugged(name) as cable:
            found = page("open")
            assert found["rate"] == pytest.approx(9600, rel=0.002)
            assert cable.chip.uart.settings.fits(Settings(9600))
            page.is_answered()
            assert cable.wire.sent.endswith(bytes(UACC))
            if name not in BREAKLESS:
                page("break", True)
                page("break", False)
                assert page("read", 1) == [0]  # the line echoes it
                assert cable.wire.breaks == 1
                if driver_of(name) != "ch341":
                    assert page("error") == "BreakError"
            page("close")
            page("open")
            page.is_answered()
            page("close")


def test_every_chip_is_set_to_the_rates_that_are_tried_on_a_silent_line(page, plugged):
    for name in (it for it in NAMES if it not in REFUSED):
        with case(name), plugged(name) as cable:
            for rate in (4800, 10400):
                found = page("open", {"baudRate": rate})
                assert cable.chip.uart.settings.fits(Settings(found["rate"]))
                is_listed = name in CP210X and found["rate"] == 14400
                assert is_listed or found["rate"] == pytest.approx(rate, rel=0.02)
                page("close")


def test_an_unknown_chip_is_refused_by_name(page, plugged):
    for name in REFUSED:
        with plugged(name):
            assert "unknown: bcdDevice 999" in page.fails("open")


def test_parity_and_stop_bits_are_set(page, plugged):
    for name in FOUR:
        with case(name), plugged(name) as cable:
            page("open", {"dataBits": 7, "parity": "even", "stopBits": 2})
            assert str(cable.chip.uart.settings.form) == "7E2"
            page("close")


def test_many_bytes_come_whole_and_in_order(page, plugged):
    data = bytes(range(256)) * 8
    for name in FOUR:
        with case(name), plugged(name) as cable:
            page("open")
            cable.hear(data)
            assert page("read", len(data)) == list(data)
            page("close")


def test_an_ftdi_hands_a_message_over_at_its_end_and_an_exchange_takes_its_time(page, plugged):
    with plugged("FT232R") as cable:
        assert page("open")["granularity"] == 0.016
        assert "latency 16" in cable.chip.uart.log
        page("exchange", {"request": UACC, "length": ANSWER, "times": 20})
        page("close")


# -- the line's errors -----------------------------------------------------------------------------


def test_errors_of_the_line_come_by_name_where_the_chip_reports_them(page, plugged):
    hurt = [Character(0x41), Character(0x01, Damage.FRAMING)]
    for name in (it for it in FOUR if it != "CH340"):
        with case(name), plugged(name) as cable:
            page("open")
            cable.fault(lambda chip: chip.uart.receive(hurt))
            assert page("error") == "FramingError"
            assert page("read", 2) == [0x41, 0x01]
            page.is_answered()
            page("close")


# -- pitfalls --------------------------------------------------------------------------------------


def test_a_stall_and_a_babble_do_not_end_the_port(page, plugged):
    for name in FOUR:
        with case(name), plugged(name) as cable:
            page("open")
            cable.fault(lambda chip: chip.faults.stall_in())
            page.is_answered()
            cable.fault(lambda chip: chip.faults.babble())
            cable.hear(b"!")
            assert page("error") == "BufferOverrunError"
            cable.hear(b"?")  # what babbled was the byte before, or a packet of status before it
            assert bytes(page("readTo", ord("?"))) in {b"?", b"!?"}
            page.is_answered()
            page("close")


def test_a_chip_that_takes_nothing_and_answers_nothing_can_still_be_closed(page, plugged):
    for name in FOUR:
        with case(name), plugged(name) as cable:
            page("open")
            cable.chip.faults.hang(*range(256))
            page("close")
            cable.chip.faults.forgive()
            page("open")
            page.is_answered()
            page("close")


def test_transfers_of_a_closed_session_that_end_late_do_no_harm(page, plugged, usb_sockets):
    with plugged("CP2102") as cable:
        page("open")
        cable.entry.keeps_discarded = True
        page("close")
        cable.entry.keeps_discarded = False
        page("open")
        for opened in usb_sockets.usbfs.opened(cable.entry):
            usb_sockets.lines.call(opened.end_kept)
        page.is_answered()
        page("close")


def test_a_pulled_chip_is_lost_and_opens_when_it_is_back(page, plugged):
    for name in FOUR:
        with case(name), plugged(name) as cable:
            page("open")
            page.is_answered()
            cable.pull()
            assert page("error") == "NetworkError"
            assert page("isGone") or page("ports") == []
            page("close")
            cable.put_back()
            page.sees(1)
            page("open")
            page.is_answered()
            page("close")


def test_a_chip_that_another_driver_has_is_not_opened_and_says_so(page, plugged):
    with plugged("CH340") as cable:
        cable.entry.driver = "ch341"
        assert page.fails("open").startswith("ClaimError")
        cable.entry.driver = ""
        page("open")
        page.is_answered()
        page("close")


def test_a_chip_without_rights_is_not_opened_and_says_so(page, plugged):
    with plugged("CP2102") as cable:
        cable.entry.may_open = False
        assert "Error" in page.fails("open").partition(":")[0]
        cable.entry.may_open = True
        page("open")
        page("close")


def test_a_first_byte_that_is_lost_after_opening_costs_one_exchange(page, plugged):
    for name in FOUR:
        with case(name), plugged(name) as cable:
            page("open")
            cable.fault(lambda chip: chip.uart.lose(sent=1))
            page("write", [0x0D])
            page.is_answered()
            page("close")


def test_a_wrong_rate_brings_a_whole_echo_and_no_answer(page, plugged):
    with plugged("CP2102"):
        page("open", {"baudRate": 10400})
        found = page("exchange", {"request": UACC, "length": len(UACC), "times": 1})
        assert found["got"][: len(UACC)] == UACC
        page("close")
