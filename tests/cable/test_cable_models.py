"""Linux' own drivers take every model of `usb.chips` for the chip that it stands for."""

from __future__ import annotations

import pytest

from tester.tester_rig import case
from usb.chips.named import NAMES, driver_of
from usb.chips.uart import Settings

REFUSED = {"PL2303 unknown"}
BREAKLESS = {"PL2303 clone", "CDC ACM without break"}
DRIVERS = ["ftdi_sio", "ch341", "cp210x", "pl2303", "cdc_acm"]
REQUEST = bytes.fromhex("61 29 76 0D")  # FREQ; the line echoes it (D1)


@pytest.mark.parametrize("driver", DRIVERS)
def test_the_driver_opens_reads_and_breaks_as_on_the_chip(box, driver):
    for name in (it for it in NAMES if driver_of(it) == driver and it not in REFUSED):
        with case(name):
            cable = box.cable(chip=name)
            port = f"/dev/{cable.plug()}"
            got = box.guest.exchange(port, REQUEST, len(REQUEST) + 3)
            assert got[: len(REQUEST)] == REQUEST
            assert len(got) == len(REQUEST) + 3
            uart = cable.chip.uart
            assert uart.settings.fits(Settings(9600)), uart.log
            assert any("dtr=1" in it for it in uart.log)
            assert uart.lost == 0
            if name not in BREAKLESS:
                box.guest.send_break(port)
                assert cable.wire.breaks > 0, uart.log
            cable.pull()
