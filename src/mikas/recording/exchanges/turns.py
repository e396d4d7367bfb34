"""Recorded exchanges where numpy has not all that `exchanges.columns` needs: in a browser (D13).

A turn is regular if it is one request for data in one packet, its echo, if the line has one, one
response that fits and comes in time, and not a byte besides; or if a stream begins in it, with
nothing but sound frames. Of such turns a loop takes the exchanges itself, several times faster than
`exchanges.scalar`; all others go frame by frame through `PortDecoder`.
"""

from __future__ import annotations

import os
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache, partial
from itertools import accumulate
from typing import Any, BinaryIO, Final

import numpy as np

from mikas.commands.base import SizeOf
from mikas.framing import ESCAPE, TERMINATOR, Decoder, Frame, unstuff
from mikas.link.base import Direction
from mikas.recording.capture.blocks import Order
from mikas.recording.capture.notes import Note
from mikas.recording.capture.reader import Blocks, Packet, Problem, Source
from mikas.recording.exchanges.fitting import Fitting
from mikas.recording.exchanges.layouts import READ_LIST, STREAMS
from mikas.recording.exchanges.matching import SILENCE, Matching
from mikas.recording.exchanges.ports import matched
from mikas.recording.exchanges.result import GAP, Exchanges, Requests, Responses
from mikas.recording.exchanges.runs import PacketRun, read, stretches, walk
from mikas.recording.exchanges.scalar import DecodedDamage, DecodedFrame, PortDecoder
from mikas.recording.exchanges.verdicts import NO_REQUEST

_LONGEST: Final = 4096  # bytes of a frame: the decoder's limit
_Frames = list[tuple[float, bytes, int, float]]


def quick_exchanges(
    path: str | os.PathLike[str], size_of: SizeOf
) -> Iterator[Exchanges | Problem | Note]:
    """Yield the exchanges of a capture. Raise as `CaptureReader` does."""
    return matched(read(path), partial(TurnMatcher, fitting=Fitting(size_of)))


def responses_in(
    file: BinaryIO, piece: range, order: Order, blocks: Blocks, size_of: SizeOf
) -> tuple[int, int]:
    """Return what `columns.matcher.responses_in` does; here the run is the piece."""
    runs = stretches(walk(file, piece.start, order, piece.stop, blocks))
    found = matched(runs, partial(TurnMatcher, fitting=Fitting(size_of)))
    count = sum(len(each.responses.times) for each in found if isinstance(each, Exchanges))
    return count, len(piece)


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
        self.bodies: bytearray = bytearray()
        self.echoes: int = 0
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
        return Exchanges(
            source=source,
            bodies=self._matching.bodies,
            requests=Requests(self._first, *map(np.asarray, self.requests)),
            responses=Responses(
                np.frombuffer(bytes(self.bodies), np.uint8), *map(np.asarray, self.responses)
            ),
            damaged=np.asarray(self._damaged),
            lists_lost=self._matching.take_lists_lost(),
            echoes=self.echoes,
            raw_checksum=self._raw_checksum,
            gaps=[(begin, end) for begin, end in pairs if end - begin > GAP],
            begin=times[0],
            end=times[-1],
        )


class TurnMatcher:
    """The exchanges of one port of one recording."""

    def __init__(self, source: Source, fitting: Fitting) -> None:
        self._source = source
        self._fitting = fitting
        self._port = PortDecoder(source, fitting)
        self.matching: Matching = self._port.matching
        self._last: float | None = None

    def go_on(self, stream: bytes) -> None:
        """Go on with the responses to a stream whose request is missing."""
        self.matching.interrupt(stream)

    def feed(self, run: PacketRun) -> Exchanges:
        """Return the exchanges that these packets complete."""
        found = FoundExchanges(self.matching)
        sent, count, at = bytes(run.sent), len(run.times), 0
        while at < count:
            done = at
            known = self.matching.echoes is not None and self._port.is_between_frames
            if known and sent[at] and not self._port.sent_last:
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
        times, data, matching = run.times, run.data, self.matching
        matching.turn()
        matching.end_exchange(times[start])
        if not matching.trusted:
            return start
        bodies, number_of = found.bodies, matching.number
        echoes = bool(matching.echoes)
        numbers, asked, lengths = (column.append for column in found.requests)
        began, serials, answered, after, begins, sizes, wires = (
            column.append for column in found.responses
        )
        first = serial = matching.count
        body: bytes | None = None
        streams = False
        at, count = start, len(times)
        while at < count and not streams:
            wire = data[at]
            request = _request(wire)
            stop = sent.find(1, at + 1)
            stop = count if stop < 0 else stop
            if request is None or stop == at + 1:
                break
            frames = self._received(run, at, stop, wire if echoes else b"")
            streams = request[0] in STREAMS
            if frames is None or not (streams or self._is_answer(request, frames)):
                break
            number = number_of(request)
            numbers(number)
            asked(times[at])
            lengths(len(wire))
            for time, sound, length, _ in frames:
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
            body = request
            at = stop
        if body is not None:
            found.echoes += (serial - first) * echoes
            last = sent.rfind(1, start, at)
            matching.follow(serial - first, body, data[last], streams=body[0] in STREAMS)
            self._port.pass_over(times[last], times[at - 1])
        return at

    def _is_answer(self, request: bytes, frames: _Frames) -> bool:
        """Return whether this is the one response to a request for data."""
        if len(frames) != 1:
            return False
        _, sound, _, delay = frames[0]
        length = len(unstuff(sound)[0] if ESCAPE in sound else sound) - 1
        listed = self.matching.listed
        fits = request == READ_LIST and listed is None
        fits = fits or length == self._fitting.length(request, listed)
        return fits and delay <= self.matching.patience

    def _received(self, run: PacketRun, asked: int, stop: int, echo: bytes) -> _Frames | None:
        """Return the frames after the echo in the packets of a turn: time, bytes without the
        terminator, length, and s after the request and its echo.

        None if there is anything else, a frame that repeats the request, or one that began before
        the request was out.
        """
        data, times, byte_time = run.data, run.times, self._source.byte_time
        due = times[asked] + len(data[asked]) * byte_time
        start = asked + 1
        if echo and stop == start + 2 and data[start] == echo:
            due = max(due, times[start])
            start, echo = start + 1, b""  # the usual packets: the echo, the response
        if stop == start + 1:
            got = data[start]
            frame = got[len(echo) : -1]
            is_one = TERMINATOR not in frame and _is_sound(frame) and got[-1] == TERMINATOR
            if is_one and got.startswith(echo) and frame != data[asked][:-1]:
                length, time = len(frame) + 1, times[start]
                due = max(due, time) if echo else due
                if not self.matching.echoes and time - length * byte_time < due - byte_time / 2:
                    return None
                return [(time - length * byte_time, frame, length, time - due)]
        got = b"".join(data[start:stop])
        if not got.startswith(echo):
            return None
        frames = self._frames(got, len(echo), (due, times[start:stop]), data[start:stop])
        repeats = frames and any(it[1] == data[asked][:-1] for it in frames)
        too_soon = frames and not self.matching.echoes and frames[0][0] < due - byte_time / 2
        return None if repeats or too_soon else frames

    def _frames(
        self, got: bytes, start: int, timed: tuple[float, Sequence[float]], data: Sequence[bytes]
    ) -> _Frames | None:
        """Return what `_received` does of the bytes behind `start`. `timed`: when the request was
        sent, and the times of the packets.
        """
        due, times = timed
        byte_time = self._source.byte_time
        lengths = list(map(len, data))
        ends = list(accumulate(lengths))
        steps = zip(times[1:], times, lengths[1:], strict=False)
        silent = any(one - size * byte_time - other > SILENCE for one, other, size in steps)
        if silent or not all(lengths) or (len(got) > start and got[-1] != TERMINATOR):
            return None
        if start:
            due = max(due, times[bisect_left(ends, start)])
        frames: _Frames = []
        for frame in got[start:-1].split(b"\x0d") if len(got) > start else ():
            if not _is_sound(frame):
                return None
            stop = start + len(frame) + 1
            packets = range(bisect_right(ends, start), bisect_left(ends, stop) + 1)
            begun = (times[at] - (ends[at] - start) * byte_time for at in packets)
            first = times[packets[0]]
            frames.append((min(first, *begun), frame, len(frame) + 1, first - due))
            start = stop
        return frames


@lru_cache(maxsize=4096)
def _request(wire: bytes) -> bytes | None:
    """Return the body of a packet that is one regular request; else None."""
    events = Decoder().feed(wire)
    if len(events) != 1 or not isinstance(event := events[0], Frame) or event.raw_checksum:
        return None
    return event.body if event.wire == wire and event.body else None


def _append(columns: Iterable[array[Any]], *row: float) -> None:
    for column, value in zip(columns, row, strict=True):
        column.append(value)


def _is_sound(frame: bytes) -> bool:
    """Return whether the bytes before a terminator are certainly a frame."""
    return not sum(frame) & 0xFF and 0 < len(frame) <= _LONGEST and frame[-1] != ESCAPE
