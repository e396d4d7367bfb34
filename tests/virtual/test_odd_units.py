"""Switches of the virtual unit for what a survey finds in a real one, seen from the wire: times
within a response, the form of a checksum it understands, lists by command, other codes.
"""

from __future__ import annotations

from itertools import pairwise

import pytest

from mikas.framing import encode
from mikas.virtual.quirks import EcuQuirks
from mikas.virtual.responder import extra_datum
from virtual_harness import DATA, make_bus

from .raw_tester import BYTE, TURN, RawTester

NO, YES = encode(b"\x01"), encode(b"\x00")
# The checksum of the first is 0D, of the second 40: CREADI of E2 and of AF.
SPECIAL = {b"\x11\xe2": 0x0D, b"\x11\xaf": 0x40}


def a_tester(**options: str) -> RawTester:
    return RawTester(make_bus(quirks=EcuQuirks().with_options(options)))


def codes(count: int) -> bytes:
    return bytes(list(DATA)[:count])


def data(count: int) -> bytes:
    return b"".join(list(DATA.values())[:count])


@pytest.mark.parametrize("accepts", ["stuffed", "raw", "both"])
@pytest.mark.parametrize("body", SPECIAL)
@pytest.mark.parametrize("raw", [False, True])
def test_a_unit_understands_the_form_of_the_checksum_that_it_accepts(accepts, body, raw):
    tester = a_tester(accepts=accepts)
    wire = encode(body, raw_checksum=raw)
    assert wire != encode(body, raw_checksum=not raw)
    tester.say(wire)
    came = tester.listen(1.0)
    assert came.startswith(wire)
    assert bool(came[len(wire) :]) is (accepts in ("both", "raw" if raw else "stuffed"))
    assert tester.ask(b"\x01") == encode(b"\x0a")  # a checksum of another value has one form


@pytest.mark.parametrize("accepts", ["stuffed", "raw"])
def test_a_request_in_the_other_form_does_not_end_a_stream(accepts):
    tester = a_tester(accepts=accepts, stream_end="request", stream_gap="0.1")
    tester.say(encode(b"\x71\x1a"))
    tester.listen(0.03)
    tester.say(encode(b"\x11\xe2", raw_checksum=accepts == "stuffed"))
    tester.listen(0.5)
    assert tester.listen(1.0).count(encode(DATA[0x1A])) >= 3
    tester.listen(tester.heard[-1][0] + 0.001)
    tester.say(encode(b"\x11\xe2", raw_checksum=accepts == "raw"))
    tester.listen(tester.now + 0.1)
    assert tester.listen(tester.now + 0.5) == b""


@pytest.mark.parametrize("inter_byte", [0.001, 0.03, 1.0])
def test_the_bytes_of_a_response_have_their_pauses(inter_byte):
    tester = a_tester(inter_byte=str(inter_byte))
    tester.say(encode(b"\x61" + codes(4)))
    tester.listen(20.0)
    sent = encode(b"\x61" + codes(4))
    times = tester.times[len(sent) :]
    assert tester.data[len(sent) :] == encode(data(4))
    assert times[0] == pytest.approx((len(sent) + 1) * BYTE + TURN)
    for before, after in pairwise(times):
        assert after - before == pytest.approx(BYTE + inter_byte)


def test_a_stream_with_pauses_between_its_bytes_has_whole_responses():
    tester = a_tester(inter_byte="0.005", stream_gap="0.02", stream_load="0")
    tester.say(encode(b"\x71\x1a\x29"))
    tester.listen(1.0)
    wire = encode(DATA[0x1A] + DATA[0x29])
    came = tester.heard[5:]
    assert bytes(value for _, value in came).startswith(wire * 3)
    begins = [time for time, _ in came[:: len(wire)]]
    for before, after in pairwise(begins):
        period = len(wire) * BYTE + (len(wire) - 1) * 0.005 + 0.02
        assert after - before == pytest.approx(period)


def test_a_request_in_a_pause_between_two_bytes_is_a_collision():
    tester = a_tester(inter_byte="0.05")
    tester.say(b"\x01\xff\x0d")
    tester.say(b"\x01\xff\x0d", at=3 * BYTE + TURN + BYTE + 0.01)
    tester.listen(2.0)
    assert tester.data.count(b"\x0a") == 1


def test_the_turn_round_differs_by_the_spread_and_has_its_middle():
    tester = a_tester(turn_round="0.01", turn_round_spread="0.004")
    delays = []
    for _ in range(200):
        begin = tester.now
        assert tester.ask(b"\x01") == encode(b"\x0a")
        delays.append(tester.heard[-3][0] - begin - 4 * BYTE)
    assert min(delays) == pytest.approx(0.006, abs=1e-4)
    assert max(delays) == pytest.approx(0.014, abs=1e-4)
    assert sorted(delays)[100] == pytest.approx(0.01, abs=1e-4)


@pytest.mark.parametrize("name", ["max_list_61", "max_list_64", "max_list_71"])
def test_each_command_with_a_list_has_its_own_limit(name):
    limits = {"61": 9, "64": 9, "71": 9, name[-2:]: 4}
    tester = a_tester(max_list="9", **{name: "4"})
    for count in (4, 5, 9, 10):
        read, stream = data(count), encode(data(count))
        assert tester.ask(b"\x61" + codes(count)) == (
            encode(read) if count <= limits["61"] else b""
        )
        assert tester.ask(b"\x64" + codes(count)) == (YES if count <= limits["64"] else NO)
        for streaming in (b"\x71", b"\x80"):
            came = tester.ask(streaming + codes(count))
            assert came.startswith(stream) is (count <= limits["71"])
            tester.say(b"\xff")  # ends it
            tester.listen(tester.now + 0.2)
    assert tester.ask(b"\x64" + codes(limits["64"])) == YES
    assert tester.ask(b"\x63") == encode(data(limits["64"]))


def test_a_long_list_is_cut_to_the_limit_of_its_command():
    tester = a_tester(max_list_61="3", max_list_71="2", long_list="short")
    assert tester.ask(b"\x61" + codes(5)) == encode(data(3))
    assert tester.ask(b"\x71" + codes(5)).startswith(encode(data(2)) * 2)


def test_a_list_of_64_is_read_whole_however_short_61_is():
    tester = a_tester(max_list_61="1")
    assert tester.ask(b"\x64" + codes(6)) == YES
    assert tester.ask(b"\x63") == encode(data(6))


def test_other_bytes_than_01_answer_an_unknown_request():
    tester = a_tester(unknown="01", unknown_body="7F10", missing="71")
    for body in (b"\x99", b"\x71\x1a", b"\x61\x99"):
        assert tester.ask(body) == encode(b"\x7f\x10")
    assert tester.ask(b"\x62\x99\x00") == NO  # that of a write is D17's
    assert a_tester(unknown_body="7F10").ask(b"\x99") == b""  # `unknown` decides


def test_a_lacking_code_is_unknown_by_each_command():
    tester = a_tester(lacking="1A,29", unknown="01")
    assert tester.ask(b"\x61\x3f") == encode(DATA[0x3F])
    assert tester.ask(b"\x60") == encode(bytes([len(DATA) - 2]))
    for body in (b"\x61\x1a", b"\x61\x3f\x29", b"\x71\x29", b"\x62\x1a\x00", b"\x64\x1a"):
        assert tester.ask(body) == NO


def test_an_extra_code_has_its_size_and_is_constant():
    tester = a_tester(extra="33,34:3,1A:2")
    assert tester.ask(b"\x60") == encode(bytes([len(DATA) + 2]))
    assert tester.ask(b"\x61\x33") == encode(extra_datum(0x33, 1))
    assert tester.ask(b"\x61\x29\x34\x33") == encode(
        DATA[0x29] + extra_datum(0x34, 3) + extra_datum(0x33, 1)
    )
    assert tester.ask(b"\x61\x1a") == encode(extra_datum(0x1A, 2))  # of another size than §4's
    assert tester.ask(b"\x62\x34\x00\x00\x00") == NO  # read-only
    assert tester.ask(b"\x61\x34") == encode(extra_datum(0x34, 3))
    assert len({extra_datum(code, 1) for code in range(256)}) == 256
