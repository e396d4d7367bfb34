"""Each pitfall of USB, set on a model or on the browser's part: the page's drivers get over it."""

from __future__ import annotations

import pytest

from usb.book_rig import Far
from usb.chips.named import FOUR, plugged
from usb.chips.uart import Settings
from usb.page.node_rig import Refused

ANSWER = bytes(range(1, 201))
EMPTY = 40
BREAKS = {"FT232R": 0x04, "CH340": 0x9A, "CP2102": 0x05, "PL2303HX": 0x23}
"""The request by which each begins and ends a break."""

pytestmark = pytest.mark.realtime


@pytest.fixture(params=FOUR)
def chip(request, drivers):
    """A chip of each kind, opened; closed at the end."""
    yield Chip(drivers, request.param)
    drivers.hangs = set()
    drivers.do("close")


class Chip:
    """A model that the page has open, and the far end of its line."""

    def __init__(self, drivers, name: str) -> None:
        self._drivers, self.name = drivers, name
        self.plug()

    def plug(self) -> None:
        """Plug a new one in, and open it."""
        self.far = Far()
        self.device = plugged(self.name, self.far)
        self._drivers.insert(self.device)
        self.open()

    def open(self) -> None:
        self._drivers.do("open", options={"baudRate": 9600, "bufferSize": 4096})

    def hears(self, data: bytes) -> None:
        """Bytes come on the line."""
        self.device.uart.hear(data, Settings())

    def is_alive(self) -> None:
        """Bytes pass both ways, with nothing before and between them."""
        self._drivers.do("write", data=[0x01])
        assert self.far.data.endswith(b"\x01")
        self.hears(ANSWER)
        assert self._drivers.received(len(ANSWER)) == ANSWER


def test_packets_without_bytes_are_no_end_and_no_bytes(drivers, chip):
    chip.device.faults.empty = EMPTY
    chip.hears(b"\x07")
    assert drivers.received(1) == b"\x07"
    chip.is_alive()


def test_a_stall_and_a_babble_do_not_end_the_port(drivers, chip):
    chip.device.faults.stall_in()
    chip.is_alive()
    chip.device.faults.babble()
    chip.hears(b"\x02")
    assert drivers.do("error") == "BufferOverrunError"
    chip.is_alive()


def test_an_endpoint_that_stalls_for_ever_ends_the_port_once(drivers, chip):
    chip.device.faults.stall_in(1000)
    assert drivers.do("ended") == ["StallError"]


def test_a_break_that_a_copy_ignores_harms_nothing(drivers, chip):
    chip.device.faults.ignore(BREAKS[chip.name])
    drivers.do("signals", signals={"break": True})
    drivers.do("signals", signals={"break": False})
    assert chip.far.breaks == []
    chip.is_alive()


def test_a_break_that_a_copy_refuses_is_an_error_and_harms_nothing(drivers, chip):
    chip.device.faults.stall(BREAKS[chip.name])
    with pytest.raises(Refused, match="ChipError"):
        drivers.do("signals", signals={"break": True})
    chip.is_alive()


def test_bytes_that_a_chip_does_not_take_go_when_it_takes_them(drivers, chip):
    chip.device.faults.hangs_out = True
    drivers.say({"command": "write", "data": [0x02]})
    drivers.until_asked("out")
    drivers.give()
    assert chip.far.data == b""
    chip.device.faults.hangs_out = False
    drivers.until_done()
    assert chip.far.data == b"\x02"
    chip.is_alive()


def test_transfers_of_a_closed_session_that_are_rejected_later_do_no_harm(drivers, chip):
    drivers.keeps_aborted = True
    drivers.do("close")
    drivers.keeps_aborted = False
    chip.open()
    drivers.end_kept()
    chip.is_alive()


def test_a_pull_ends_the_streams_once_and_the_port_can_be_closed(drivers, chip):
    """Transfers that wait are aborted, later calls and `close` rejected: all of it is unplugged."""
    drivers.pull_out()
    assert drivers.do("ended") == ["NetworkError"]
    drivers.do("unplug")
    assert drivers.do("ended") == ["NetworkError"]
    drivers.do("close")
    with pytest.raises(Refused, match="NotFoundError"):
        chip.open()


def test_a_pull_that_the_browser_reports_first_is_one_error_too(drivers, chip):
    drivers.do("unplug")
    drivers.pull_out()
    assert drivers.do("ended") == ["NetworkError"]


def test_a_chip_that_is_back_is_another_device_with_nothing_of_before(drivers, chip):
    chip.hears(ANSWER)
    drivers.pull_out()
    assert drivers.do("ended") == ["NetworkError"]
    chip.plug()
    chip.is_alive()


@pytest.mark.parametrize("chip", FOUR[:1], indirect=True)
def test_a_browser_that_never_closes_the_device_does_not_keep_the_port(drivers, chip):
    drivers.hangs = {"close"}
    drivers.do("close")
    drivers.hangs = set()
    chip.open()
    chip.is_alive()


def test_an_ftdi_that_waits_behind_the_end_of_a_message_has_its_timer_lowered(drivers):
    """As a copy does that acknowledges the event character, and has none."""
    far = Far()
    device = plugged("FT232R", far)
    device.faults.ignore(0x06)
    drivers.insert(device)
    drivers.do("open", options={"baudRate": 9600, "bufferSize": 4096})
    assert device.uart.log[-1] == "latency 16"
    for _ in range(3):
        device.uart.hear(b"\x0d\x54\xac", Settings())
        assert drivers.received(3) == b"\x0d\x54\xac"
    drivers.do("write", data=[0x01])
    assert device.uart.log[-1] == "latency 1"
    drivers.do("close")
