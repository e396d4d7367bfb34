"""The sigrok decoder's framing: equal to the codec, and what only a wire's reader has."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from dissectors.sigrok_rig import BYTE, RATE, loaded
from mikas.framing import Damage, Decoder, Frame, encode

MODULE = loaded()
# Bytes of which frames are made, so that many are whole, damaged, raw or irregular.
WIRE = st.lists(
    st.one_of(
        st.binary(max_size=6).map(encode),
        st.binary(max_size=4).map(lambda body: encode(body, raw_checksum=True)),
        st.sampled_from([b"\x0d", b"\x40", b"\xf3\x0d", b"\xf3\x0d\x0d", b"\x40\x40", b"\0\x0d"]),
        st.binary(max_size=5),
    ),
    max_size=12,
).map(b"".join)  # fmt: skip


def messages(data, *, pauses=()):
    """Return what the decoder's own framing makes of bytes that follow each other."""
    framer, at, found = MODULE.Framer(), 0, []
    for number, value in enumerate(data):
        at += BYTE + (number in pauses) * BYTE
        pause = float(number in pauses) * BYTE / RATE
        found += framer.feed(MODULE.Byte(value, at, at + BYTE, True, pause))
    return found


def shown(event):
    match event:
        case Frame():
            return event.body, event.wire, event.raw_checksum, event.irregular
        case Damage():
            return event.reason.value, event.data
    if event.body is None:
        return event.reason, event.data()
    return event.body, event.data(), event.raw_checksum, event.irregular


@given(WIRE)
def test_framing_is_that_of_the_codec(data):
    assert list(map(shown, messages(data))) == list(map(shown, Decoder().feed(data)))


@given(st.lists(st.sampled_from([0x0D, 0x40, 0xF3, 0, 1, 0xCD]), max_size=40).map(bytes))
def test_framing_is_that_of_the_codec_for_any_few_bytes(data):
    assert list(map(shown, messages(data))) == list(map(shown, Decoder().feed(data)))


def test_a_message_without_end_is_reported_once_and_forgotten(monkeypatch):
    monkeypatch.setitem(vars(MODULE), "LONGEST", 8)
    for size in range(6, 30):
        data = b"\x01\xff\x0d" + b"\x07" * size + b"\x0d" + encode(b"\x02")
        expected = list(map(shown, Decoder(limit=8).feed(data)))
        if size > 8:  # at once it is cut to the limit; byte by byte that is known sooner
            assert expected[1] == ("too long", b"\x07" * 8)
        assert list(map(shown, messages(data))) == expected


@given(st.binary(max_size=8), st.binary(min_size=1, max_size=8), st.integers(0, 255))
def test_a_lost_terminator_costs_its_own_frame_only(first, second, instead):
    lost = encode(first)[:-1] + (b"" if instead == 0x0D else bytes([instead]))
    found = messages(lost + encode(second), pauses={len(lost)})
    assert shown(found[-1])[:2] == (second, encode(second))
    assert shown(found[0]) == ("unfinished", lost)


@given(st.binary(max_size=30))
def test_each_byte_of_a_body_has_its_place_on_the_wire(body):
    (message,) = messages(encode(body))
    at = message.ss
    for value, (ss, es) in zip(body, message.places, strict=True):
        assert (ss, es) == (at, at + BYTE * (1 + (value in (0x0D, 0x40))))
        at = es
