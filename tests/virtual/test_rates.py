"""Bytes between two baud rates, seen bit by bit."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from mikas.framing import encode
from mikas.link.virtual import VirtualLink
from mikas.virtual.rates import seen
from virtual_harness import make_bus

BYTES = st.integers(0, 255)
RATES = st.sampled_from([300, 4800, 9600, 10_400, 19_200, 38_400, 115_200])


@given(value=BYTES, rate=RATES)
def test_at_the_same_rate_a_byte_arrives_as_it_is(value, rate):
    assert seen(value, rate, rate) == (value,)


@given(value=BYTES, rate=RATES, error=st.floats(-0.03, 0.03))
def test_a_rate_that_is_3_percent_off_is_near_enough(value, rate, error):
    """As every UART allows: half a bit in ten is 5 %."""
    assert seen(value, 100_000, round(100_000 * (1 + error))) == (value,)


@given(value=BYTES, sent=RATES, heard=RATES)
def test_a_byte_is_received_no_oftener_than_it_has_edges(value, sent, heard):
    """A slow receiver takes its short low levels for no start bit."""
    received = seen(value, sent, heard)
    assert sent > heard or received
    assert len(received) <= 5  # falling edges of ten bits
    assert all(0 <= each <= 255 for each in received)


def test_known_bytes_worked_out_by_hand():
    # Nine low bits of 9600 are the start bit and three and a half of 4800.
    assert seen(0x00, 9600, 4800) == (0xF8,)
    # FF has one low bit, which is two at twice the rate.
    assert seen(0xFF, 9600, 19_200) == (0xFE,)


def test_a_unit_at_another_rate_hears_and_says_something_else():
    bus = make_bus()
    link = VirtualLink(bus)
    assert link.set_baud(19_200)
    link.write(encode(b"\x01"))
    heard = link.read(link.now() + 0.001).data
    while chunk := link.read(link.now() + 0.1).data:
        heard += chunk
    assert heard[:3] == encode(b"\x01")  # the adapter's echo, by itself
    assert not heard[3:]  # the unit has received no request
    link.set_baud(9600)
    link.read(link.now() + 0.2)
    link.write(encode(b"\x01"))
    heard = b""
    while chunk := link.read(link.now() + 0.1).data:
        heard += chunk
    assert heard == encode(b"\x01") + encode(b"\x0a")
