"""A unit that ignores a request too soon after its response (`least_pause`, D14)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.framing import encode
from mikas.virtual.quirks import EcuQuirks
from virtual_harness import DATA, make_bus

from .raw_tester import BYTE, TURN, RawTester

REQUEST = encode(b"\x01")
RESPONSE = encode(b"\x0a")
EXCHANGE = 6 * BYTE + TURN + 1e-6  # s from the request's first bit to the response's last


def a_tester(**options: str) -> RawTester:
    return RawTester(make_bus(quirks=EcuQuirks().with_options(options)))


def test_a_request_too_soon_after_a_response_is_ignored():
    tester = a_tester(least_pause="0.1")
    events = []
    tester.bus.ecu.watcher = events.append
    assert tester.ask(b"\x01") == RESPONSE  # the first one
    tester.say(REQUEST)
    tester.listen(tester.now + EXCHANGE)
    answered = tester.times[-1]
    tester.say(REQUEST, at=answered + 0.0999)
    assert tester.listen(tester.now + 1) == REQUEST  # the echo alone
    assert events[-1].kind == "too-soon"


@given(pauses=st.lists(st.integers(0, 200), min_size=1, max_size=6), least=st.integers(0, 150))
def test_exactly_the_requests_within_the_least_pause_are_ignored(pauses, least):
    """One that is ignored does not begin another pause."""
    tester = a_tester(least_pause=str(least / 1000))
    answered = -1.0
    for pause in pauses:
        begins = tester.now + pause / 1000
        tester.say(REQUEST, at=begins)
        heard = tester.listen(begins + EXCHANGE)
        too_soon = begins - answered < least / 1000 - 1e-9
        assert heard == REQUEST + (b"" if too_soon else RESPONSE)
        if not too_soon:
            answered = tester.times[-1]


def test_a_request_that_begins_within_the_pause_is_ignored_to_its_end():
    tester = a_tester(least_pause="0.1")
    tester.say(REQUEST)
    tester.listen(tester.now + EXCHANGE)
    long = encode(b"\x61" + bytes(DATA))  # 25 ms
    tester.say(long, at=tester.times[-1] + 0.09)  # ends behind the pause
    assert tester.listen(tester.now + 1) == long
    assert tester.ask(b"\x01") == RESPONSE


@pytest.mark.parametrize("stream_end", ["byte", "request"])
def test_a_stream_is_ended_without_a_pause(stream_end):
    tester = a_tester(least_pause="0.1", stream_end=stream_end)
    tester.say(encode(b"\x71\x1a\x29"))
    tester.listen(0.1)
    heard = len(tester.heard)
    while len(tester.heard) == heard or tester.data[-1] != 0x0D:  # to the end of a response
        tester.listen(tester.bus.next_event())
    tester.say(REQUEST)
    assert tester.listen(tester.now + 1.0) == REQUEST + RESPONSE


def test_the_pause_ends_with_the_supply():
    tester = a_tester(least_pause="10")
    assert tester.ask(b"\x01") == RESPONSE
    car = tester.bus.ecu.responder.car
    car.on = False
    tester.say(REQUEST)
    tester.listen(tester.now + 0.1)
    car.on = True
    assert tester.ask(b"\x01") == RESPONSE
