"""Telnet's bytes: nothing is lost or invented, however they are cut, and odd servers are read."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from mikas.link.network.telnet import (
    IAC,
    MOST_SUBNEGOTIATION,
    SE,
    Negotiation,
    Subnegotiation,
    TelnetDecoder,
    Verb,
    escaped,
    negotiation,
    subnegotiation,
)

COM_PORT = 44
options = st.integers(0, 255)
talk = st.one_of(
    st.builds(Negotiation, st.sampled_from(Verb), options),
    st.builds(Subnegotiation, options, st.binary(max_size=20)),
)
# A NUL after a carriage return is not told from the server's own: see the tests of CR NUL.
payload = st.binary(max_size=40).map(lambda data: data.replace(b"\r\0", b"\r\1"))


def on_the_wire(part: bytes | Negotiation | Subnegotiation) -> bytes:
    match part:
        case Negotiation(verb, option):
            return negotiation(verb, option)
        case Subnegotiation(option, data):
            return bytes([IAC, 0xFA]) + escaped(bytes([option]) + data) + bytes([IAC, SE])
        case _:
            return escaped(part)


def fed(wire: bytes, cuts: list[int], decoder: TelnetDecoder | None = None) -> tuple[bytes, list]:
    decoder = decoder or TelnetDecoder(COM_PORT)
    data, events = b"", []
    ends = sorted({min(cut, len(wire)) for cut in cuts} | {0, len(wire)})
    for begin, end in pairwise(ends):
        more, said = decoder.feed(wire[begin:end])
        data += more
        events += said
    return data, events


@given(st.lists(st.one_of(payload, talk), max_size=12), st.lists(st.integers(0, 400)))
def test_data_and_talk_come_apart_unchanged_however_they_are_cut(parts, cuts):
    wire = b"".join(map(on_the_wire, parts))
    data = b"".join(part for part in parts if isinstance(part, bytes))
    if b"\r\0" in data:  # made by two parts
        return
    assert fed(wire, cuts) == (data, [part for part in parts if not isinstance(part, bytes)])


@given(st.binary(max_size=300), st.lists(st.integers(0, 300)))
def test_any_bytes_mean_the_same_however_they_are_cut(wire, cuts):
    assert fed(wire, cuts) == fed(wire, [])


@given(st.binary(max_size=300), st.lists(st.integers(0, 300)))
def test_a_server_that_does_not_double_ff_gives_its_bytes_unchanged(data, cuts):
    decoder = TelnetDecoder(COM_PORT)
    first = decoder.feed(b"\x01\xff\r\x09\xf7\r")[0]  # the echo of `01`, the answer
    assert first == b"\x01\xff\r\x09\xf7\r"
    assert not decoder.doubles_ff
    data = data.replace(b"\xff\xfa\x2c", b"")
    assert fed(data + b"\x00", cuts, decoder)[0] == data + b"\x00"


def test_its_answers_about_the_port_are_still_read():
    decoder = TelnetDecoder(COM_PORT)
    decoder.feed(b"\x01\xff\r")
    wire = b"\xff" + subnegotiation(COM_PORT, b"\x69\x05") + b"\xff\xff\xfb"
    assert decoder.feed(wire) == (b"\xff\xff\xff\xfb", [Subnegotiation(COM_PORT, b"\x69\x05")])


@given(payload.filter(lambda data: b"\xff" not in data), st.lists(st.integers(0, 100)))
def test_a_server_that_adds_nul_to_each_carriage_return_gives_none_of_them(data, cuts):
    decoder = TelnetDecoder(COM_PORT)
    assert decoder.feed(b"\x01\xff\xff\r\0") == (b"\x01\xff\r", [])
    assert fed(data.replace(b"\r", b"\r\0"), cuts, decoder) == (data, [])


def test_a_carriage_return_is_never_held_back():
    assert TelnetDecoder(COM_PORT).feed(b"\x01\xff\xff\r") == (b"\x01\xff\r", [])


def test_a_first_carriage_return_without_nul_settles_it():
    decoder = TelnetDecoder(COM_PORT)
    assert decoder.feed(b"\r\x09\r\0\0\r\0")[0] == b"\r\x09\r\0\0\r\0"


def test_other_commands_are_dropped():
    assert TelnetDecoder(COM_PORT).feed(b"a\xff\xf1b\xff\xf9c") == (b"abc", [])


def test_a_subnegotiation_without_end_ends():
    decoder = TelnetDecoder(COM_PORT)
    decoder.feed(b"\xff\xfa\x2c" + b"x" * MOST_SUBNEGOTIATION)
    assert decoder.feed(b"abc") == (b"abc", [])


def test_to_a_server_of_text_lines_a_carriage_return_goes_with_nul():
    assert escaped(b"\x01\xff\r") == b"\x01\xff\xff\r"
    assert escaped(b"\x01\xff\r", binary=False) == b"\x01\xff\xff\r\0"
