"""Two talkers at once: the AND of both, a unit that waits its turn, breaks (D2, D12)."""

from __future__ import annotations

from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.framing import encode
from mikas.virtual.bus import AdapterKind, Bus
from mikas.virtual.ecu import VirtualEcu
from mikas.virtual.quirks import EcuQuirks, StreamEnd
from mikas.virtual.responder import Responder
from virtual_harness import DATA, IDENTITY, TableCar, make_bus

from .raw_tester import BYTE, TURN, RawTester

ANSWER_AT = 3 * BYTE + TURN  # the first bit of the response to 01 sent at second 0


def test_two_bytes_at_the_same_time_are_heard_as_their_and():
    tester = RawTester(make_bus())
    tester.say(b"\x01\xff\x0d")
    tester.say(b"\x35", at=ANSWER_AT)
    came = tester.listen(1.0)
    # Both the echo and the response's first byte: each talker's byte, and neither is whole.
    assert came == bytes([0x35 & 0x0A, 0x35 & 0x0A, 0xF6, 0x0D])


@given(into=st.floats(-0.999, 0.999), value=st.integers(0, 255))
def test_bytes_that_overlap_at_all_spoil_each_other(into, value):
    """Said while the response's first byte F0 … is on the wire, or as it begins."""
    tester = RawTester(make_bus())
    tester.say(b"\x01\xff\x0d")
    tester.listen(ANSWER_AT + max(into, 0) * BYTE + 1e-9)
    tester.say(bytes([value]))
    second = into > 0  # then it reaches into the response's second byte too
    tester.listen(1.0)
    heard = tester.data[3:]
    spoilt = value & 0x0A & (0xF6 if second else 0xFF)
    assert sorted(heard[:2]) != [0x0A, value] or spoilt in (0x0A, value)
    assert (0x0A & value) in heard
    assert heard[-1] == 0x0D


def test_a_byte_across_two_bytes_has_something_of_both():
    tester = RawTester(make_bus())
    tester.say(b"\x01\xff\x0d")
    tester.say(b"\xc9", at=ANSWER_AT + BYTE / 2)
    # 0A and F6 end before and after it; the byte said lies over both.
    assert tester.listen(1.0) == bytes([0x0A & 0xC9, 0xC9 & 0x0A & 0xF6, 0xF6 & 0xC9, 0x0D])


def test_bytes_side_by_side_do_not_touch():
    tester = RawTester(make_bus())
    tester.say(b"\x01\xff\x0d")
    tester.say(b"\x00", at=ANSWER_AT + 3 * BYTE + 1e-9)
    tester.listen(1.0)
    assert tester.data[3:] == b"\x0a\xf6\x0d\x00"


def test_without_an_echo_the_tester_hears_only_the_spoilt_response():
    tester = RawTester(make_bus(adapter=AdapterKind(echo=False)))
    tester.say(b"\x01\xff\x0d")
    tester.say(b"\x35", at=ANSWER_AT)
    assert tester.listen(1.0) == bytes([0x35 & 0x0A, 0xF6, 0x0D])


def test_what_the_unit_hears_while_it_talks_is_no_request():
    """Else this would be one: the 01 lies over the response's last byte, the rest behind it."""
    tester = RawTester(make_bus())
    tester.say(b"\x01\xff\x0d")
    tester.say(b"\x01\xff\x0d", at=ANSWER_AT + 2.5 * BYTE)
    came = tester.listen(1.0)
    assert came.count(b"\x0a\xf6") == 1


def test_a_unit_does_not_begin_while_somebody_talks():
    tester = RawTester(make_bus())
    tester.say(b"\x01\xff\x0d")
    tester.say(b"\x99" * 10, at=ANSWER_AT - BYTE / 2)
    tester.listen(1.0)
    assert tester.data[3:13] == b"\x99" * 10  # nothing is spoilt
    assert tester.data[13:] == b"\x0a\xf6\x0d"
    assert tester.times[13] - BYTE == pytest.approx(ANSWER_AT - BYTE / 2 + 10 * BYTE, abs=1e-9)


def test_a_unit_begins_in_the_gap_between_two_bytes():
    tester = RawTester(make_bus())
    tester.say(b"\x01\xff\x0d")
    tester.say(b"\x99", at=ANSWER_AT - BYTE / 2)
    tester.say(b"\x99", at=ANSWER_AT + 3 * BYTE)
    tester.listen(1.0)
    assert tester.times[4] - BYTE == pytest.approx(ANSWER_AT + BYTE / 2, abs=1e-9)


def test_a_stream_waits_for_a_request_that_is_under_way():
    """Single bytes, each with a pause that a stream's response would fit into."""
    tester = RawTester(make_bus(quirks=EcuQuirks(stream_end=StreamEnd.REQUEST)))
    tester.say(encode(b"\x71\x1a"))
    tester.listen(0.1)
    while tester.heard[-1][1] != 0x0D:
        tester.listen(tester.bus.next_event())
    start = len(tester.heard)
    for value in b"\x01\xff\x0d":
        tester.say(bytes([value]))
        tester.listen(tester.now + 0.03)
    tester.listen(tester.now + 0.5)
    assert tester.data[start:] == b"\x01\xff\x0d\x0a\xf6\x0d"


def test_a_stream_that_any_byte_ends_still_ends_its_response():
    tester = RawTester(make_bus())
    tester.say(encode(b"\x71" + bytes(DATA)))
    frame = encode(b"".join(DATA.values()))
    request = len(encode(b"\x71" + bytes(DATA)))
    middle = (request + 10) * BYTE + TURN
    tester.say(b"\xff", at=middle + BYTE / 4)  # FF spoils nothing
    tester.listen(1.0)
    assert len(tester.data) == request + len(frame) + 1


# Breaks


def test_a_break_cuts_the_bytes_on_the_wire():
    tester = RawTester(make_bus())
    tester.say(encode(b"\x51"))
    tester.listen(3 * BYTE + TURN + 4.5 * BYTE)
    assert len(tester.heard) == 7
    tester.bus.send_break(0.05, tester.now)
    broken_at = tester.now
    tester.listen(1.0)
    assert tester.heard[7:] == [(pytest.approx(broken_at + 0.05), 0x00)]
    assert tester.ask(b"\x01") == b"\x0a\xf6\x0d"


def test_a_break_takes_away_an_answer_that_is_due():
    tester = RawTester(make_bus())
    tester.say(b"\x01\xff\x0d")
    tester.listen(ANSWER_AT - TURN / 2)
    tester.bus.send_break(0.001, tester.now)
    assert tester.listen(1.0) == b"\x00"


def test_a_break_without_an_echo_is_not_heard():
    tester = RawTester(make_bus(adapter=AdapterKind(echo=False)))
    tester.bus.send_break(0.05, 0.0)
    assert tester.listen(1.0) == b""


def test_bytes_sent_during_a_break_follow_it():
    tester = RawTester(make_bus())
    tester.bus.send_break(0.05, 0.0)
    tester.say(b"\x01\xff\x0d", at=0.01)
    assert tester.listen(1.0) == b"\x00\x01\xff\x0d\x0a\xf6\x0d"
    assert tester.times[1] == pytest.approx(0.05 + BYTE)


class SwitchedOff(TableCar):
    """A car whose key is turned at second `off`."""

    def __init__(self, off: float) -> None:
        super().__init__(DATA, rpm=850)
        self._off = off

    def powered(self, now: float) -> bool:
        return now < self._off

    def next_change(self, after: float) -> float:
        return self._off if after < self._off else inf

    def bus(self, latency: float) -> Bus:
        ecu = VirtualEcu(Responder(self, IDENTITY, EcuQuirks()))
        return Bus(ecu, adapter=AdapterKind(latency=latency))


talk = st.lists(
    st.tuples(
        st.floats(0, 0.04),
        st.sampled_from([b"", None, b"\x35", encode(b"\x61\x1a"), encode(b"\x71\x1a\x29\x2c")]),
    ),
    max_size=20,
)


@given(talk=talk, latency=st.sampled_from([0.0, 0.016]), off=st.floats(0, 0.3))
def test_bytes_of_a_response_that_come_together_are_those_one_by_one(talk, latency, off):
    """`_deliver_rest` is for speed only. `talk`: pauses and bytes; None: a break."""
    together, singly = (SwitchedOff(off).bus(latency) for _ in range(2))
    singly._deliver_rest = lambda until: None  # noqa: SLF001
    now = 0.0
    for pause, data in [(0.0, encode(b"\x71\x1a\x29\x2c")), *talk, (0.3, b"")]:
        now += pause
        for bus in (together, singly):
            bus.send(data, now) if data is not None else bus.send_break(0.004, now)
        assert together.collect_received(now) == singly.collect_received(now)
        assert together.next_event() == singly.next_event()
        assert together.bytes_carried == singly.bytes_carried
