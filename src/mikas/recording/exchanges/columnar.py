"""Recorded exchanges as arrays: the result of `exchanges.scalar`, many times faster (D1, D13).

The packets of one port fall into turns: first sent ones, then received ones. Only the last request
and whether the line echoes pass from one turn to the next, so a run of regular turns (one sound
request each) is matched in one step: the first frame that repeats the request is its echo, a frame
before that echo answers the previous request. Irregular turns, the first ones, which decide whether
the line echoes, and the last one, which may continue (a stream does so for hours), go frame by
frame through `Matching`.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import BinaryIO, Final

import numpy as np

from mikas.recording.capture.blocks import Order
from mikas.recording.capture.notes import Note
from mikas.recording.capture.reader import Blocks, Problem, Source
from mikas.recording.exchanges.arrays import Floats, Index, Mask
from mikas.recording.exchanges.frames import SOUND, BulkDecoder, FrameBlock
from mikas.recording.exchanges.matching import (
    AVAILABILITY,
    NO_REQUEST,
    SILENCE,
    SILENCE_AFTER_SENDING,
    Matching,
    SentRequest,
    matched,
)
from mikas.recording.exchanges.packets import WINDOW, PacketColumns, Packets, Window, read
from mikas.recording.exchanges.pieces import equal
from mikas.recording.exchanges.result import GAP, Exchanges, Requests, Responses

_ECHO: Final = -2
"""Marker for echoes; they answer no request."""
_DAMAGE: Final = -3
"""Marker for damaged frames that are no echo."""
_NEVER: Final = np.iinfo(np.int64).max


def column_exchanges(
    path: str | os.PathLike[str], window: int = WINDOW
) -> Iterator[Exchanges | Problem | Note]:
    """Yield the exchanges of a capture. Raise as `CaptureReader` does."""
    return matched(read(path, window), ColumnarMatcher)


def responses_in(file: BinaryIO, piece: range, order: Order, blocks: Blocks) -> tuple[int, int]:
    """Return the number of responses in a run of packets at the begin of a piece of a file, and the
    length of the run in bytes. `blocks`: as before the piece.
    """
    window = Window(file, piece.start, len(piece), order)
    found, end = window.run(piece.start)
    if not found.size or not blocks.interfaces:
        return 0, 0
    runs = PacketColumns(window, found, blocks).packets(0, found.size)
    stretches = (ColumnarMatcher(packets.source).feed(packets) for packets in runs)
    return sum(len(each.responses.times) for each in stretches), end - piece.start


class ColumnarMatcher:
    """The exchanges of one port of one recording."""

    def __init__(self, source: Source) -> None:
        self.matching = Matching()
        self._source = source
        self._sent = PacketStream(source.byte_time)
        self._received = PacketStream(source.byte_time)
        self._sent_last = False
        self._last: float = np.inf
        self._latest = np.full(2, NO_REQUEST)  # numbers of the last two requests

    def feed(self, packets: Packets) -> Exchanges:
        """Return the exchanges that these packets complete."""
        after_sent = np.concatenate(([self._sent_last], packets.sent[:-1]))
        self._sent_last = bool(packets.sent[-1])
        turns = (packets.sent & ~after_sent).cumsum()
        sent, at = self._sent.feed(packets, packets.sent, np.zeros_like(after_sent))
        requests = Events(sent, turns[at])
        received, at = self._received.feed(packets, ~packets.sent, after_sent)
        responses = Events(received, turns[at])
        first = self.matching.count
        self._number_requests(requests)
        answers = _Turns(self.matching, requests, responses, first).answers(int(turns[-1]))
        self.matching.count = first + requests.index.size
        after = first - 1 + requests.turns.searchsorted(responses.turns, "right")
        chosen = (answers > _ECHO).nonzero()[0]
        sent_times = self._sent.packet_times(sent, requests.index)
        return Exchanges(
            source=self._source,
            bodies=self.matching.bodies,
            requests=Requests(first, requests.numbers, sent_times, requests.lengths),
            responses=self._responses(requests, responses, chosen, answers, after),
            damaged=after[answers == _DAMAGE],
            echoes=int(np.count_nonzero(answers == _ECHO)),
            raw_checksum=bool(received.raw_checksum[responses.index[chosen]].any()),
            gaps=self._gaps(packets.times),
            begin=float(packets.times[0]),
            end=float(packets.times[-1]),
        )

    def _number_requests(self, sent: Events) -> None:
        """Number the requests; equal ones in a row are looked up once."""
        block, starts = sent.block, sent.starts
        new = np.ones(sent.index.size, np.bool_)
        same = (sent.lengths[1:] == sent.lengths[:-1]) & sent.sound[1:] & sent.sound[:-1]
        pairs = same.nonzero()[0]
        new[pairs + 1] = ~equal(
            block.wire, starts[pairs], block.wire, starts[pairs + 1], sent.lengths[pairs]
        )
        numbers = [self.matching.number(sent.body(event)) for event in new.nonzero()[0].tolist()]
        if numbers:
            sent.numbers[:] = np.array(numbers)[new.cumsum() - 1]

    def _responses(
        self, requests: Events, responses: Events, chosen: Index, answers: Index, after: Index
    ) -> Responses:
        block, events = responses.block, responses.index[chosen]
        serials = answers[chosen]
        # A response answers one of the last two earlier requests, or one of this stretch.
        first = self.matching.count - requests.index.size
        known = np.concatenate((self._latest, requests.numbers))
        numbers = known[np.maximum(serials - first + 2, 0)]
        numbers[serials == NO_REQUEST] = NO_REQUEST
        self._latest = known[-2:]
        return Responses(
            times=self._received.wire_times(block, events),
            requests=serials,
            numbers=numbers,
            after=after[chosen],
            bodies=block.bodies,
            starts=block.body_starts[events],
            lengths=block.body_ends[events] - block.body_starts[events],
            wire_lengths=responses.lengths[chosen],
        )

    def _gaps(self, times: Floats) -> list[tuple[float, float]]:
        before = np.concatenate(([self._last], times[:-1]))
        self._last = float(times[-1])
        at = (times - before > GAP).nonzero()[0]
        return list(zip(before[at].tolist(), times[at].tolist(), strict=True))


class _Turns:
    """The turns of one stretch of packets. `first`: the serial of its first request."""

    def __init__(self, matching: Matching, requests: Events, responses: Events, first: int) -> None:
        self._matching = matching
        self._requests = requests
        self._responses = responses
        self._first = first
        self._answers: Index = np.full(responses.index.size, _ECHO)
        self._availability = matching.number(AVAILABILITY)

    def answers(self, last: int) -> Index:
        """Return for each received frame the serial of the request that it answers, or a marker.

        Turns are numbered from 0 to `last`.
        """
        sent = self._requests
        regular = np.bincount(sent.turns, minlength=last + 1) == 1
        regular[sent.turns[~sent.sound]] = False
        regular[0] = regular[last] = False
        irregular = (~regular).nonzero()[0].tolist()
        turn = 0
        for stop in irregular:
            while turn < stop:
                turn = self._run(turn, stop)
            self._one(stop)
            turn = stop + 1
        return self._answers

    def _one(self, turn: int) -> None:
        """Match one turn frame by frame."""
        matching, sent, received = self._matching, self._requests, self._responses
        if turn:
            matching.turn()
        for event in sent.of_turn(turn):
            matching.sent(sent.wire(event), sent.body(event))
        events = received.of_turn(turn)
        for event in events:
            if matching.settled:
                rest = slice(event, events.stop)
                serial = matching.request.serial
                self._answers[rest] = np.where(received.sound[rest], serial, _DAMAGE)
                return
            body = received.body(event)
            if not matching.received(received.wire(event), body):
                self._answers[event] = _DAMAGE if body is None else matching.answered.serial

    def _run(self, first: int, stop: int) -> int:
        """Match regular turns from `first` to before `stop` at once; return the next turn."""
        matching, sent, received = self._matching, self._requests, self._responses
        begin, end = received.turns.searchsorted([first, stop])
        events = slice(begin, end)
        at = received.turns[events] - first  # each event's turn, counted from the first
        # A regular turn has one request, so requests and turns correspond.
        turn_of_request = int(sent.turns.searchsorted(first))
        asking = slice(turn_of_request, turn_of_request + stop - first)
        numbers = sent.numbers[asking]
        same = self._repeats(events, asking, at)
        is_availability = numbers == self._availability
        stop = min(stop, first + self._before_news(events, is_availability, at, same))
        if stop == first:
            self._one(first)
            return first + 1
        count = int(at.searchsorted(stop - first))
        at, same = at[:count], same[:count]
        events = slice(begin, begin + count)
        place = np.arange(count)
        serials = self._first + turn_of_request + np.arange(stop - first)
        answers = serials[at]
        if matching.echoes is not False:
            echo = _first(place[same], at[same], serials.size)
            if matching.echoes:
                damaged = ~received.sound[events]
                damage = _first(place[damaged], at[damaged], serials.size)
                too_early = (place < echo[at]) & (place <= damage[at])
                before = np.concatenate(([matching.request.serial], serials[:-1]))
                answers[too_early] = before[at[too_early]]
            answers[place == echo[at]] = _ECHO
        answers[~received.sound[events]] = _DAMAGE
        self._answers[events] = answers
        body = matching.bodies[int(numbers[stop - first - 1])]
        matching.request = SentRequest(int(serials[-1]), body)
        matching.count = int(serials[-1]) + 1
        return stop

    def _repeats(self, events: slice, asking: slice, at: Index) -> Mask:
        """Return which responses are byte for byte the request of their turn."""
        sent, received = self._requests, self._responses
        lengths = received.lengths[events]
        same: Mask = received.sound[events] & (lengths == sent.lengths[asking][at])
        maybe = same.nonzero()[0]
        same[maybe] = equal(
            received.block.wire,
            received.starts[events][maybe],
            sent.block.wire,
            sent.starts[asking][at[maybe]],
            lengths[maybe],
        )
        return same

    def _before_news(self, events: slice, is_availability: Mask, at: Index, same: Mask) -> int:
        """Return the first turn that could change the knowledge about the echo."""
        if self._matching.echoes:
            return is_availability.size
        received = self._responses
        index = received.index[events]
        lengths = received.block.body_ends[index] - received.block.body_starts[index]
        telling = received.sound[events] & (lengths == 1) & is_availability[at]
        if self._matching.echoes is False:
            telling &= same
        found = telling.nonzero()[0]
        return int(at[found[0]]) if found.size else is_availability.size


def _first(places: Index, turns: Index, count: int) -> Index:
    """Return the first of these places in each turn."""
    first = np.full(count, _NEVER)
    first[turns[::-1]] = places[::-1]
    return first


class PacketStream:
    """One direction of a port: its frames, and which packet brought which byte (§1, §2).

    Decodes frames; abandons an unfinished one after a silence, as `exchanges.scalar` does.
    """

    def __init__(self, byte_time: float) -> None:
        self._byte_time = byte_time
        self._decoder = BulkDecoder()
        self._last = np.nan  # time of the latest packet
        # The packets of the unfinished frame: where they end in the stream, and their times.
        self._ends: Index = np.empty(0, np.int64)
        self._times: Floats = np.empty(0)

    def feed(self, packets: Packets, chosen: Mask, after_sent: Mask) -> tuple[FrameBlock, Index]:
        """Return the events of the `chosen` packets, and the packet that completed each."""
        numbers = chosen.nonzero()[0]
        times, lengths = packets.times[numbers], packets.lengths[numbers]
        decoder = self._decoder
        before = decoder.offset
        unfinished = before - len(decoder.pending)
        ends = lengths.cumsum()
        cuts = (ends - lengths)[self._late(times, lengths, after_sent[numbers])]
        block = decoder.feed(packets.data(numbers), cuts)
        completed = block.needed + (block.origin - before)
        by = numbers[ends.searchsorted(completed)] if len(block) else numbers[:0]

        needed, brings = self._ends > unfinished, lengths > 0
        self._ends = np.concatenate((self._ends[needed], before + ends[brings]))
        self._times = np.concatenate((self._times[needed], times[brings]))
        return block, by

    def packet_times(self, block: FrameBlock, events: Index) -> Floats:
        """Return the times of the packets that brought the first bytes of these frames."""
        times: Floats = self._times[self._first_packets(block, events)]
        return times

    def _first_packets(self, block: FrameBlock, events: Index) -> Index:
        found: Index = self._ends.searchsorted(block.starts[events] + block.origin, "right")
        return found

    def wire_times(self, block: FrameBlock, events: Index) -> Floats:
        """Return when the first bytes of these frames of the latest block began on the wire.

        That is the earliest time that any packet with a byte of the frame implies: a packet may
        have been delayed (`mikas.tester.exchange`).
        """
        starts = block.starts[events] + block.origin
        packet = self._first_packets(block, events)
        last = self._ends.searchsorted(block.ends[events] + block.origin)
        times: Floats = self._times[packet] - (self._ends[packet] - starts) * self._byte_time
        more = (packet < last).nonzero()[0]
        while more.size:
            packet[more] += 1
            at = packet[more]
            implied = self._times[at] - (self._ends[at] - starts[more]) * self._byte_time
            times[more] = np.minimum(times[more], implied)
            more = more[at < last[more]]
        return times

    def _late(self, times: Floats, lengths: Index, after_sent: Mask) -> Mask:
        if not times.size:
            return np.zeros(0, np.bool_)
        before = np.concatenate(([self._last], times[:-1]))
        self._last = times[-1]
        silence = times - lengths * self._byte_time - before
        late: Mask = silence > np.where(after_sent, SILENCE_AFTER_SENDING, SILENCE)
        return late


class Events:
    """The events of one direction except abandoned frames, with turns. `index`: in `block`."""

    def __init__(self, block: FrameBlock, turns: Index) -> None:
        self.block = block
        self.index = block.counted
        self.turns = turns[self.index]
        self.sound: Mask = block.reasons[self.index] == SOUND
        self.starts = block.starts[self.index]
        self.lengths = block.ends[self.index] - self.starts
        self.numbers: Index = np.full(self.index.size, NO_REQUEST)

    def of_turn(self, turn: int) -> range:
        """Return the events of one turn."""
        first, last = self.turns.searchsorted([turn, turn + 1])
        return range(first, last)

    def wire(self, event: int) -> bytes:
        return self.block.wire_of(int(self.index[event]))

    def body(self, event: int) -> bytes | None:
        """Return the body of a frame; None for damage."""
        return self.block.body_of(int(self.index[event])) if self.sound[event] else None
