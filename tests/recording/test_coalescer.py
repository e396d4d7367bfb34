"""Chunks joined into packets: the same bytes, begin times as they were, a packet a response."""

from __future__ import annotations

from collections import defaultdict

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from capture_writing_harness import coalescing
from mikas import tester as testers
from mikas.framing import encode
from mikas.link.base import CaptureTee, Direction
from mikas.link.virtual import VirtualLink
from mikas.recording import CaptureReader, CaptureWriter, Coalescer
from mikas.recording.annotations.events import note_of
from mikas.sampling.events import Marker
from mikas.virtual.bus import AdapterKind
from virtual_harness import make_bus

SENT, RECEIVED = Direction.SENT, Direction.RECEIVED
BYTE = 10 / 9600


class Kept:
    def __init__(self):
        self.items = []

    def record(self, direction, data, time):
        self.items.append((direction, data, time))

    def note(self, note):
        self.items.append(note)


def coalesced(chunks):
    kept = Kept()
    with coalescing(kept) as coalescer:
        for chunk in chunks:
            coalescer.record(*chunk)
    return kept.items


def begins(packets):
    """When each byte that begins a frame began, as readers reckon it."""
    found = []
    fresh = True
    for direction, data, time in packets:
        if direction is SENT:
            continue
        for index, value in enumerate(data):
            if fresh:
                found.append(time - (len(data) - index) * BYTE)
            fresh = value == 0x0D
    return found


@st.composite
def lines(draw):
    """Chunks of both directions whose times never run back; bytes take their time."""
    now, chunks = draw(st.sampled_from([0.0, 1.7e9])), []
    for _ in range(draw(st.integers(0, 25))):
        direction = draw(st.sampled_from([SENT, RECEIVED, RECEIVED, RECEIVED]))
        data = draw(
            st.binary(min_size=1, max_size=3)
            | st.lists(st.sampled_from([1, 2, 0x0D]), min_size=1, max_size=20).map(bytes)
        )
        pause = draw(st.sampled_from([0, 0, 0, 0.1, 0.4, 0.9, 1.2, 2.5, 2.9, 3.5, 20]))
        late = draw(st.sampled_from([0, 0, 0.3, -0.3, -1, -20]))
        now = max(now, now + (len(data) + pause + late) * BYTE)
        chunks.append((direction, data, now))
    return chunks


@given(lines())
@example([(RECEIVED, bytes([value]), index * BYTE) for index, value in enumerate(b"abc\x0d" * 9)])
@example([(RECEIVED, b"a", index * 0.9) for index in range(5)])
@example([(RECEIVED, b"\0", BYTE), (RECEIVED, b"\0", BYTE), (RECEIVED, b"\r\0", 4.2 * BYTE)])
@example([(RECEIVED, b"\0", BYTE), (RECEIVED, b"\0", BYTE), (RECEIVED, b"\r\0", 2.7 * BYTE)])
def test_same_bytes_same_order_and_frames_begin_when_they_did(chunks):
    packets = coalesced(chunks)
    streams = [
        {
            way: b"".join(data for direction, data, _ in items if direction is way)
            for way in Direction
        }
        for items in (chunks, packets)
    ]
    assert streams[0] == streams[1]
    turns = [
        [(direction, len(data)) for direction, data, _ in items] for items in (chunks, packets)
    ]
    assert _runs(turns[0]) == _runs(turns[1])
    for was, reported in zip(begins(chunks), begins(packets), strict=True):
        assert abs(was - reported) <= BYTE * 1.001 + 1e-6
    times = [time for _, _, time in packets]
    assert times == sorted(times)
    for (_, data, time), last in zip(packets, _last_times(chunks, packets), strict=True):
        assert time <= last  # no byte has a later time than its arrival
        assert last - time <= 8.6 * BYTE + 1e-6
        assert len(data) <= 4096


def _runs(turns):
    """Bytes in a row in one direction."""
    runs = []
    for direction, count in turns:
        if runs and runs[-1][0] is direction:
            runs[-1][1] += count
        else:
            runs.append([direction, count])
    return runs


def _last_times(chunks, packets):
    """When the last byte of each packet was really seen."""
    ends = defaultdict(list)
    for direction, data, time in chunks:
        ends[direction] += [time] * len(data)
    at = dict.fromkeys(Direction, 0)
    for direction, data, _ in packets:
        at[direction] += len(data)
        yield ends[direction][at[direction] - 1]


def test_a_lone_chunk_keeps_its_very_time():
    chunk = (RECEIVED, b"\x0a\xf6\x0d", 1_700_000_000.123457)
    assert coalesced([chunk]) == [chunk]


def test_a_response_byte_by_byte_is_one_packet_and_is_there_when_it_ends():
    kept = Kept()
    coalescer = Coalescer(kept)
    wire = encode(b"\x7d\x0d\x40")
    for index, value in enumerate(wire, 1):
        assert kept.items == []
        coalescer.record(RECEIVED, bytes([value]), index * BYTE)
    [(_, data, time)] = kept.items
    assert data == wire
    assert time == pytest.approx(len(wire) * BYTE)


def test_a_response_is_there_when_it_ends_though_the_chunk_goes_on():
    """Its values may be shown at once, and the program killed then."""
    kept = Kept()
    chunk = (RECEIVED, encode(b"\x7d") + b"\x7d", 1.0)
    Coalescer(kept).record(*chunk)
    assert kept.items == [chunk]


def test_a_first_look_that_came_late_is_put_right_by_the_next_one():
    began = 5.0
    looks = [(b"\x7d" * 25, began + 25.7 * BYTE), (b"\x40\x0d", began + 27 * BYTE)]
    [(_, data, time)] = coalesced([(RECEIVED, *look) for look in looks])
    assert len(data) == 27
    assert time == pytest.approx(began + 27 * BYTE)


def test_what_waits_goes_before_a_note_before_what_is_sent_and_after_a_second():
    kept = Kept()
    coalescer = Coalescer(kept)
    coalescer.record(RECEIVED, b"a", 1.0)
    coalescer.note(note_of(Marker(1.0)))
    coalescer.record(RECEIVED, b"b", 1.1)
    coalescer.record(SENT, b"c", 1.1)
    coalescer.record(RECEIVED, b"d", 1.2)
    coalescer.tick(2.1)
    assert kept.items[0] == (RECEIVED, b"a", 1.0)
    assert kept.items[2:] == [(RECEIVED, b"b", 1.1), (SENT, b"c", 1.1)]
    coalescer.tick(2.2)
    assert kept.items[4:] == [(RECEIVED, b"d", 1.2)]
    coalescer.tick(9.0)
    coalescer.flush()
    assert len(kept.items) == 5


def test_bytes_without_end_are_written_every_second_and_every_4096():
    chunks = [(RECEIVED, b"x", index * BYTE) for index in range(3000)]
    sizes = [len(data) for _, data, _ in coalesced(chunks)]
    assert max(sizes) in range(955, 963)
    chunks = [(RECEIVED, b"x" * 1000, index * 1000 * BYTE) for index in range(9)]
    assert [len(data) for _, data, _ in coalesced(chunks)] == [1000] * 9
    fast = Kept()
    with coalescing(fast, baud=1_000_000) as coalescer:
        for index in range(9):
            coalescer.record(RECEIVED, b"x" * 1000, index * 0.01)
    assert [len(data) for _, data, _ in fast.items] == [4000, 4000, 1000]


def test_a_sink_that_fails_is_given_nothing_twice():
    class Full(Kept):
        def record(self, direction, data, time):
            super().record(direction, data, time)
            raise OSError(28, "full")

    full = Full()
    coalescer = Coalescer(full)
    coalescer.record(RECEIVED, b"a", 1.0)
    with pytest.raises(OSError, match="full"):
        coalescer.flush()
    coalescer.flush()
    assert len(full.items) == 1


@pytest.mark.parametrize("latency", [0.0, 0.016])
def test_a_session_has_a_packet_a_response(tmp_path, latency):
    counts, frames = [], []
    for joined in (False, True):
        path = tmp_path / f"{joined}.pcapng"
        link = VirtualLink(make_bus(adapter=AdapterKind(latency=latency)))
        with CaptureWriter(path, url="sim:") as writer:
            sink = Coalescer(writer) if joined else writer
            tester = testers.Tester(CaptureTee(link, sink))
            tester.connect()
            before = writer.path.stat().st_size
            for _ in range(50):
                tester.raw(b"\x61\x1a\x29\x3f\x21\x40\x20")
            if joined:
                sink.flush()
            assert writer.path.stat().st_size > before
        packets = list(CaptureReader(path))
        counts.append(len(packets))
        frames.append(b"".join(it.data for it in packets if it.direction is RECEIVED))
    assert frames[0] == frames[1]
    if not latency:
        assert counts[1] < 50 * 3 + 30  # sent, echo, response
        assert counts[0] > 4 * counts[1]
