"""The blocks: round trips in both byte orders, and the format's own numbers."""

from __future__ import annotations

import contextlib
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.cleaning import clean_text
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.blocks import (
    Custom,
    EnhancedPacket,
    Interface,
    Malformed,
    Section,
    SimplePacket,
    encode,
    parse,
)

words = st.text(st.characters(exclude_categories=["Cs"]), max_size=40).map(clean_text)
orders = st.sampled_from(["<", ">"])
blocks = st.one_of(
    st.builds(Section, hardware=words, application=words),
    st.builds(
        Interface,
        link_type=st.integers(0, 0xFFFF),
        name=words,
        description=words,
        speed=st.integers(0, 2**64 - 1),
        tsresol=st.integers(0, 255),
        tsoffset=st.integers(-(2**63), 2**63 - 1),
    ),
    st.builds(
        EnhancedPacket,
        interface=st.integers(0, 2**32 - 1),
        ticks=st.integers(0, 2**64 - 1),
        data=st.binary(max_size=40),
        flags=st.integers(0, 2**32 - 1),
        comment=words,
        cut=st.integers(0, 1000),
    ),
    st.builds(SimplePacket, st.binary(max_size=40)),
)


def taken_apart(block: bytes, order: pcapng.Order) -> tuple[int, bytes]:
    kind, total = struct.unpack_from(order + "II", block)
    assert total == len(block)
    assert total % 4 == 0
    assert block[-4:] == block[4:8]
    return kind, block[8:-4]


@given(blocks, orders)
def test_every_block_comes_back(block, order):
    kind, body = taken_apart(encode(block, order), order)
    assert parse(kind, body, order) == block


@given(st.binary(max_size=40), st.booleans(), orders)
def test_a_custom_block_comes_back_padded(data, private, order):
    kind, body = taken_apart(encode(Custom(32473, data, private), order), order)
    assert parse(kind, body, order) == Custom(32473, data + bytes(-len(data) % 4), private)


@given(st.sampled_from(sorted(pcapng.KNOWN)), st.binary(max_size=80), orders)
def test_any_body_is_a_block_or_malformed(kind, body, order):
    with contextlib.suppress(Malformed):
        assert parse(kind, body, order) is not None


@given(blocks, orders, st.data())
def test_a_body_cut_short_is_a_block_or_malformed(block, order, data):
    kind, body = taken_apart(encode(block, order), order)
    with contextlib.suppress(Malformed):
        parse(kind, body[: data.draw(st.integers(0, len(body)))], order)


def test_a_packet_is_encoded_byte_by_byte_as_specified():
    packet = EnhancedPacket(0, 0x0102030405060708, b"\x01\xff\x0d", pcapng.OUTBOUND)
    assert encode(packet).hex(" ", 4) == " ".join([
        "06000000", "30000000",
        "00000000", "04030201", "08070605", "03000000", "03000000",
        "01ff0d00",
        "02000400", "02000000", "00000000",
        "30000000",
    ])  # fmt: skip


def test_the_section_header_is_encoded_byte_by_byte_as_specified():
    assert encode(Section(application="mikas")).hex(" ", 4) == " ".join([
        "0a0d0d0a", "2c000000",
        "4d3c2b1a", "01000000", "ffffffff", "ffffffff",
        "04000500", "6d696b61", "73000000", "00000000",
        "2c000000",
    ])  # fmt: skip


@pytest.mark.parametrize(
    ("tsresol", "tsoffset", "ticks", "time"),
    [
        (6, 0, 1_500_000, 1.5),
        (9, 0, 1_700_000_000_123_456_789, 1_700_000_000.1234567),
        (3, 0, 250, 0.25),
        (0, 0, 7, 7.0),
        (0x80 | 10, 0, 1536, 1.5),
        (6, -2, 500_000, -1.5),
        (0xFF, 0, 2**64 - 1, (2**64 - 1) / 2**127),
        (0x7F, 5, 1, 5.0),
    ],
)
def test_a_tick_has_the_resolution_and_offset_of_its_interface(tsresol, tsoffset, ticks, time):
    assert Interface(tsresol=tsresol, tsoffset=tsoffset).time(ticks) == time


def test_the_resolution_is_microseconds_if_the_block_does_not_say():
    body = struct.pack("<HHI", 147, 0, 0)
    assert parse(pcapng.INTERFACE, body, "<") == Interface(tsresol=6)


def test_a_kind_that_is_not_known_is_none():
    assert parse(0x80000001, b"whatever", "<") is None


def test_several_comments_are_lines():
    options = struct.pack("<HH4sHH4sHH", 1, 3, b"one", 1, 3, b"two", 0, 0)
    body = struct.pack("<5I", 0, 0, 0, 0, 0) + options
    assert parse(pcapng.ENHANCED, body, "<") == EnhancedPacket(0, 0, b"", comment="one\ntwo")


def test_a_text_longer_than_an_option_is_cut_between_characters():
    name = "ж" * 40_000
    _, body = taken_apart(encode(Interface(name=name)), "<")
    assert parse(pcapng.INTERFACE, body, "<") == Interface(name="ж" * 32_767)


@pytest.mark.parametrize("magic", [b"", b"\x1a\x2b", b"\x2b\x1a\x3c\x4d"])
def test_a_magic_of_neither_order_has_no_byte_order(magic):
    assert magic not in pcapng.BYTE_ORDERS
