"""Messages of KWP2000 (ISO 14230-2), against bytes that the standard and other programs give."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas import kwp2000

DATA = st.binary(min_size=1, max_size=63)
ADDRESS = st.integers(0, 255)


def test_known_messages():
    assert kwp2000.encode(kwp2000.START) == bytes.fromhex("81 10 F1 81 03")
    answer = bytes.fromhex("83 F1 11 C1 EF 8F C4")
    assert kwp2000.decode(answer) == (b"\xc1\xef\x8f", 0xF1, 0x11, 7)
    assert kwp2000.decode(bytes.fromhex("81 F1 11 7E 01")) == (b"\x7e", 0xF1, 0x11, 5)
    # without addresses, and with a length of its own
    assert kwp2000.decode(bytes.fromhex("03 C1 EF 8F 42")) == (b"\xc1\xef\x8f", None, None, 5)
    assert kwp2000.decode(bytes.fromhex("80 F1 10 01 7E 00")) == (b"\x7e", 0xF1, 0x10, 6)


@given(data=DATA, target=ADDRESS, source=ADDRESS, rest=st.binary(max_size=8))
def test_what_is_encoded_is_decoded_whatever_follows(data, target, source, rest):
    wire = kwp2000.encode(data, target, source)
    assert kwp2000.decode(wire + rest) == (data, target, source, len(wire))


@given(data=DATA, cut=st.integers(0, 70))
def test_a_cut_message_is_none(data, cut):
    wire = kwp2000.encode(data)
    assert (kwp2000.decode(wire[:cut]) is None) == (cut < len(wire))


@given(data=DATA, place=st.integers(0, 66), flip=st.integers(1, 255))
def test_a_damaged_byte_is_found_by_the_sum(data, place, flip):
    wire = bytearray(kwp2000.encode(data))
    if place < len(wire):
        wire[place] ^= flip
        found = kwp2000.decode(bytes(wire))
        # A header that says another length may end at a byte that happens to be the sum there.
        assert found is None or (place == 0 and found.data != data)


@given(noise=st.binary(max_size=40))
def test_any_bytes_are_taken(noise):
    found = kwp2000.find(noise)
    assert found is None or found.data in noise


@pytest.mark.parametrize("noise", ["", "00", "00 00", "FF"])
def test_noise_before_a_message_is_passed_over(noise):
    wire = bytes.fromhex(noise) + kwp2000.encode(b"\xc1\xef\x8f", 0xF1, 0x10)
    found = kwp2000.find(wire)
    assert found is not None
    assert found.data == b"\xc1\xef\x8f"
