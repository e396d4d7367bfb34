"""The page's drivers over each model: what they set is what the chip then does."""

from __future__ import annotations

import pytest

from usb.book_rig import Far
from usb.chips.cdc_acm import KINDS as CDC_ACM
from usb.chips.ch34x import KINDS as CH34X
from usb.chips.cp210x import KINDS as CP210X
from usb.chips.ftdi import KINDS as FTDI
from usb.chips.named import NAMES, plugged
from usb.chips.uart import Form, Settings
from usb.page import node_rig

OPENABLE = [name for name in NAMES if name != "PL2303 unknown"]
LISTED = {name for name, kind in CP210X.items() if kind.is_listed or name == "CP2108"}
BREAKLESS = {"PL2303 clone", "CDC ACM without break"}
SIMULATED = "CH340 without break"
REQUEST, ANSWER = b"\x01\xff\x0d", bytes(range(1, 201))
RATES = (1200, 4800, 9600, 10400, 19200, 38400, 57600, 115200)

pytestmark = pytest.mark.realtime


@pytest.fixture
def far():
    return Far()


def opened(drivers, name, far, **options):
    """Plug a chip in and open it; return the model, the rate and the granularity."""
    device = plugged(name, far, serial="A50285BI")
    drivers.insert(device)
    rate, granularity = drivers.do("open", options={"baudRate": 9600, "bufferSize": 4096} | options)
    return device, rate, granularity


def family_of(name: str) -> str:
    for family, kinds in (
        ("ftdi", FTDI),
        ("ch34x", CH34X),
        ("cp210x", CP210X),
        ("cdc-acm", CDC_ACM),
    ):
        if name in kinds:
            return family
    return "pl2303"


@pytest.mark.parametrize("name", OPENABLE)
def test_a_chip_has_its_driver_and_carries_bytes_both_ways(drivers, far, name):
    assert drivers.insert(plugged(name, far)) == family_of(name)
    device, _, granularity = opened(drivers, name, far)
    assert granularity == (0.016 if family_of(name) == "ftdi" else 0.001)
    drivers.do("write", data=list(REQUEST))
    assert (far.data, str(far.settings.form)) == (REQUEST, "8N1")
    device.uart.hear(ANSWER, Settings())
    assert drivers.received(len(ANSWER)) == ANSWER
    device.uart.hear(b"\x07", Settings())  # not held back until a packet is full
    assert drivers.received(1) == b"\x07"
    drivers.do("close")


@pytest.mark.parametrize("name", OPENABLE)
def test_the_rate_that_a_driver_says_is_the_one_that_the_chip_makes(drivers, far, name):
    for baud in RATES:
        device, rate, _ = opened(drivers, name, far, baudRate=baud)
        made = device.uart.settings.rate
        assert rate == pytest.approx(made, rel=2e-3), baud
        wanted = 14400 if baud == 10400 and name in LISTED else baud
        assert Settings(rate).fits(Settings(wanted)), (baud, rate)
        drivers.do("close")


@pytest.mark.parametrize("name", OPENABLE)
def test_signals_and_a_break_reach_the_wire(drivers, far, name):
    device, _, _ = opened(drivers, name, far)
    drivers.do("signals", signals={"dataTerminalReady": True, "requestToSend": False})
    assert (device.uart.dtr, device.uart.rts) == (True, False)
    drivers.do("signals", signals={"requestToSend": True})
    assert (device.uart.dtr, device.uart.rts) == (True, True)
    if name in BREAKLESS:
        with pytest.raises(node_rig.Refused, match="ChipError"):
            drivers.do("signals", signals={"break": True})
    else:
        drivers.do("signals", signals={"break": True})
        drivers.do("signals", signals={"break": False})
        if name == SIMULATED:
            assert far.data == b"\0"
            assert far.settings.rate < 50
        else:
            assert far.breaks == [True, False]
    drivers.do("write", data=list(REQUEST))
    assert far.data.endswith(REQUEST)
    assert far.settings.fits(Settings())
    drivers.do("close")


@pytest.mark.parametrize("name", OPENABLE)
def test_other_lines_than_8n1_are_set_or_refused(drivers, far, name):
    options = {"dataBits": 7, "parity": "even", "stopBits": 2}
    if name in {"CH340 old", "CH341 old"}:
        with pytest.raises(node_rig.Refused, match="NotSupportedError"):
            opened(drivers, name, far, **options)
        return
    device, _, _ = opened(drivers, name, far, **options)
    assert device.uart.settings.form == Form(7, "E", 2)
    drivers.do("close")


@pytest.mark.parametrize("name", ["FT232R", "CP2102", "PL2303HX", "CH343"])
def test_an_error_of_the_wire_is_reported_and_bytes_go_on(drivers, far, name):
    device, _, _ = opened(drivers, name, far)
    device.uart.hear(b"\x00", Settings(rate=4800))
    assert drivers.do("error") in {"FramingError", "BreakError"}
    device.uart.take(64)
    device.uart.hear(ANSWER, Settings())
    while drivers.received(1) != ANSWER[:1]:
        pass
    assert drivers.received(len(ANSWER) - 1) == ANSWER[1:]
    drivers.do("close")


def test_a_port_that_is_closed_can_be_opened_again(drivers, far):
    device, _, _ = opened(drivers, "FT232R", far)
    for _ in range(3):
        drivers.do("close")
        drivers.do("open", options={"baudRate": 9600})
    device.uart.hear(ANSWER, Settings())
    assert drivers.received(len(ANSWER)) == ANSWER
    drivers.do("close")


def test_an_unknown_version_of_a_chip_is_refused(drivers, far):
    with pytest.raises(node_rig.Refused, match="NotSupportedError"):
        opened(drivers, "PL2303 unknown", far)
