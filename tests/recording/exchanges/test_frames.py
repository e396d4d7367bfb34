"""The bulk decoder against the incremental one: the same events, byte for byte (§2, D3, D4, D5)."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.framing import Damage, DamageReason, Decoder, Frame, encode
from mikas.recording.exchanges.columns.frames import (
    CHECKSUM,
    GIVEN_UP,
    SOUND,
    TOO_LONG,
    BulkDecoder,
)

REASONS = {
    CHECKSUM: DamageReason.CHECKSUM,
    TOO_LONG: DamageReason.TOO_LONG,
}

# Bytes that decide something, far more often than chance would bring them.
telling = st.sampled_from(b"\x0d\x0d\x0d\x40\x40\xcd\x00\xf3\x01\xff\x33")
pieces = st.one_of(
    st.binary(max_size=12),
    st.lists(telling, max_size=14).map(bytes),
    st.builds(encode, st.binary(max_size=20), raw_checksum=st.booleans()),
    st.builds(encode, st.lists(telling, max_size=6).map(bytes), raw_checksum=st.booleans()),
    st.sampled_from([b"\xf3\x0d\x0d", b"\xf3\x0d", b"\xc0\x40\x0d", b"\x40\x01\xbf\x0d"]),
)
streams = st.lists(pieces, max_size=25).map(b"".join)
limits = st.sampled_from([1, 2, 3, 5, 8, 20, 4096])


@st.composite
def chunked(draw):
    """A stream in pieces, and before which pieces the decoder is reset."""
    data = draw(streams)
    cuts = sorted(draw(st.lists(st.integers(0, len(data)), max_size=12)))
    edges = [0, *cuts, len(data)]
    parts = [data[a:b] for a, b in pairwise(edges)]
    return parts, [draw(st.booleans()) for _ in parts]


def events_of(block):
    """The events as those of `Decoder.feed`; bare bytes are a frame abandoned at a cut."""
    for index, reason in enumerate(block.reasons.tolist()):
        wire, offset = block.wire_of(index), block.origin + int(block.starts[index])
        if reason == GIVEN_UP:
            yield wire
        elif reason != SOUND:
            yield Damage(REASONS[reason], wire, offset)
        else:
            yield Frame(block.body_of(index), wire, offset, bool(block.raw_checksum[index]))


def known(events):
    """Events of `Decoder.feed` without what the bulk decoder does not say: irregular escapes."""
    return [replace(it, irregular=False) if isinstance(it, Frame) else it for it in events]


@given(chunked(), limits)
def test_the_same_events_after_the_same_piece(stream, limit):
    slow, fast = Decoder(limit=limit), BulkDecoder(limit=limit)
    for part, _ in zip(*stream, strict=True):
        assert list(events_of(fast.feed(part))) == known(slow.feed(part))
        assert (fast.pending, fast.offset) == (slow.pending, slow.offset)


@given(chunked(), limits, st.sampled_from([1, 2, 3, 100]))
def test_cuts_are_resets(stream, limit, together):
    slow, fast = Decoder(limit=limit), BulkDecoder(limit=limit)
    expected, shown = [], []
    batch, cuts = b"", []

    def flush():
        block = fast.feed(np.frombuffer(batch, np.uint8), np.array(cuts, np.int64))
        shown.extend(events_of(block))

    for number, (part, cut) in enumerate(zip(*stream, strict=True)):
        if cut and part:
            if left := slow.reset():
                expected.append(left)
            cuts.append(len(batch))
        expected += known(slow.feed(part))
        batch += part
        if number % together == 0:
            flush()
            batch, cuts = b"", []
    flush()
    assert shown == expected
    assert fast.pending == slow.pending


@given(chunked(), limits)
def test_needed_is_the_byte_that_decides(stream, limit):
    data = b"".join(stream[0])
    slow, decided = Decoder(limit=limit), []
    for count in range(len(data)):
        decided += [count + 1] * len(slow.feed(data[count : count + 1]))
    assert BulkDecoder(limit=limit).feed(data).needed.tolist() == decided


@given(st.integers(0, 2**32 - 1), st.integers(1, 60))
def test_long_runs_of_bytes_with_damage_have_the_same_events(seed, size):
    random = np.random.default_rng(seed)
    data = b"".join(
        encode(random.bytes(size), raw_checksum=bool(flag)) for flag in random.integers(0, 2, 300)
    )
    spoilt = np.frombuffer(data, np.uint8).copy()
    at = random.integers(0, spoilt.size, 5)
    spoilt[at] = random.integers(0, 256, 5, dtype=np.uint8)
    fast = BulkDecoder()
    shown = [
        event
        for start in range(0, spoilt.size, 997)
        for event in events_of(fast.feed(spoilt[start : start + 997]))
    ]
    assert shown == known(Decoder().feed(spoilt.tobytes()))


def test_memory_is_bounded_by_the_limit():
    decoder = BulkDecoder(limit=100)
    events = [event for _ in range(50) for event in events_of(decoder.feed(b"\x55" * 1000))]
    assert [type(event) for event in events] == [Damage]
    assert decoder.pending == b""


def test_a_limit_is_at_least_a_byte():
    with pytest.raises(ValueError, match="limit"):
        BulkDecoder(limit=0)
