"""§2, D3, D4, D5: the three vectors' framing side and the properties of the codec."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import pytest
from fuzz.framing import check
from hypothesis import example, given
from hypothesis import strategies as st

from mikas.framing import Damage, DamageReason, Decoder, Event, Frame, checksum, encode, unstuff

REPOSITORY = Path(__file__).parents[1]
VECTORS = REPOSITORY / "conformance"
FRAMES = json.loads((VECTORS / "frames.json").read_text("utf-8"))
STREAMS = json.loads((VECTORS / "streams.json").read_text("utf-8"))

# Bytes that matter to the codec come up often enough to meet each other.
awkward = st.one_of(st.sampled_from(b"\x0d\x40\xcd\x00\xf3\xc0"), st.integers(0, 255))
wires = st.lists(awkward, max_size=60).map(bytes)


def all_events(chunks: list[bytes], **settings: object) -> tuple[list[Event], Decoder]:
    decoder = Decoder(**settings)
    return [event for chunk in chunks for event in decoder.feed(chunk)], decoder


def cut(data: bytes, cuts: list[int]) -> list[bytes]:
    edges = sorted({0, len(data), *(c % (len(data) + 1) for c in cuts)})
    return [data[a:b] for a, b in itertools.pairwise(edges)]


def shown(events: list[Event], decoder: Decoder) -> list[dict[str, str]]:
    rows = [
        {"frame": e.body.hex(" ").upper()}
        if isinstance(e, Frame)
        else {"damaged": e.data.hex(" ").upper()}
        for e in events
    ]
    if decoder.pending:
        rows.append({"left_in_buffer": decoder.pending.hex(" ").upper()})
    return rows


@pytest.mark.parametrize("vector", FRAMES, ids=lambda v: v["why"])
def test_frames_are_encoded_and_decoded_as_in_the_vectors(vector):
    body = bytes.fromhex(vector["body"])
    assert checksum(body) == int(vector["checksum"], 16)
    assert encode(body) == bytes.fromhex(vector["wire"])
    wires = [vector["wire"]]
    if raw := vector.get("wire_with_raw_checksum"):
        assert encode(body, raw_checksum=True) == bytes.fromhex(raw)
        wires.append(raw)
    for wire in map(bytes.fromhex, wires):
        for chunks in ([wire], [wire[i : i + 1] for i in range(len(wire))]):
            events, decoder = all_events(chunks)
            assert [e.body for e in events] == [body]
            assert events[0].wire == wire
            assert not events[0].irregular
            assert decoder.pending == b""


@pytest.mark.parametrize("vector", STREAMS, ids=lambda v: v["why"])
def test_stream_vectors_give_their_events_under_every_chunking(vector):
    wire = bytes.fromhex(vector["wire"])
    for pattern in range(1 << max(0, len(wire) - 1)):
        cuts = [i + 1 for i in range(len(wire) - 1) if pattern >> i & 1]
        events, decoder = all_events(cut(wire, cuts))
        assert shown(events, decoder) == vector["events"]


@given(st.lists(awkward, max_size=300).map(bytes), st.booleans())
def test_an_encoded_body_is_decoded_again(body, raw):
    wire = encode(body, raw_checksum=raw)
    events, decoder = all_events([wire])
    assert [e.body for e in events] == [body]
    assert decoder.pending == b""
    if not raw:
        assert wire.count(0x0D) == 1  # no bare terminator inside
    assert sum(wire[:-1]) & 0xFF == 0  # the sum survives stuffing, §2.2


@given(wires, st.lists(st.integers(0, 60), max_size=12), st.integers(1, 20), st.booleans())
@example(bytes.fromhex("F30D0D"), [2], 1, False)
def test_chunking_never_changes_the_events(wire, cuts, limit, strict):
    whole, one = all_events([wire], limit=limit, strict=strict)
    pieces, many = all_events(cut(wire, cuts), limit=limit, strict=strict)
    assert pieces == whole
    assert many.pending == one.pending


@given(st.lists(wires, max_size=8), st.integers(1, 16))
def test_memory_is_bounded_and_every_byte_is_accounted_for(chunks, limit):
    decoder = Decoder(limit=limit)
    events = []
    for chunk in chunks:
        events += decoder.feed(chunk)
        assert len(decoder.pending) <= limit + 1  # + a terminator that waits for its successor
    fed = b"".join(chunks)
    assert decoder.offset == len(fed)
    rest = fed[: len(fed) - len(decoder.pending)]
    for event in reversed(events):
        data = event.wire if isinstance(event, Frame) else event.data
        rest, behind = rest[: event.offset], rest[event.offset + len(data) :]
        if isinstance(event, Damage) and event.reason is DamageReason.TOO_LONG:
            behind = behind.partition(b"\r")[2]
        assert not behind.strip(b"\r")  # bare terminators
    assert not rest.strip(b"\r")


@given(wires)
def test_offsets_point_at_the_bytes(wire):
    for event in Decoder().feed(wire):
        data = event.wire if isinstance(event, Frame) else event.data
        assert wire[event.offset : event.offset + len(data)] == data


@given(st.binary(min_size=3, max_size=3), wires)
def test_a_second_reading_of_the_law_finds_the_same(settings, wire):
    check(settings + wire)


def test_inputs_that_the_fuzzer_has_kept_break_no_property():
    inputs = [path.read_bytes() for path in (REPOSITORY / "fuzz/corpus/framing").iterdir()]
    assert len(inputs) > 50
    for data in inputs:
        check(data)


@given(wires)
def test_the_sum_over_the_wire_is_that_of_the_plain_bytes(wire):
    plain, irregular = unstuff(wire)
    assert sum(plain) & 0xFF == sum(wire) & 0xFF
    if not irregular:
        assert len(plain) == len(wire) - wire.count(0x40)


def test_an_event_is_a_value():
    events = Decoder().feed(bytes.fromhex("01FF0D 01FE0D"))
    assert events == [
        Frame(b"\x01", b"\x01\xff\r", 0),
        Damage(DamageReason.CHECKSUM, b"\x01\xfe", 3),
    ]
    assert not events[0].irregular
    assert len({*events}) == 2
    assert [hasattr(event, "__dict__") for event in events] == [False, False]


def test_the_reasons_are_those_that_decoded_recordings_name():
    assert [r.value for r in DamageReason] == ["checksum", "too long", "irregular escape"]


def test_bare_terminators_are_skipped_and_counted():
    decoder = Decoder()
    assert [e.body for e in decoder.feed(bytes.fromhex("0D0D 01FF0D 0D"))] == [b"\x01"]
    assert decoder.noise == 3
    decoder.feed(bytes.fromhex("F30D0D 0D"))  # the second 0D ends the frame (D3)
    assert decoder.noise == 4


def test_strict_mode_reports_an_irregular_escape():
    wire = bytes.fromhex("40417F0D")
    assert Decoder().feed(wire)[0] == Frame(b"\x81", wire, 0, irregular=True)
    assert Decoder(strict=True).feed(wire) == [Damage(DamageReason.IRREGULAR_ESCAPE, wire[:-1], 0)]


@pytest.mark.parametrize(
    ("wire", "body", "raw", "irregular"),
    [
        ("C0 40 0D", "C0", True, False),
        ("C0 40 00 0D", "C0", False, False),
        ("F3 40 CD 0D", "F3", False, False),
        ("40 40 C0 40 0D", "80 C0", None, None),  # sums to 80: damaged
        ("80 40 40 0D", "80", False, True),  # 40 escapes 40: by the sum rule 80, not a raw checksum
        ("80 40 00 40 0D", "80 40", True, False),
        ("40 41 3F 40 0D", "81 3F", True, True),
        ("B3 40 0D 0D", "B3 40", True, True),  # nothing behind the escape but a raw checksum
        ("40 C0 0D", "", False, True),
    ],
)
def test_corners_of_the_checksum_rule_are_decoded_as_the_law_says(wire, body, raw, irregular):
    (event,) = Decoder().feed(bytes.fromhex(wire))
    if raw is None:
        assert isinstance(event, Damage)
    else:
        assert (event.body, event.raw_checksum, event.irregular) == (
            bytes.fromhex(body),
            raw,
            irregular,
        )


def test_an_over_long_frame_is_reported_once_and_the_next_one_is_read():
    wire = b"\x22" * 30 + b"\x0d" + bytes.fromhex("01FF0D")
    decoder = Decoder(limit=10)
    events = [e for i in range(len(wire)) for e in decoder.feed(wire[i : i + 1])]
    assert events[0] == Damage(DamageReason.TOO_LONG, b"\x22" * 10, 0)
    assert [e.body for e in events[1:]] == [b"\x01"]
    assert decoder.offset == len(wire)


def test_a_frame_of_exactly_the_limit_is_sound():
    body = bytes(4095)
    events = Decoder().feed(encode(body))
    assert [e.body for e in events] == [body]
    assert isinstance(Decoder().feed(encode(bytes(4096)))[0], Damage)


def test_reset_forgets_the_unfinished_frame():
    decoder = Decoder(limit=4)
    decoder.feed(b"\x01\xff")
    assert decoder.reset() == b"\x01\xff"
    assert [e.body for e in decoder.feed(b"\x01\xff\x0d")] == [b"\x01"]
    decoder.feed(b"\x22" * 9)
    decoder.reset()
    assert [e.body for e in decoder.feed(b"\x01\xff\x0d")] == [b"\x01"]


def test_reset_also_forgets_a_terminator_that_waits_for_its_successor():
    decoder = Decoder()
    assert decoder.reset() == b""
    decoder.feed(b"\xf3\x0d")
    assert decoder.reset() == b"\xf3\x0d"
    assert decoder.feed(b"\x01\xff\x0d\x02") == [Frame(b"\x01", b"\x01\xff\x0d", 2)]


def test_a_decoder_knows_whether_the_next_byte_begins_a_frame():
    decoder = Decoder(limit=8)
    wire = encode(b"\x61\x1e")
    assert decoder.is_between_frames
    for byte in wire[:-1]:
        list(decoder.feed(bytes([byte])))
        assert not decoder.is_between_frames
    list(decoder.feed(wire[-1:]))
    assert decoder.is_between_frames
    list(decoder.feed(bytes(20)))  # over-long, and reported: its end is still to come
    assert not decoder.is_between_frames
    decoder.reset()
    assert decoder.is_between_frames


def test_a_limit_below_one_is_misuse():
    with pytest.raises(ValueError, match="limit"):
        Decoder(limit=0)
