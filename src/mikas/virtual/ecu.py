"""The virtual Mikas on its wire: bytes in, bytes out, on the caller's clock (§3, D12, D15, D16).

No I/O, no clock, no sleep: the same times and bytes give the same responses. The bus calls
`receive` with the bytes on the wire, and `transmit` at the earlier one of `next_change` and
`next_transmission`, and puts the returned bytes on the wire. While the line is busy (D2),
`next_transmission` can wait, `next_change` cannot.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from math import inf, nextafter

from mikas import commands as c
from mikas.framing import ESCAPE, TERMINATOR, Decoder, Frame, checksum, encode
from mikas.virtual.quirks import ChecksumForm, StreamEnd
from mikas.virtual.responder import Responder, Stream

PARTIAL_REQUEST_LIFE = 0.1  # s that a unit waits for the rest of a request
MOST_ANSWERS = 4  # responses that wait for the line to become idle; a real unit has one buffer
STANDING_ENGINE_CHECK = 0.05  # s between checks whether a standing engine turns again
_GOLDEN = 0.6180339887498949  # its multiples, modulo 1, are spread as evenly as any
_ROUNDING = 1e-6  # s; a request that begins exactly after the least pause is not too soon


@dataclass(frozen=True, slots=True)
class EcuEvent:
    """An event of the virtual unit, for its watcher.

    `kind`: request, response, silence, damaged, too-soon, stream, stream-end, power-on or
    power-off.
    """

    time: float
    kind: str
    data: bytes = b""


class VirtualEcu:
    """One unit. `baud`: the pace of its own transmissions."""

    def __init__(
        self,
        responder: Responder,
        *,
        baud: int = 9600,
        watcher: Callable[[EcuEvent], None] | None = None,
    ) -> None:
        self.responder = responder
        self.baud = baud
        self.watcher = watcher
        self._decoder = Decoder()
        self._received_at = -inf
        self._latest = -inf  # time given by the caller
        self._change: float | None = None  # of the supply; computed again once it has passed
        self._answers: deque[tuple[float, bytes]] = deque()
        self._free_at = -inf  # when its own last byte has left
        self._answered = -inf  # when its last response that was no stream's has left
        self._too_soon = False  # whether the request being received began within the least pause
        self._responses = 0  # so far
        self._stream: Stream | None = None
        self._due = inf  # the stream's next response; infinity: the engine stands
        self.on: bool = True
        """Whether the unit had supply at the latest time."""

    def receive(self, data: bytes, now: float) -> None:
        """Receive `data`, whose last byte ended at `now`."""
        self._follow_supply(now)
        if not self.on:
            return
        if now - self._received_at > PARTIAL_REQUEST_LIFE:
            self._decoder.reset()
        self._received_at = now
        ends = self.responder.quirks.stream_end
        if self._stream and ends is StreamEnd.BYTE:
            self._end_stream(now)
        if now <= self._free_at:
            self._decoder.reset()  # while transmitting, received bytes are a collision
            return
        if not self._decoder.pending:
            began, pause = now - len(data) * 10 / self.baud, self.responder.quirks.least_pause
            self._too_soon = pause > 0 and began + _ROUNDING < self._answered + pause
        for event in self._decoder.feed(data):
            if self._too_soon:
                self._report("too-soon", now)
            elif not isinstance(event, Frame):
                self._report("damaged", now, event.data)
            elif not self._accepts(event):
                self._report("damaged", now, event.wire)
            elif self._stream is None or ends is not StreamEnd.BREAK:
                self._end_stream(now)
                self._take(event.body, now)

    def receive_break(self, now: float) -> None:
        """Receive a break: the unit stops transmitting (D12)."""
        self._follow_supply(now)
        self._decoder.reset()
        self._answers.clear()
        self._free_at = min(self._free_at, now)
        self._end_stream(now)

    def next_change(self) -> float:
        """Return when the supply changes next."""
        if self._change is None or self._change <= self._latest:
            # A change that rounding puts at the latest time itself must not repeat for ever.
            change = self.responder.car.next_change(self._latest)
            self._change = max(change, nextafter(self._latest, inf))
        return self._change

    def next_transmission(self) -> float:
        """Return when it transmits next, or checks whether a standing engine turns again."""
        if not self.on:
            return inf
        if self._answers:
            return max(self._answers[0][0], self._free_at)
        if self._stream is None:
            return inf
        if self._due == inf:
            return self._latest + STANDING_ENGINE_CHECK
        if self._decoder.pending:  # D2: the line is busy; the stream waits
            return max(self._due, self._received_at + PARTIAL_REQUEST_LIFE)
        return self._due

    def transmit(self, now: float) -> bytes:
        """Return the frame whose first byte leaves now; empty: none is due."""
        self._follow_supply(now)
        if self._stream and self._due == inf:
            self._due = self._due_after(self._stream, now)
        if self.next_transmission() > now:
            return b""
        if self._answers:
            body = self._answers.popleft()[1]
            self._report("response", now, body)
        else:
            assert self._stream is not None  # nothing else is due
            body = self.responder.response_of(self._stream, now)
        wire = encode(body, raw_checksum=self.responder.quirks.raw_checksum)
        pauses = (len(wire) - 1) * self.responder.quirks.inter_byte
        self._free_at = now + len(wire) * 10 / self.baud + pauses
        if self._stream is None:
            self._answered = self._free_at
        else:
            self._due = self._due_after(self._stream, self._free_at + self._stream_gap(now))
        return wire

    def _stream_gap(self, now: float) -> float:
        """Return the seconds between two responses: a faster engine leaves less time (D16)."""
        quirks, car = self.responder.quirks, self.responder.car
        load = quirks.stream_load and quirks.stream_load * car.engine_speed(now) / 1000
        return quirks.stream_gap + load / 1000

    def _accepts(self, frame: Frame) -> bool:
        """Return whether the unit understands this form of a checksum 0D or 40 (D3)."""
        form = self.responder.quirks.accepts
        if form is ChecksumForm.BOTH or checksum(frame.body) not in (TERMINATOR, ESCAPE):
            return True
        return frame.raw_checksum is (form is ChecksumForm.RAW)

    def _turn_round(self) -> float:
        """Return the delay of the next response: evenly spread, the same in every session."""
        quirks = self.responder.quirks
        self._responses += 1
        share = self._responses * _GOLDEN % 1 * 2 - 1
        return max(0.0, quirks.turn_round + share * quirks.turn_round_spread)

    def _take(self, body: bytes, now: float) -> None:
        self._report("request", now, body)
        answer = self.responder.answer(body, now)
        turn_round = self._turn_round()
        if isinstance(answer, bytes) and len(self._answers) < MOST_ANSWERS:
            self._answers.append((now + turn_round, answer))
        elif answer is None or isinstance(answer, bytes):
            self._report("silence", now)
        else:
            self._stream, self._due = answer, self._due_after(answer, now + turn_round)
            self._report("stream", now, body)

    def _due_after(self, stream: Stream, ready: float) -> float:
        if isinstance(stream, c.StreamAtStroke):
            return self.responder.car.next_stroke(stream.stroke, ready)
        return ready

    def _end_stream(self, now: float) -> None:
        if self._stream:
            self._stream = None
            self._report("stream-end", now)

    def _follow_supply(self, now: float) -> None:
        self._latest = max(self._latest, now)
        on = self.responder.car.powered(now)
        if on == self.on:
            return
        self.on = on
        self._stream = None
        self._answers.clear()
        self._free_at = min(self._free_at, now)
        self._answered = -inf
        self._decoder.reset()
        if on:
            self.responder.power_cycle()
        self._report("power-on" if on else "power-off", now)

    def _report(self, kind: str, now: float, data: bytes = b"") -> None:
        if self.watcher:
            self.watcher(EcuEvent(now, kind, data))
