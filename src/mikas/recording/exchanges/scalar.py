"""The line frame by frame: what its frames are, and which request each one answers.

Each direction has a decoder of its own (§2); `exchanges.matching` has the rules. It is the
reference for `exchanges.columns` and `exchanges.turns`, which take irregular frames from here.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple

from mikas.commands import COMMANDS_BY_CODE
from mikas.framing import TERMINATOR, DamageReason, Decoder, Event, Frame
from mikas.i18n import Text
from mikas.link.base import Direction
from mikas.recording.capture.reader import Packet, Source
from mikas.recording.exchanges.fitting import Fitting
from mikas.recording.exchanges.matching import SILENCE, SILENCE_AFTER_SENDING, Matching
from mikas.recording.exchanges.verdicts import UNKNOWN, Doubt, Received, SentRequest, Verdict

UNFINISHED: Final = "unfinished"
"""Why an abandoned frame is damage, beside the values of `DamageReason`."""


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
    """A sound frame. `answers`: the request that a received frame answers; `doubt`: why none.

    `knows_list`: whether the unit's list (63) is known.
    """

    frame: Frame
    answers: SentRequest
    doubt: Doubt | None = None
    knows_list: bool = False
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


_TERMINATORS: Final = bytes([TERMINATOR])
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

    @property
    def offset(self) -> int:
        """The number of bytes so far."""
        return self._decoder.offset

    def feed(self, packet: Packet) -> Iterator[tuple[Event, _Place, Received]]:
        """Yield the events that the packet completes."""
        self.last_time = packet.time
        if not packet.data:
            return
        begin = self._decoder.offset
        self._packets.append(_PacketEnd(begin + len(packet.data), packet.time, packet.offset))
        for event in self._decoder.feed(packet.data):
            wire, body = (
                (event.wire, event.body) if isinstance(event, Frame) else (event.data, None)
            )
            start, end = event.offset, event.offset + len(wire)
            place = self._place(start, len(wire))
            rest = packet.data[max(0, end - begin) :]
            followed = bool(rest.strip(_TERMINATORS))
            times = place[0], place[1], place[3]
            yield event, place, Received(wire, body, start, end, *times, followed)
        self._drop_before(self._decoder.offset - len(self._decoder.pending))

    def abandon(self) -> tuple[bytes, _Place] | None:
        """Abandon the unfinished frame, if there is one."""
        left = self._decoder.reset()
        return (left, self._place(self._decoder.offset - len(left), len(left))) if left else None

    def _place(self, start: int, length: int) -> _Place:
        """Locate a part. Its first byte began at the earliest time that any of its packets implies:
        a packet may have been delayed (`mikas.tester.exchange.TimedInstrumentDecoder`).
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


_SENT: Final = Verdict(False, UNKNOWN, None)


class PortDecoder:
    """One port: both directions, and the state of the matching.

    `sent_last`: whether the last packet was a sent one.
    """

    def __init__(self, source: Source, fitting: Fitting) -> None:
        self.matching: Matching = Matching(fitting, source.byte_time)
        self._source = source
        self._directions = {direction: _Direction(source.byte_time) for direction in Direction}
        self.sent_last: bool = False

    def feed(self, packet: Packet) -> Iterator[DecodedFrame | DecodedDamage]:
        """Yield the parts that this packet completes."""
        decoder, matching = self._directions[packet.direction], self.matching
        is_sent = packet.direction is Direction.SENT
        if self._is_late(packet, decoder.last_time):
            yield from self._abandon(packet.direction)
        received = self._directions[Direction.RECEIVED].offset
        if is_sent:
            if not self.sent_last:
                matching.turn()
            if packet.data:
                matching.begin_sending(packet.time, received)
        for event, place, it in decoder.feed(packet):
            verdict = _SENT
            if is_sent:
                matching.sent(it.wire, it.body, place[0], received)
            else:
                verdict = matching.received(it)
            where = (self._source, packet.direction, *place, verdict.echo, matching.count - 1)
            if isinstance(event, Frame):
                knows_list = matching.listed is not None
                yield DecodedFrame(*where, event, verdict.answers, verdict.doubt, knows_list)
            else:
                yield DecodedDamage(*where, event.data, event.reason.value)
        self.sent_last = is_sent

    @property
    def is_between_frames(self) -> bool:
        """Whether no direction is inside a frame."""
        return all(each.is_between_frames for each in self._directions.values())

    def pass_over(self, sent: float | None, received: float | None) -> None:
        """Pass over packets of whole frames, matched without this; the times of the last ones."""
        for direction, time in ((Direction.SENT, sent), (Direction.RECEIVED, received)):
            if time is not None:
                self._directions[direction].last_time = time
        self.sent_last = received is None

    def finish(self) -> Iterator[DecodedDamage]:
        """Yield the unfinished frames."""
        for direction in Direction:
            yield from self._abandon(direction)

    def _is_late(self, packet: Packet, last_time: float | None) -> bool:
        if last_time is None:
            return False
        silence = packet.time - len(packet.data) * self._source.byte_time - last_time
        answered = packet.direction is Direction.RECEIVED and self.sent_last
        return silence > (SILENCE_AFTER_SENDING if answered else SILENCE)

    def _abandon(self, direction: Direction) -> Iterator[DecodedDamage]:
        if (abandoned := self._directions[direction].abandon()) is not None:
            data, place = abandoned
            reason = UNFINISHED
            if data.endswith(b"\x0d"):  # the decoder was waiting for a raw checksum 0D (D3)
                data, reason = data[:-1], DamageReason.CHECKSUM.value
            where = (self._source, direction, *place, False, self.matching.count - 1)
            yield DecodedDamage(*where, data, reason, abandoned=True)
