"""Recorded exchanges frame by frame: the reference for `exchanges.columnar`, without numpy.

Each direction has a decoder of its own (§2); `exchanges.matching` has the rules.
"""

from __future__ import annotations

import os
from array import array
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from mikas.commands import COMMANDS_BY_CODE
from mikas.framing import DamageReason, Decoder, Event, Frame
from mikas.i18n import Text
from mikas.link.base import Direction
from mikas.recording.capture.notes import Note
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
from mikas.recording.exchanges.result import (
    GAP,
    JUMP,
    LONGEST_PAUSE,
    Exchanges,
    ExchangesOf,
    Requests,
    Responses,
)

UNFINISHED: Final = "unfinished"
"""Why an abandoned frame is damage, beside the values of `DamageReason`."""
_MOST_PACKETS = 1024  # packets


@dataclass(frozen=True, slots=True)
class DecodedPart:
    """A part of the line. `begin`, `end`: times of the packets with its first and last byte.

    `offset`: place of the first of them in the file. `wire_time`: when the first byte began on the
    wire. `echo`: the line returned a sent frame. `after`: serial of the last request sent before.
    """

    source: Source
    direction: Direction
    begin: float
    end: float
    offset: int
    wire_time: float
    echo: bool
    after: int


@dataclass(frozen=True, slots=True)
class DecodedFrame(DecodedPart):
    """A sound frame. `answers`: the request that a received frame answers."""

    frame: Frame
    answers: SentRequest
    meaning: Text | None = None

    @property
    def request(self) -> bytes | None:
        """The body that this frame answers; None for sent frames and echoes."""
        return self.answers.body

    @property
    def name(self) -> str | None:
        """The command's name in the source, for a request."""
        is_request = self.echo or self.direction is Direction.SENT
        command = COMMANDS_BY_CODE.get(self.frame.body[0]) if self.frame.body else None
        return command.SOURCE_NAME if command and is_request else None


@dataclass(frozen=True, slots=True)
class DecodedDamage(DecodedPart):
    """Bytes that are no frame. `reason`: a value of `DamageReason`, or `UNFINISHED`.

    `abandoned`: a frame that was not finished before a silence or the end.
    """

    data: bytes
    reason: str
    abandoned: bool = False


class _PacketEnd(NamedTuple):
    """Up to which byte of its direction a packet reaches, its time and its place in the file."""

    end: int
    time: float
    offset: int


_Place = tuple[float, float, int, float]  # `begin`, `end`, `offset`, `wire_time` of a part


class _Direction:
    """One direction: a decoder, and which packet brought which byte."""

    def __init__(self, byte_time: float) -> None:
        self.last_time: float | None = None
        self._byte_time = byte_time
        self._decoder = Decoder()
        self._packets: deque[_PacketEnd] = deque()

    @property
    def is_between_frames(self) -> bool:
        """Whether the next byte begins a frame."""
        return self._decoder.is_between_frames

    def feed(self, packet: Packet) -> Iterator[tuple[Event, _Place]]:
        """Yield the events that the packet completes."""
        self.last_time = packet.time
        if not packet.data:
            return
        end = self._decoder.offset + len(packet.data)
        self._packets.append(_PacketEnd(end, packet.time, packet.offset))
        for event in self._decoder.feed(packet.data):
            data = event.wire if isinstance(event, Frame) else event.data
            yield event, self._place(event.offset, len(data))
        self._drop_before(self._decoder.offset - len(self._decoder.pending))

    def abandon(self) -> tuple[bytes, _Place] | None:
        """Abandon the unfinished frame, if there is one."""
        left = self._decoder.reset()
        return (left, self._place(self._decoder.offset - len(left), len(left))) if left else None

    def _place(self, start: int, length: int) -> _Place:
        """Locate a part. Its first byte began at the earliest time that any of its packets implies:
        a packet may have been delayed (`mikas.tester.exchange.TimedDecoder`).
        """
        self._drop_before(start)
        first = self._packets[0]
        began = first.time
        for packet in self._packets:
            began = min(began, packet.time - (packet.end - start) * self._byte_time)
            if packet.end >= start + length:
                return first.time, packet.time, first.offset, began
        raise AssertionError("a byte without a packet")

    def _drop_before(self, start: int) -> None:
        while self._packets and self._packets[0].end <= start:
            self._packets.popleft()


class PortDecoder:
    """One port: both directions, and the state of the matching."""

    def __init__(self, source: Source) -> None:
        self.matching = Matching()
        self._source = source
        self._directions = {direction: _Direction(source.byte_time) for direction in Direction}
        self._sent_last = False

    def feed(self, packet: Packet) -> Iterator[DecodedFrame | DecodedDamage]:
        """Yield the parts that this packet completes."""
        decoder, matching = self._directions[packet.direction], self.matching
        is_sent = packet.direction is Direction.SENT
        if self._is_late(packet, decoder.last_time):
            yield from self._abandon(packet.direction)
        if is_sent and not self._sent_last:
            matching.turn()
        for event, place in decoder.feed(packet):
            wire, body = (
                (event.wire, event.body) if isinstance(event, Frame) else (event.data, None)
            )
            echo, answers = False, UNKNOWN
            if is_sent:
                matching.sent(wire, body)
            else:
                echo = matching.received(wire, body)
                answers = UNKNOWN if echo else matching.answered
            where = (self._source, packet.direction, *place, echo, matching.count - 1)
            if isinstance(event, Frame):
                yield DecodedFrame(*where, event, answers)
            else:
                yield DecodedDamage(*where, event.data, event.reason.value)
        self._sent_last = is_sent

    @property
    def is_between_frames(self) -> bool:
        """Whether no direction is inside a frame."""
        return all(each.is_between_frames for each in self._directions.values())

    def pass_over(self, sent: float | None, received: float | None) -> None:
        """Pass over packets of whole frames, matched without this; the times of the last ones."""
        for direction, time in ((Direction.SENT, sent), (Direction.RECEIVED, received)):
            if time is not None:
                self._directions[direction].last_time = time
        self._sent_last = received is None

    def finish(self) -> Iterator[DecodedDamage]:
        """Yield the unfinished frames."""
        for direction in Direction:
            yield from self._abandon(direction)

    def _is_late(self, packet: Packet, last_time: float | None) -> bool:
        if last_time is None:
            return False
        silence = packet.time - len(packet.data) * self._source.byte_time - last_time
        answered = packet.direction is Direction.RECEIVED and self._sent_last
        return silence > (SILENCE_AFTER_SENDING if answered else SILENCE)

    def _abandon(self, direction: Direction) -> Iterator[DecodedDamage]:
        if (abandoned := self._directions[direction].abandon()) is not None:
            data, place = abandoned
            reason = UNFINISHED
            if data.endswith(b"\x0d"):  # the decoder was waiting for a raw checksum 0D (D3)
                data, reason = data[:-1], DamageReason.CHECKSUM.value
            where = (self._source, direction, *place, False, self.matching.count - 1)
            yield DecodedDamage(*where, data, reason, abandoned=True)


class FoundExchanges:
    """The exchanges of one stretch, as they are found, column by column.

    `requests`: number, time, length. `responses`: time, serial and number of the request, serial of
    the last request before, start and length of the body, length on the wire.
    """

    def __init__(self, matching: Matching) -> None:
        self._matching = matching
        self._first = matching.count
        self.requests: tuple[array[Any], ...] = (array("q"), array("d"), array("q"))
        self.responses: tuple[array[Any], ...] = (array("d"), *(array("q") for _ in range(6)))
        self.bodies = bytearray()
        self.echoes = 0
        self._damaged = array("q")
        self._raw_checksum = False

    def add_item(self, item: DecodedFrame | DecodedDamage) -> None:
        """Take the next part of the line."""
        is_sent, number = item.direction is Direction.SENT, self._matching.number
        match item:
            case DecodedDamage(abandoned=True):
                pass
            case _ if item.echo:
                self.echoes += 1
            case DecodedDamage(data=wire) if is_sent:
                _append(self.requests, NO_REQUEST, item.begin, len(wire))
            case DecodedDamage():
                self._damaged.append(item.after)
            case DecodedFrame(frame=frame) if is_sent:
                _append(self.requests, number(frame.body), item.begin, len(frame.wire))
            case DecodedFrame(frame=frame, answers=(serial, request)):
                self._raw_checksum |= frame.raw_checksum
                place = len(self.bodies), len(frame.body), len(frame.wire)
                answered = serial, number(request), item.after
                _append(self.responses, item.wire_time, *answered, *place)
                self.bodies += frame.body

    def exchanges(self, source: Source, times: Sequence[float], last: float | None) -> Exchanges:
        """Return all of it. `times`: of the stretch's packets; `last`: of the one before them."""
        before = [times[0] if last is None else last, *times[:-1]]
        pairs = zip(before, times, strict=True)
        return ExchangesOf(
            source=source,
            bodies=self._matching.bodies,
            requests=Requests(self._first, *self.requests),
            responses=Responses(bytes(self.bodies), *self.responses),
            damaged=self._damaged,
            echoes=self.echoes,
            raw_checksum=self._raw_checksum,
            gaps=[(begin, end) for begin, end in pairs if end - begin > GAP],
            begin=times[0],
            end=times[-1],
        )


class ScalarMatcher:
    """The exchanges of one port of one recording."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._port = PortDecoder(source)
        self.matching = self._port.matching
        self._last: float | None = None

    def feed(self, packets: Sequence[Packet]) -> Exchanges:
        """Return the exchanges that these packets complete."""
        found = FoundExchanges(self.matching)
        for packet in packets:
            for item in self._port.feed(packet):
                found.add_item(item)
        times = [packet.time for packet in packets]
        exchanges = found.exchanges(self._source, times, self._last)
        self._last = times[-1]
        return exchanges


def _append(columns: Iterable[array[Any]], *row: float) -> None:
    for column, value in zip(columns, row, strict=True):
        column.append(value)


def scalar_exchanges(path: str | os.PathLike[str]) -> Iterator[Exchanges | Problem | Note]:
    """Yield the exchanges without numpy, and without notes."""
    return matched(_stretches(CaptureReader(path)), lambda it: it[0].source, ScalarMatcher)


def _stretches(items: Iterable[Packet | Problem]) -> Iterator[Sequence[Packet] | Problem]:
    waiting: list[Packet] = []
    for item in items:
        if waiting and (len(waiting) == _MOST_PACKETS or not _continues(waiting[-1], item)):
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
    return item.source == last.source and -JUMP <= item.time - last.time <= LONGEST_PAUSE
