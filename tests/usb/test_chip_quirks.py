"""What is particular to single chips, and the faults that can be set on any."""

from __future__ import annotations

import pytest

from usb.book_rig import Far, Host, opened
from usb.chips.device import IN, Handshake, Setup
from usb.chips.named import plugged
from usb.chips.uart import Character, Damage, Settings


@pytest.fixture
def far():
    return Far()


def hear(device, data=b"123"):
    device.uart.hear(data, Settings())


# -- FTDI ------------------------------------------------------------------------------------------


def test_an_ftdi_sends_two_bytes_of_status_whenever_its_timer_runs_out(far):
    device = plugged("FT232R", far)
    host = Host(device)
    assert host.read(now=1.0) == b"\x11\x60"
    assert host.read(now=1.010) is Handshake.NAK
    assert device.wake_at(1.010) == pytest.approx(1.016)
    assert host.read(now=1.016) == b"\x11\x60"


def test_an_ftdi_gives_a_full_packet_at_once_and_holds_a_short_one_until_the_timer(far):
    device = plugged("FT232R", far)
    host = opened(device, "FT232R")
    host.set(0x40, 0x09, 16)
    host.read(now=1.0)
    hear(device, bytes(70))
    assert len(host.read(now=1.001)) == 64
    assert host.read(now=1.002) is Handshake.NAK
    assert host.read(now=1.017)[2:] == bytes(8)
    host.set(0x40, 0x09, 1)
    hear(device)
    assert host.read(now=1.034)[2:] == b"123"
    hear(device)
    assert host.read(now=1.035)[2:] == b"123"


@pytest.mark.parametrize("kind", ["FT232AM", "FT232R"])
def test_an_ftdi_gives_what_it_has_with_its_event_character(far, kind):
    device = plugged(kind, far)
    host = opened(device, kind)
    host.read(now=1.0)
    host.set(0x40, 0x06, 0x010D)
    hear(device, b"12")
    assert host.read(now=1.0001) is Handshake.NAK
    hear(device, b"\r")
    assert device.wake_at(1.0002) == 1.0002
    assert host.read(now=1.0002)[2:] == b"12\r"
    assert host.read(now=1.0003) is Handshake.NAK
    host.set(0x40, 0x06, 0x000D)
    hear(device, b"\r")
    assert host.read(now=1.0004) is Handshake.NAK


def test_the_oldest_ftdi_has_no_timer_to_set(far):
    host = Host(plugged("FT232AM", far))
    assert host.ask(0xC0, 0x0A) is Handshake.STALL
    with pytest.raises(AssertionError):
        host.set(0x40, 0x09, 1)


def test_the_third_bit_of_the_fraction_has_its_place_by_chip(far):
    """9600 needs 312.5: no third bit. 10400 needs 288.5 (4 eighths); 20000 needs 150; 3/8 is 4."""
    for name, index in (("FT232R", 0x0001), ("FT231X", 0x0101)):
        device = plugged(name, far)
        device.control(Setup(0x40, 0x03, 312, index))
        assert device.uart.settings.rate == pytest.approx(3e6 / 312.375), name


@pytest.mark.parametrize(("value", "rate"), [(0, 3_000_000), (1, 2_000_000), (0x4138, 9600)])
def test_the_least_divisors_stand_for_others(far, value, rate):
    device = plugged("FT232R", far)
    device.control(Setup(0x40, 0x03, value, 0))
    assert device.uart.settings.rate == rate


def test_the_ports_of_a_double_chip_are_apart(far):
    device = plugged("FT2232C", far)
    host = opened(device, "FT2232C")
    device.control(Setup(0x40, 0x03, 0x4138, 2))
    assert device.uarts[1].settings.rate == 9600
    device.uarts[1].hear(b"x", Settings())
    assert host.read(now=1.0) == b"\x11\x60"
    assert device.packet(host.bulk(IN, 1), 1.0) == b"\x11\x60x"
    assert device.out(host.bulk(0, 1), b"lost") is None
    assert far.data == b""


# -- CH340 -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "at_once"), [("CH340", 0x80), ("CH340 old", 0x00), ("CH341 old", 0x00)]
)
def test_bit_7_of_the_prescaler_means_the_opposite_on_old_chips(far, name, at_once):
    device = plugged(name, far)
    host = opened(device, name)
    hear(device)
    assert host.read() == b"123"
    host.set(0x40, 0x9A, 0x1312, 0xB202 | at_once ^ 0x80)
    hear(device)
    assert host.read() is Handshake.NAK
    hear(device, bytes(32))
    assert len(host.read()) == 32
    host.set(0x40, 0x9A, 0x1312, 0xB202 | at_once)
    assert host.read() == bytes(3)


def test_the_line_of_the_oldest_ch34x_is_always_8n1(far):
    device = plugged("CH341 old", far)
    host = opened(device, "CH341 old")
    host.set(0x40, 0x9A, 0x2518, 0x00CA)
    assert str(device.uart.settings.form) == "8N1"
    new = plugged("CH341", far)
    opened(new, "CH341").set(0x40, 0x9A, 0x2518, 0x00DA)
    assert str(new.uart.settings.form) == "7E1"


def test_the_rate_and_the_line_of_a_ch34x_in_one_request(far):
    device = plugged("CH340", far)
    Host(device).set(0x40, 0xA1, 0xC39C, 0xB282)
    assert device.uart.log == ["9615 8N1"]


def test_a_ch340_is_mute_until_sender_and_receiver_are_on(far):
    device = plugged("CH340", far)
    host = opened(device, "CH340")
    host.set(0x40, 0x9A, 0x2518, 0x0003)
    host.write(b"x")
    hear(device, bytes(40))
    assert (far.data, host.read()) == (b"", Handshake.NAK)


# -- CP210x ----------------------------------------------------------------------------------------


def test_a_cp2102_makes_14400_of_10400_and_a_cp2104_does_not(far):
    for name, rate in (("CP2102", 14400), ("CP2104", pytest.approx(10400, rel=0.001))):
        device = plugged(name, far)
        Host(device).set(0x41, 0x1E, data=(10400).to_bytes(4, "little"))
        assert device.uart.settings.rate == rate


def test_nothing_passes_a_cp210x_until_its_port_is_enabled(far):
    device = plugged("CP2102", far)
    host = opened(device, "CP2102")
    host.set(0x41, 0x00, 0)
    host.write(b"x")
    hear(device)
    assert (far.data, host.read()) == (b"", Handshake.NAK)


def test_a_cp210x_that_strips_zeros_loses_them(far):
    device = plugged("CP2102", far)
    host = opened(device, "CP2102")
    host.set(0x41, 0x13, data=bytes((0, 0, 0, 0, 8)) + bytes(11))
    hear(device, b"\x01\x00\x02")
    assert host.read() == b"\x01\x02"
    host.set(0x41, 0x13, data=bytes(16))
    hear(device, b"\x01\x00\x02")
    assert host.read() == b"\x01\x00\x02"


def test_a_cp210x_embeds_the_errors_and_escapes_the_escape(far):
    device = plugged("CP2102", far)
    host = opened(device, "CP2102")
    host.set(0x41, 0x15, 0xEC)
    device.uart.receive([Character(0xEC), Character(0x41, Damage.FRAMING), Character(0x42)])
    assert host.read() == bytes.fromhex("EC 00 EC 01 08 41 42")
    host.set(0x41, 0x15, 0)
    hear(device, b"\xec")
    assert host.read() == b"\xec"


def test_embedded_errors_that_overfill_a_packet_go_on_in_the_next(far):
    device = plugged("CP2102", far)
    host = opened(device, "CP2102")
    host.set(0x41, 0x15, 0xEC)
    hear(device, b"\xec" * 40)
    assert host.read() + host.read() == b"\xec\x00" * 40


def test_the_cp2108_gives_the_line_control_with_its_bytes_swapped(far):
    host = Host(plugged("CP2108", far))
    host.set(0x41, 0x03, 0x0800, 3)
    assert host.get(0xC1, 0x04, 0, 3, 2) == b"\x08\x00"
    assert host.ask(0xC1, 0x04, 0, 4, 2) is Handshake.STALL  # it has four


# -- PL2303 ----------------------------------------------------------------------------------------


def test_a_pl2303hx_goes_to_9600_where_the_number_is_none_of_its_rates(far):
    device = plugged("PL2303HX", far)
    host = opened(device, "PL2303HX")
    host.set(0x21, 0x20, data=(10400).to_bytes(4, "little") + b"\x00\x00\x08")
    assert device.uart.settings.rate == 9600


def test_a_pl2303_needs_the_start_up_of_its_type(far):
    device = plugged("PL2303 01", far)
    host = opened(device, "PL2303 01")
    host.set(0x40, 0x01, 2, 0x44)  # that of an HX
    host.write(b"x")
    hear(device)
    assert (far.data, host.read()) == (b"", Handshake.NAK)


def test_an_hxn_is_known_by_refusing_the_old_request(far):
    assert Host(plugged("PL2303GC", far)).ask(0xC0, 0x01, 0x8080, 0, 1) is Handshake.STALL
    assert Host(plugged("PL2303TA", far)).get(0xC0, 0x01, 0x8080, 0, 1)


# -- CDC ACM ---------------------------------------------------------------------------------------


def test_a_break_of_some_milliseconds_ends_by_itself(far):
    device = plugged("CH343", far)
    opened(device, "CH343").set(0x21, 0x23, 100)
    assert far.breaks == [True, False]


# -- faults ----------------------------------------------------------------------------------------


def test_a_request_can_stall_or_hang(far):
    device = plugged("CH340", far)
    host = Host(device)
    device.faults.stall(0x5F)
    assert host.ask(0xC0, 0x5F, 0, 0, 2) is Handshake.STALL
    device.faults.hang(0x5F)
    assert host.ask(0xC0, 0x5F, 0, 0, 2) is Handshake.NAK
    device.faults.forgive()
    assert host.get(0xC0, 0x5F, 0, 0, 2) == b"\x31\x00"


def test_a_request_can_be_acknowledged_and_ignored(far):
    device = plugged("PL2303HX", far)
    host = opened(device, "PL2303HX")
    device.faults.ignore(0x23)
    host.set(0x21, 0x23, 0xFFFF)
    assert far.breaks == []
    device.faults.forgive()
    host.set(0x21, 0x23, 0xFFFF)
    assert far.breaks == [True]


def test_a_halted_endpoint_stalls_until_the_host_clears_it_and_keeps_the_data(far):
    device = plugged("CP2102", far)
    host = opened(device, "CP2102")
    device.faults.stall_in()
    hear(device)
    assert host.read() is host.read() is Handshake.STALL
    assert host.get(0x82, 0, 0, host.bulk(IN), 2) == b"\x01\x00"
    host.set(0x02, 1, 0, host.bulk(IN))
    assert host.read() == b"123"


def test_a_babbling_endpoint_sends_more_than_its_size_once(far):
    device = plugged("CP2102", far)
    host = opened(device, "CP2102")
    device.faults.babble()
    hear(device)
    assert len(host.read()) > 64
    hear(device)
    assert host.read() == b"123"


def test_data_that_never_come_or_are_never_taken(far):
    device = plugged("CP2102", far)
    host = opened(device, "CP2102")
    device.faults.hangs_in = device.faults.hangs_out = True
    hear(device)
    assert host.read() is device.out(host.bulk(0), b"x") is Handshake.NAK
    device.faults.hangs_in = device.faults.hangs_out = False
    device.faults.empty = 2
    assert [host.read(), host.read(), host.read()] == [b"", b"", b"123"]
