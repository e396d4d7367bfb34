"""Every model: opened by the requests of Linux' driver, it carries both ways what it should."""

from __future__ import annotations

import struct

import pytest

from usb.book_rig import Far, opened, set_break
from usb.chips.cdc_acm import NOTICE as CDC_NOTICE
from usb.chips.cp210x import KINDS as CP210X
from usb.chips.device import IN, Handshake, Setup
from usb.chips.ftdi import KINDS as FTDI
from usb.chips.named import NAMES, driver_of, plugged
from usb.chips.pl2303 import NOTICE as PL2303_NOTICE
from usb.chips.uart import BREAK, Character, Damage, Settings

OPENABLE = [name for name in NAMES if name != "PL2303 unknown"]  # the kernel refuses that one
BREAKLESS = {"CH340 without break", "PL2303 clone", "CDC ACM without break"}
LISTED = {name for name, kind in CP210X.items() if kind.is_listed}


@pytest.fixture(params=OPENABLE)
def name(request):
    return request.param


@pytest.fixture
def far():
    return Far()


@pytest.fixture
def device(name, far):
    return plugged(name, far, serial="A50285BI")


def payload(name, packet):
    assert isinstance(packet, bytes), packet
    return packet[2:] if name in FTDI else packet


def test_every_rate_becomes_the_one_that_the_driver_asked_for(name, device):
    for rate in (1200, 4800, 9600, 10400, 19200, 38400, 57600, 115200):
        opened(device, name, rate)
        wanted = Settings(14400 if rate == 10400 and name in LISTED else rate)
        assert device.uart.settings.fits(wanted), (rate, device.uart.settings)


def test_9600_baud_is_within_a_fifth_of_a_percent(name, device):
    opened(device, name)
    assert device.uart.settings.rate == pytest.approx(9600, rel=0.002)
    assert (device.uart.dtr, device.uart.rts) == (True, True)


def test_bytes_pass_both_ways(name, device, far):
    host = opened(device, name)
    host.write(b"\x01\xff\x0d")
    assert (far.data, str(far.settings.form)) == (b"\x01\xff\x0d", "8N1")
    device.uart.hear(b"\x01\xff\x0d\x0a\xf6\x0d", Settings())
    assert payload(name, host.read(now=1.0)) == b"\x01\xff\x0d\x0a\xf6\x0d"


def test_a_long_response_comes_in_packets_of_the_endpoint_with_nothing_lost(name, device):
    host = opened(device, name)
    data = bytes(range(200))
    device.uart.hear(data, Settings())
    found, now = b"", 0.0
    while len(found) < len(data):
        now += 1
        packet = host.read(now)
        assert len(packet) <= device.endpoint(host.bulk(IN)).size
        found += payload(name, packet)
    assert found == data


def test_the_rate_not_set_right_leaves_garbage(name, device):
    host = opened(device, name, 19200)
    device.uart.hear(b"\x01\xff\x0d" * 12, Settings(9600))
    assert b"\x01\xff\x0d" not in payload(name, host.read(now=1.0))


def test_a_break_reaches_the_line_but_for_the_chips_that_know_none(name, device, far):
    host = opened(device, name)
    if name in BREAKLESS:
        with pytest.raises(AssertionError, match="STALL"):
            set_break(host, name, on=True)
        assert far.breaks == []
        return
    set_break(host, name, on=True)
    host.write(b"\x01")
    set_break(host, name, on=False)
    host.write(b"\x02")
    assert (far.breaks, far.data) == ([True, False], b"\x02")


def test_the_descriptors_are_whole(name, device):
    def get(kind, number=0, length=255):
        return device.control(Setup(0x80, 6, kind << 8 | number, 0, length))

    head = get(1)
    assert (len(head), head[:2]) == (18, b"\x12\x01")
    assert struct.unpack_from("<H", head, 8)[0] == device.identity.vid
    configuration = get(2, length=9)
    whole = get(2, length=struct.unpack_from("<H", configuration, 2)[0])
    assert whole[:9] == configuration
    parts, at = [], 0
    while at < len(whole):
        parts.append(whole[at + 1])
        at += whole[at]
    assert at == len(whole)
    assert parts.count(4) == len(device.interfaces)
    assert parts.count(5) == len(device.endpoints)
    assert get(3, 3)[2:].decode("utf-16-le") == "A50285BI"
    assert get(3, 9) is get(0x0F) is Handshake.STALL


def test_a_request_that_the_chip_does_not_know_stalls(name, device):
    for kind in (0x40, 0xC0, 0x41, 0xC1, 0x21, 0xA1):
        assert device.control(Setup(kind, 0x77, 0, 0, 8)) is Handshake.STALL


# -- errors of the line, where a chip reports them -------------------------------------------------

HURT = [Character(0x55), Character(0x01, Damage.FRAMING), Character(0x02, Damage.OVERRUN), BREAK]


def reported(name, device, host):
    """Return the flags of `HURT` as this chip reports them: break, framing, overrun."""
    device.uart.receive(HURT)
    match driver_of(name):
        case "ftdi_sio":
            status = host.read(now=1.0)[1]
            return bool(status & 0x10), bool(status & 0x08), bool(status & 0x02)
        case "cp210x":
            host.read()
            errors = host.get(0xC1, 0x10, 0, 0, 19)[0]
            assert host.get(0xC1, 0x10, 0, 0, 19)[0] == 0  # read once
            return bool(errors & 0x01), bool(errors & 0x02), bool(errors & 0x04)
        case "pl2303" | "cdc_acm":
            notice = host.notice(PL2303_NOTICE if driver_of(name) == "pl2303" else CDC_NOTICE)
            assert notice[:2] == b"\xa1\x20"
            return bool(notice[8] & 0x04), bool(notice[8] & 0x10), bool(notice[8] & 0x40)


def test_errors_of_the_line_are_reported_by_all_but_the_ch340(name, device):
    host = opened(device, name)
    assert reported(name, device, host) == (
        None if driver_of(name) == "ch341" else (True, True, True)
    )
