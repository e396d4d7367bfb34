"""Recorded exchanges frame by frame: the reference for `exchanges.columnar`, without numpy.

Each direction has a decoder of its own (§2); `exchanges.matching` has the rules.
"""

from __future__ import annotations

import os
from array import array
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from mikas.framing import Damage, Decoder, Event, Frame
from mikas.link.base import BITS_PER_BYTE
from mikas.link.tee import Direction
from mikas.recording.capture.reader import CaptureReader, Packet, Problem, Source
from mikas.recording.exchanges.matching import (
    NO_REQUEST,
    SILENCE,
    SILENCE_AFTER_SENDING,
    UNKNOWN,
    Matching,
    SentRequest,
    matched,
)
from mikas.recording.exchanges.result import GAP, JUMP, Exchanges, Requests, Responses

DEFAULT_BAUD = 9600  # §1
_STRETCH = 1024  # packets


@dataclass(frozen=True, slots=True)
class Mark:
    """Up to which byte of its direction a packet reaches, its time and its place in the file."""

    end: int
    time: float
    offset: int


@dataclass(frozen=True, slots=True)
class LineEvent:
    """A frame, damage, or the bytes of an abandoned frame. `first`, `last`: the packets with its
    first and last byte.

    `began`: when its first byte began on the wire. `answers`: the request that a received frame
    answers. `after`: the serial of the last request before it.
    """

    direction: Direction
    event: Event | bytes
    first: Mark
    last: Mark
    began: float
    echo: bool = False
    answers: SentRequest = UNKNOWN
    after: int = NO_REQUEST


class _Stream:
    """One direction: a decoder, and which packet brought which byte."""

    def __init__(self, byte_time: float) -> None:
        self.last: float | None = None
        self._byte_time = byte_time
        self._decoder = Decoder()
        self._marks: deque[Mark] = deque()

    def feed(self, packet: Packet) -> Iterator[tuple[Event, Mark, Mark, float]]:
        """Yield the events that the packet completes, with their marks and begins."""
        self.last = packet.time
        end = self._decoder.offset + len(packet.data)
        self._marks.append(Mark(end, packet.time, packet.offset))
        for event in self._decoder.feed(packet.data):
            data = event.wire if isinstance(event, Frame) else event.data
            yield event, *self._place(event.offset, len(data))
        self._forget(self._decoder.offset - len(self._decoder.pending))

    def cut(self) -> tuple[bytes, Mark, Mark, float] | None:
        """Abandon the unfinished frame, if there is one."""
        left = self._decoder.reset()
        if not left:
            return None
        return left, *self._place(self._decoder.offset - len(left), len(left))

    def _place(self, start: int, length: int) -> tuple[Mark, Mark, float]:
        """Return the first and last packet, and when the first byte began on the wire.

        That is the earliest time that any packet with a byte of the frame implies: a packet may
        have been delayed (`mikas.tester.exchange`).
        """
        self._forget(start)
        first = self._marks[0]
        began = first.time - (first.end - start) * self._byte_time
        for mark in self._marks:
            began = min(began, mark.time - (mark.end - start) * self._byte_time)
            if mark.end >= start + length:
                return first, mark, began
        raise AssertionError("a byte that no packet brought")

    def _forget(self, start: int) -> None:
        while self._marks and self._marks[0].end <= start:
            self._marks.popleft()


class Line:
    """One port: both directions, and the state of the matching."""

    def __init__(self, source: Source) -> None:
        self._byte_time = BITS_PER_BYTE / (source.baud or DEFAULT_BAUD)
        self._streams = {direction: _Stream(self._byte_time) for direction in Direction}
        self._sent_last = False
        self._matching = Matching()

    def take(self, packet: Packet) -> Iterator[LineEvent]:
        """Yield the events that this packet completes."""
        stream, matching = self._streams[packet.direction], self._matching
        is_sent = packet.direction is Direction.SENT
        if self._is_late(packet, stream):
            yield from self._cut(packet.direction)
        if is_sent and not self._sent_last:
            matching.turn()
        for event, first, last, began in stream.feed(packet):
            wire = event.wire if isinstance(event, Frame) else event.data
            body = event.body if isinstance(event, Frame) else None
            if is_sent:
                matching.sent(wire, body)
                yield LineEvent(packet.direction, event, first, last, began)
            else:
                echo = matching.received(wire, body)
                answers = UNKNOWN if echo else matching.answered
                place = packet.direction, event, first, last, began
                yield LineEvent(*place, echo, answers, matching.count - 1)
        self._sent_last = is_sent

    def interrupt(self) -> None:
        """Note that a part of the file is missing here."""
        self._matching.interrupt()

    def finish(self) -> Iterator[LineEvent]:
        """Yield the unfinished frames."""
        for direction in Direction:
            yield from self._cut(direction)

    def _is_late(self, packet: Packet, stream: _Stream) -> bool:
        if stream.last is None:
            return False
        begin = packet.time - len(packet.data) * self._byte_time
        answered = packet.direction is Direction.RECEIVED and self._sent_last
        return begin - stream.last > (SILENCE_AFTER_SENDING if answered else SILENCE)

    def _cut(self, direction: Direction) -> Iterator[LineEvent]:
        if (cut := self._streams[direction].cut()) is not None:
            yield LineEvent(direction, *cut)


class ScalarMatcher:
    """The exchanges of one port of one recording."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._line = Line(source)
        self._bodies: list[bytes] = []
        self._numbers: dict[bytes, int] = {}
        self._sent = 0
        self._last: float | None = None

    def interrupt(self) -> None:
        """Note that a part of the file is missing here."""
        self._line.interrupt()

    def feed(self, packets: Sequence[Packet]) -> Exchanges:
        """Return the exchanges that these packets complete."""
        sent: list[tuple[int, float, int]] = []
        received: list[tuple[float, int, int, int, int, int, int]] = []
        bodies, damaged = bytearray(), array("q")
        gaps: list[tuple[float, float]] = []
        echoes, raw_checksum = 0, False
        for packet in packets:
            if self._last is not None and packet.time - self._last > GAP:
                gaps.append((self._last, packet.time))
            self._last = packet.time
            for item in self._line.take(packet):
                echoes += item.echo
                match item.event:
                    case Frame(body, wire) if item.direction is Direction.SENT:
                        sent.append((self._number(body), item.first.time, len(wire)))
                    case Damage() as damage if item.direction is Direction.SENT:
                        sent.append((NO_REQUEST, item.first.time, len(damage.data)))
                    case Frame(body, wire) as frame if not item.echo:
                        raw_checksum |= frame.raw_checksum
                        serial, number = item.answers.serial, self._number(item.answers.body)
                        place = len(bodies), len(body), len(wire)
                        received.append((item.began, serial, number, item.after, *place))
                        bodies += body
                    case Damage() if not item.echo:
                        damaged.append(item.after)
        requests = Requests(
            self._sent,
            array("q", (number for number, _, _ in sent)),
            array("d", (time for _, time, _ in sent)),
            array("q", (length for _, _, length in sent)),
        )
        self._sent += len(sent)
        serials, numbers, after, starts, lengths, wire_lengths = (
            array("q", (int(row[at]) for row in received)) for at in range(1, 7)
        )
        times = array("d", (row[0] for row in received))
        places = starts, lengths, wire_lengths
        responses = Responses(times, serials, numbers, after, bytes(bodies), *places)
        return Exchanges(
            source=self._source,
            bodies=self._bodies,
            requests=requests,
            responses=responses,
            damaged=damaged,
            echoes=echoes,
            raw_checksum=raw_checksum,
            gaps=gaps,
            begin=packets[0].time,
            end=packets[-1].time,
        )

    def _number(self, body: bytes | None) -> int:
        if body is None:
            return NO_REQUEST
        number = self._numbers.setdefault(body, len(self._bodies))
        if number == len(self._bodies):
            self._bodies.append(body)
        return number


def scalar_exchanges(path: str | os.PathLike[str]) -> Iterator[Exchanges | Problem]:
    """Yield the exchanges without numpy."""
    return matched(_stretches(CaptureReader(path)), lambda it: it[0].source, ScalarMatcher)


def _stretches(items: Iterable[Packet | Problem]) -> Iterator[Sequence[Packet] | Problem]:
    waiting: list[Packet] = []
    for item in items:
        if waiting and (len(waiting) == _STRETCH or not _continues(waiting[-1], item)):
            yield waiting
            waiting = []
        if isinstance(item, Problem):
            yield item
        else:
            waiting.append(item)
    if waiting:
        yield waiting


def _continues(last: Packet, item: Packet | Problem) -> bool:
    if isinstance(item, Problem):
        return False
    return item.source == last.source and item.time >= last.time - JUMP
