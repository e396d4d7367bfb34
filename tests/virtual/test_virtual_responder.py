"""The exchange vectors from the unit's side: byte for byte on the wire, echo included (§2, §3)."""

from __future__ import annotations

import pytest

from mikas.framing import encode
from mikas.virtual.bus import AdapterKind
from mikas.virtual.quirks import EcuQuirks
from virtual_harness import EXCHANGES, make_bus

from .raw_tester import RawTester


def hexed(text: str | None) -> bytes:
    return bytes.fromhex(text or "")


@pytest.mark.parametrize("echo", [True, False])
def test_every_exchange_of_the_vectors_is_answered_in_sequence(echo):
    tester = RawTester(make_bus(adapter=AdapterKind(echo=echo)))
    for exchange in EXCHANGES:
        request, answer = hexed(exchange["request_wire"]), hexed(exchange["answer_wire"])
        tester.say(request)
        came = tester.listen(tester.now + 0.5)
        assert came == (request if echo else b"") + answer, exchange["why"]


def test_every_exchange_is_answered_with_raw_checksums_in_both_directions():
    tester = RawTester(make_bus(quirks=EcuQuirks(raw_checksum=True)))
    raw = 0
    for exchange in EXCHANGES:
        request = encode(hexed(exchange["request"]), raw_checksum=True)
        answer = exchange["answer"]
        expected = b"" if answer is None else encode(hexed(answer), raw_checksum=True)
        tester.say(request)
        assert tester.listen(tester.now + 0.5) == request + expected, exchange["why"]
        raw += request != hexed(exchange["request_wire"])
        raw += expected != hexed(exchange["answer_wire"])
    # 0D 40 and CREADI of F5 are made for this, should the vectors have none.
    for body in (b"\x11\xe2", b"\x11\xaf"):
        request = encode(body, raw_checksum=True)
        assert request != encode(body)
        tester.say(request)
        came = tester.listen(tester.now + 0.5)
        assert came[: len(request) + 1] == request + body[1:2]


def test_a_raw_checksum_in_a_response_is_not_stuffed():
    """61 with two data that sum to F3 and to C0: their checksums are 0D and 40."""
    for value, check in ((0xF3, b"\x0d"), (0xC0, b"\x40")):
        for raw in (False, True):
            tester = RawTester(make_bus(quirks=EcuQuirks(raw_checksum=raw)))
            assert tester.ask(bytes([0x62, 0x1A, value])) == b"\x00\x00\x0d"
            stuffed = b"\x40\xcd" if check == b"\x0d" else b"\x40\x00"
            expected = bytes([value]) + (check if raw else stuffed) + b"\x0d"
            assert tester.ask(b"\x61\x1a") == expected


def test_a_unit_understands_both_forms_whatever_it_sends():
    for sends_raw in (False, True):
        tester = RawTester(make_bus(quirks=EcuQuirks(raw_checksum=sends_raw)))
        for body in (b"\x11\xe2", b"\x11\xaf"):
            for raw in (False, True):
                request = encode(body, raw_checksum=raw)
                tester.say(request)
                assert tester.listen(tester.now + 0.5) != request
