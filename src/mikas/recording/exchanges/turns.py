"""Recorded exchanges without numpy: the result of `exchanges.scalar`, several times faster (D13).

Where numpy has not all that `exchanges.columnar` needs, as in a browser. A turn is regular if it is
one request of one frame in one packet, then its echo, if the line has one, and nothing but sound
frames. Of such turns a loop takes the exchanges itself; all others go frame by frame through
`PortDecoder`.
"""

from __future__ import annotations

import os
from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from itertools import accumulate
from typing import BinaryIO, Final

from mikas.framing import ESCAPE, TERMINATOR, Decoder, Frame, unstuff
from mikas.link.base import Direction
from mikas.recording.capture.blocks import Order
from mikas.recording.capture.notes import Note
from mikas.recording.capture.reader import Blocks, Packet, Problem, Source
from mikas.recording.exchanges.matching import AVAILABILITY, SILENCE, matched
from mikas.recording.exchanges.result import Exchanges, ExchangesOf
from mikas.recording.exchanges.runs import PacketRun, read, stretches, walk
from mikas.recording.exchanges.scalar import FoundExchanges, PortDecoder

_LONGEST: Final = 4096  # bytes of a frame: the decoder's limit
_MOST_REQUESTS: Final = 4096  # that are remembered
_Frames = list[tuple[float, bytes, int]]


def quick_exchanges(path: str | os.PathLike[str]) -> Iterator[Exchanges | Problem | Note]:
    """Yield the exchanges of a capture. Raise as `CaptureReader` does."""
    return matched(read(path), lambda run: run.source, TurnMatcher)


def responses_in(file: BinaryIO, piece: range, order: Order, blocks: Blocks) -> tuple[int, int]:
    """Return what `columnar.responses_in` does; here the run is the piece."""
    runs = stretches(walk(file, piece.start, order, piece.stop, blocks))
    found = matched(runs, lambda run: run.source, TurnMatcher)
    count = sum(len(each.responses.times) for each in found if isinstance(each, ExchangesOf))
    return count, len(piece)


class TurnMatcher:
    """The exchanges of one port of one recording."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._port = PortDecoder(source)
        self.matching = self._port.matching
        self._last: float | None = None
        self._requests: dict[bytes, bytes | None] = {}  # body by packet; None: not regular

    def feed(self, run: PacketRun) -> Exchanges:
        """Return the exchanges that these packets complete."""
        found = FoundExchanges(self.matching)
        sent, count, at = bytes(run.sent), len(run.times), 0
        while at < count:
            done = at
            if sent[at] and self.matching.echoes is not None and self._port.is_between_frames:
                done = self._regular(run, sent, at, found)
            if done == at:
                done = sent.find(1, at + 1)
                done = count if done < 0 else done
                self._irregular(run, at, done, found)
            at = done
        exchanges = found.exchanges(self._source, run.times, self._last)
        self._last = run.times[-1]
        return exchanges

    def _irregular(self, run: PacketRun, start: int, stop: int, found: FoundExchanges) -> None:
        for at in range(start, stop):
            way = Direction.SENT if run.sent[at] else Direction.RECEIVED
            packet = Packet(way, run.data[at], run.times[at], 0, source=self._source)
            for item in self._port.feed(packet):
                found.add_item(item)

    def _regular(self, run: PacketRun, sent: bytes, start: int, found: FoundExchanges) -> int:
        """Take the regular turns from the packet `start` on; return the packet after them."""
        times, data = run.times, run.data
        bodies, number_of, known = found.bodies, self.matching.number, self._requests
        echoes = bool(self.matching.echoes)
        numbers, asked, lengths = (column.append for column in found.requests)
        began, serials, answered, after, begins, sizes, wires = (
            column.append for column in found.responses
        )
        first = serial = self.matching.count
        before: bytes | None = None
        body: bytes | None = None
        at, count = start, len(times)
        while at < count:
            wire = data[at]
            request = known[wire] if wire in known else self._request(wire)
            stop = sent.find(1, at + 1)
            stop = count if stop < 0 else stop
            if request is None or stop == at + 1:
                break
            if (frames := self._received(run, at + 1, stop, wire if echoes else b"")) is None:
                break
            number = number_of(request)
            numbers(number)
            asked(times[at])
            lengths(len(wire))
            for time, sound, length in frames:
                plain = unstuff(sound)[0][:-1] if ESCAPE in sound else sound[:-1]
                began(time)
                serials(serial)
                answered(number)
                after(serial)
                begins(len(bodies))
                sizes(len(plain))
                wires(length)
                bodies += plain
            serial += 1
            before, body = body, request
            at = stop
        if body is not None:
            found.echoes += (serial - first) * echoes
            last = sent.rfind(1, start, at)
            self.matching.follow(serial - first, before, body, data[last])
            self._port.pass_over(times[last], times[at - 1])
        return at

    def _request(self, wire: bytes) -> bytes | None:
        """Return the body of a packet that is one regular request; else None."""
        events = Decoder().feed(wire)
        body = None
        if len(events) == 1 and isinstance(event := events[0], Frame):
            is_plain = event.wire == wire and not event.raw_checksum
            body = event.body if is_plain and event.body != AVAILABILITY else None
        if len(self._requests) < _MOST_REQUESTS:
            self._requests[wire] = body
        return body

    def _received(self, run: PacketRun, start: int, stop: int, echo: bytes) -> _Frames | None:
        """Return the frames after the echo in the packets of a turn, as `_frames` does."""
        data = run.data
        if echo and stop == start + 2 and data[start] == echo:
            start, echo = start + 1, b""  # the usual packets: the echo, the response
        got = b"".join(data[start:stop]) if stop > start + 1 else data[start]
        if not got.startswith(echo):
            return None
        frame = got[len(echo) : -1]
        is_one = stop == start + 1 and TERMINATOR not in frame
        if is_one and _is_sound(frame) and got[-1] == TERMINATOR:
            length = len(frame) + 1
            return [(run.times[start] - length * self._source.byte_time, frame, length)]
        return self._frames(got, len(echo), run.times[start:stop], data[start:stop])

    def _frames(
        self, got: bytes, start: int, times: Sequence[float], data: Sequence[bytes]
    ) -> _Frames | None:
        """Return time, bytes without the terminator, and length of the frames after `start`, with
        their packets; None if there is anything else.
        """
        byte_time = self._source.byte_time
        lengths = list(map(len, data))
        ends = list(accumulate(lengths))
        steps = zip(times[1:], times, lengths[1:], strict=False)
        silent = any(one - size * byte_time - other > SILENCE for one, other, size in steps)
        if silent or not all(lengths) or (len(got) > start and got[-1] != TERMINATOR):
            return None
        frames: _Frames = []
        for frame in got[start:-1].split(b"\x0d") if len(got) > start else ():
            if not _is_sound(frame):
                return None
            stop = start + len(frame) + 1
            packets = range(bisect_right(ends, start), bisect_left(ends, stop) + 1)
            begun = (times[at] - (ends[at] - start) * byte_time for at in packets)
            frames.append((min(times[packets[0]], *begun), frame, len(frame) + 1))
            start = stop
        return frames


def _is_sound(frame: bytes) -> bool:
    """Return whether the bytes before a terminator are certainly a frame."""
    return not sum(frame) & 0xFF and 0 < len(frame) <= _LONGEST and frame[-1] != ESCAPE
