"""The sigrok decoder on both wires of an adapter: the echo, the one response, trust (D1, D13)."""

from __future__ import annotations

from dissectors.sigrok_rig import BYTE, SimulatedSigrok, loaded
from mikas.framing import encode

MODULE = loaded()
TURN = 0.002  # s


def test_on_two_channels_an_echo_that_differs_is_named():
    sigrok = SimulatedSigrok(MODULE)
    for request, echoed in ((b"\x01", b"\x01"), (b"\x61\x1a", b"\x61\x1b")):
        begin = sigrok.at
        for number, (sent, heard) in enumerate(zip(encode(request), encode(echoed), strict=True)):
            at = begin + number * BYTE
            sigrok.feed(bytes([heard]), channel=0, at=at)
            sigrok.feed(bytes([sent]), channel=1, at=at)
        sigrok.wait(TURN)
        sigrok.feed(encode(b"\x0a"), channel=0)
        sigrok.wait(TURN)
    assert len(sigrok.of("echo")) == 2
    orphan = "response, its request is not known"
    assert sigrok.texts("warning") == ["the echo differs: collision?", orphan]
    assert sigrok.texts("request") == ["availability, model", "read parameters: TWAT"]
    assert sigrok.texts("response") == ["Mikas 7.1", orphan]
    assert not sigrok.of("value")


def adapter(exchanges):
    """Return the decoder behind (request, its echo on the wire, response), two wires."""
    sigrok = SimulatedSigrok(MODULE)
    for request, echoed, answer in exchanges:
        begin, wire = sigrok.at, encode(request)
        for number in range(max(len(wire), len(echoed))):
            at = begin + number * BYTE
            sigrok.feed(echoed[number : number + 1], channel=0, at=at)
            sigrok.feed(wire[number : number + 1], channel=1, at=at)
        sigrok.wait(TURN)
        sigrok.feed(encode(answer), channel=0)
        sigrok.wait(TURN)
    return sigrok


SYNCED, OF_LIST = (b"\x01", encode(b"\x01"), b"\x0a"), (b"\x63", encode(b"\x63"), b"\x7d")
SET_LIST = (b"\x64\x1a", encode(b"\x64\x1a"), b"\0")


def test_on_two_channels_a_list_whose_64_had_no_echo_gives_no_values():
    again = (b"\x64\x29", b"", b"\0")
    assert adapter([SYNCED, SET_LIST, OF_LIST]).texts("value") == ["Coolant temperature: TWAT=85°C"]
    assert not adapter([SYNCED, SET_LIST, again, OF_LIST]).of("value")
    assert not adapter([SYNCED, SET_LIST, again, SYNCED, OF_LIST]).of("value")


def test_on_two_channels_a_flipped_bit_of_an_echo_gives_no_value_until_01_is_answered():
    asked, answer = b"\x61\x1a", b"\x7d"
    wire = encode(asked)
    for place in range(len(wire)):
        for bit in range(8):
            heard = wire[:place] + bytes([wire[place] ^ 1 << bit]) + wire[place + 1 :]
            sound = (asked, wire, answer)
            sigrok = adapter([SYNCED, (asked, heard, answer), sound, SYNCED, sound])
            assert len(sigrok.of("value")) == 1


def test_on_two_channels_a_second_response_gives_no_value():
    sigrok = adapter([SYNCED, (b"\x61\x1a", encode(b"\x61\x1a"), b"\x7d")])
    sigrok.feed(encode(b"\x7e"), channel=0)
    assert sigrok.texts("value") == ["Coolant temperature: TWAT=85°C"]
