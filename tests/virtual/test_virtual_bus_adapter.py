"""What an adapter makes of the wire: echo, latency timer, packets, no supply (D1)."""

from __future__ import annotations

from math import ceil

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.errors import EchoOnly, NoEcho
from mikas.framing import encode
from mikas.link.virtual import VirtualLink
from mikas.tester import Tester as Client
from mikas.virtual.bus import PACKET, Adapter, AdapterKind
from virtual_harness import make_bus

from .raw_tester import BYTE, RawTester

LAZY = AdapterKind(latency=0.016)


def test_an_adapter_without_echo_gives_the_response_alone():
    tester = RawTester(make_bus(adapter=AdapterKind(echo=False)))
    tester.say(b"\x01\xff\x0d")
    assert tester.listen(1.0) == b"\x0a\xf6\x0d"


def test_without_supply_no_byte_passes():
    bus = make_bus(adapter=AdapterKind(supplied=False))
    tester = RawTester(bus)
    tester.say(b"\x01\xff\x0d")
    bus.send_break(0.05, 0.0)
    assert tester.listen(1.0) == b""
    assert bus.bytes_carried == 0
    with pytest.raises(NoEcho):
        Client(VirtualLink(bus, start=1.0)).connect()


def test_a_unit_without_supply_leaves_the_echo_alone():
    bus = make_bus()
    bus.ecu.responder.car.on = False
    with pytest.raises(EchoOnly):
        Client(VirtualLink(bus)).connect()


def test_the_latency_timer_hands_over_at_its_ticks():
    tester = RawTester(make_bus(adapter=LAZY))
    tester.say(b"\x01\xff\x0d")
    tester.listen(1.0)
    assert tester.data == b"\x01\xff\x0d\x0a\xf6\x0d"
    assert tester.times == [0.016] * 6


def test_a_long_response_arrives_in_packets_and_at_ticks():
    tester = RawTester(make_bus(adapter=LAZY))
    request = encode(b"\x23\x00\x00\xff")
    tester.say(request)
    tester.listen(1.0)
    lumps = [tester.times.count(time) for time in sorted(set(tester.times))]
    assert sum(lumps) == len(tester.heard)
    # 16 ms are 15.4 bytes, so the timer is always first, and no packet gets full.
    assert max(lumps) <= 16
    for time in tester.times:
        assert (time / 0.016) == pytest.approx(round(time / 0.016), abs=1e-6)


def test_a_full_packet_does_not_wait():
    adapter = Adapter(AdapterKind(latency=1.0))
    for count in range(1, 2 * PACKET):
        adapter.receive(count, 0.001 * count)
    assert adapter.collect_received(0.5) == (bytes(range(1, PACKET + 1)), 0.001 * PACKET)
    assert adapter.collect_received(0.999) == (b"", 0.999)
    assert adapter.collect_received(1.0) == (bytes(range(PACKET + 1, 2 * PACKET)), 1.0)


@given(
    gaps=st.lists(st.floats(BYTE, 0.1), max_size=200),
    latency=st.sampled_from([0.0, 0.001, 0.016, 0.255]),
    looks=st.lists(st.floats(0, 0.05), max_size=50),
)
def test_no_byte_is_lost_reordered_early_or_much_too_late(gaps, latency, looks):
    adapter = Adapter(AdapterKind(latency=latency))
    time, pieces, looked = 0.0, [], 0.0
    heard = []
    looks = iter(looks)
    for number, gap in enumerate(gaps):
        time += gap
        if (look := looked + next(looks, 1.0)) < time:
            pieces.append((look, *adapter.collect_received(look)))
            looked = look
        adapter.receive(number & 0xFF, time)
        heard.append(time)
    pieces.append((time + 1, *adapter.collect_received(time + 1)))
    assert b"".join(data for _, data, _ in pieces) == bytes(n & 0xFF for n in range(len(gaps)))
    assert adapter.next_event() > time + 1
    position, before = 0, 0.0
    for looked, data, handed in pieces:
        if data:
            assert before <= handed <= looked
            before = handed
            position += len(data)
            last = heard[position - 1]
            assert last <= handed <= last + latency + 1e-9


@given(latency=st.sampled_from([0.001, 0.016]), time=st.floats(0, 2e9))
def test_a_tick_is_not_before_its_byte(latency, time):
    adapter = Adapter(AdapterKind(latency=latency))
    adapter.receive(1, time)
    assert time <= adapter.next_event() <= (ceil(time / latency) + 1) * latency
    assert adapter.collect_received(adapter.next_event())[0] == b"\x01"


def test_a_break_is_a_byte_of_zeros_at_its_end():
    bus = make_bus(adapter=LAZY)
    tester = RawTester(bus)
    bus.send_break(0.05, 0.0)
    tester.listen(0.2)
    assert tester.data == b"\x00"
    assert tester.times == [pytest.approx(0.064)]
