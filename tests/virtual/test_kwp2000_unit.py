"""The unit that speaks KWP2000, by its own bus: it takes the standard's wake-ups, and no others."""

from __future__ import annotations

import pytest

from mikas import kwp2000
from mikas.link.virtual import VirtualLink
from mikas.virtual.build import build_bus
from mikas.virtual.bus import AdapterKind
from mikas.virtual.kwp2000_unit import KEY_BYTES, Kwp2000Bus, Kwp2000Unit, Wake
from virtual_harness import make_bus

START = kwp2000.encode(kwp2000.START)
STARTED = kwp2000.encode(b"\xc1" + KEY_BYTES, kwp2000.TESTER, kwp2000.ENGINE)


def a_link(wake: Wake = Wake.BOTH, *, baud: int = kwp2000.BAUD) -> VirtualLink:
    bus = Kwp2000Bus(make_bus().ecu, Kwp2000Unit(wake), adapter=AdapterKind(echo=False))
    link = VirtualLink(bus)
    link.set_baud(baud)
    return link


def heard(link: VirtualLink, seconds: float = 0.6) -> bytes:
    data, until = b"", link.now() + seconds
    while chunk := link.read(until).data:
        data += chunk
    return data


def woken_fast(link: VirtualLink, low: float = 0.025, high: float = 0.025) -> bytes:
    link.send_break(low)
    link.gather(link.now() + high)
    link.write(START)
    return heard(link)


def send_address(link: VirtualLink, address: int, bit: float = 0.2) -> None:
    for level in (0, *(address >> place & 1 for place in range(8)), 1):
        if level:
            link.gather(link.now() + bit)
        else:
            link.send_break(bit)


def asked(link: VirtualLink, data: bytes) -> bytes:
    link.gather(link.now() + 0.06)
    link.write(kwp2000.encode(data))
    found = kwp2000.find(heard(link))
    return found.data if found else b""


def test_it_is_asleep_until_it_is_woken_up():
    link = a_link()
    link.write(START)
    assert heard(link) == b""
    assert woken_fast(link) == STARTED
    assert asked(link, kwp2000.PRESENT) == b"\x7e"
    assert asked(link, b"\x1a\x90") == b"\x7f\x1a\x11"  # refused
    assert asked(link, kwp2000.STOP) == b"\xc2"
    assert asked(link, kwp2000.PRESENT) == b""


@pytest.mark.parametrize(
    ("low", "high", "wakes"),
    [
        (0.025, 0.025, True),
        (0.0242, 0.0258, True),
        (0.027, 0.025, True),
        (0.020, 0.030, False),
        (0.030, 0.020, False),
        (0.025, 0.030, False),
        (0.025, 0.020, False),
    ],
)
def test_the_fast_wake_up_has_the_standards_times(low, high, wakes):
    assert (woken_fast(a_link(), low, high) == STARTED) is wakes


def test_the_request_has_to_be_at_10400_baud():
    link = a_link(baud=9600)
    assert woken_fast(link) == b""


@pytest.mark.parametrize(
    ("address", "bit", "wakes"),
    [(0x33, 0.2, True), (0x10, 0.2, True), (0x33, 0.206, True), (0x33, 0.25, False),
     (0x01, 0.2, False), (0xCC, 0.2, False)],
)  # fmt: skip
def test_the_slow_wake_up_is_its_address_at_5_baud(address, bit, wakes):
    link = a_link()
    send_address(link, address, bit)
    assert heard(link, 0.4) == (b"\x55" + KEY_BYTES if wakes else b"")


@pytest.mark.parametrize(("wait", "awake"), [(0.01, False), (0.03, True), (0.06, False)])
def test_after_the_slow_one_the_inverted_key_byte_opens_the_session(wait, awake):
    link = a_link()
    send_address(link, 0x33)
    data = b""
    while len(data) < 3:
        data += link.read(link.now() + 1).data
    link.gather(link.now() + wait)
    link.write(bytes([KEY_BYTES[1] ^ 0xFF]))
    assert heard(link) == (bytes([0x33 ^ 0xFF]) if awake else b"")
    assert asked(link, kwp2000.PRESENT) == (b"\x7e" if awake else b"")


@pytest.mark.parametrize("wake", Wake)
def test_the_setting_says_which_wake_ups_it_takes(wake):
    fast = VirtualLink(build_bus({"protocol": wake.value, "echo": "0"}))
    fast.set_baud(kwp2000.BAUD)
    assert (woken_fast(fast) == STARTED) is (wake is not Wake.SLOW)
    slow = VirtualLink(build_bus({"protocol": wake.value, "echo": "0"}))
    slow.set_baud(kwp2000.BAUD)
    send_address(slow, 0x33)
    assert bool(heard(slow, 0.4)) is (wake is not Wake.FAST)


def test_it_never_answers_a_mikas_request():
    link = a_link(baud=9600)
    for _ in range(5):
        link.write(b"\x01\xff\x0d")
        assert heard(link) == b""
