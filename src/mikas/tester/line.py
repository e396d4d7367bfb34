"""One request out, one response in, on a wire that echoes (D1, D2, D14). No retries here.

`Line` sends a frame, compares its echo byte by byte, collects the response's frame, and waits for
silence. A failure is an error with the bytes sent and received and the time; the tester reacts.

The logger `mikas.tester` gets at DEBUG every frame sent (`>`) or received (`<`) and every failure
(`!`).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from math import inf
from typing import TYPE_CHECKING

from mikas.errors import (
    DamagedResponse,
    EchoDiffers,
    LineNotQuiet,
    MikasError,
    NoEcho,
    NoResponse,
    ReadingSuspended,
    hex_dump,
)
from mikas.framing import Damage, DamageReason, Decoder, Frame, encode
from mikas.i18n import Text
from mikas.link import Chunk, Link
from mikas.link.base import AwaitedAnswer
from mikas.tester.exchange import Reply, TimedDecoder, Timing

if TYPE_CHECKING:
    from logging import Logger

_DEBUG = 10  # logging.DEBUG; the module is imported when a line is opened
WRONG_CHECKSUM = Text("the checksum is wrong", "неверна контрольная сумма")
_DAMAGE = {
    DamageReason.CHECKSUM: WRONG_CHECKSUM,
    DamageReason.TOO_LONG: Text("it has no end", "у него нет конца"),
    DamageReason.IRREGULAR_ESCAPE: Text("an escape is wrong", "неверна замена байта"),
}
_LONGER = 1.2  # times the link's granularity: more than the longest pause that is none on the wire
_OVERHEAD = 2  # bytes of a response besides its body, at least: checksum and terminator
_LONGEST = 1100  # bytes of the longest response, all of them stuffed
# What goes on longer than this has no end, however it drips: the time of the longest, by so much,
_SLOWEST = 2
_PAUSES = 5  # and so many of the longest pauses
_AT_ONCE = 10  # responses in the time of a wire, after which it is one
_NOTHING = Chunk(b"", 0.0)
_CUT = Text("it ends in the middle", "он обрывается на середине")
_TOO_SOON = Text("it began while the request was being sent", "он начался, пока посылался запрос")
_DOUBLED = Text("more than one response came", "пришло больше одного ответа")


def _logger() -> Logger:
    from logging import NullHandler, getLogger

    logger = getLogger("mikas.tester")
    if not logger.handlers:
        logger.addHandler(NullHandler())
    return logger


@contextmanager
def _logged_errors() -> Iterator[None]:
    try:
        yield
    except MikasError as error:
        log = _logger()
        if log.isEnabledFor(_DEBUG):
            received = f" (received {hex_dump(error.received)})" if error.received else ""
            log.debug("! %s%s", error.reason.en, received)
        raise


class Line:
    """Requests and responses on a link.

    `echo`: whether the line returns the sent bytes. `raw_checksum`, `strict`: D3, D4.
    """

    def __init__(self, link: Link, timing: Timing, *, raw_checksum: bool, strict: bool) -> None:
        self.link = link
        self.timing = timing
        self.echo = True  # set by the handshake
        self.raw_checksum = raw_checksum
        self.strict = strict
        # When the last byte of the latest request was sent: not before, and at the latest. A busy
        # computer may hold the program between its look at the clock and the write (D14).
        self.sent_until: float = -inf
        self.sent_at_latest: float = -inf
        self.pause: float = 0.0  # s that a request keeps from the latest response (D14)
        self.heard: float = -inf  # when the latest byte that was no echo arrived
        self.gap: float = inf  # s between that byte and the latest request
        self.answered_gaps: deque[float] = deque(maxlen=8)  # of the latest answered requests
        # When the echo had arrived; an adapter may generate it before the bytes are sent.
        self.echo_heard: float = -inf
        # Responses for which the other end may be an emulator that answers sooner than a wire
        # carries the request.
        self._at_once = 0
        self.silences: int = 0  # how often two requests in a row got no byte: the unit was off
        self._unanswered = 0  # requests in a row
        self.noise: int = 0  # bare terminators around responses, which are skipped (D5)
        self.suspension: ReadingSuspended | None = None
        """The latest time without reading that is still to be reported; no short one."""
        self._ahead = _NOTHING  # received together with the end of an echo
        self._log = _logger()

    @property
    def idle_time(self) -> float:
        """Seconds of silence, as seen through this link, that count as a quiet line (D13, D14)."""
        return max(self.timing.idle_time, _LONGER * self.link.granularity)

    def exchange(self, body: bytes, *, of_many: bool = False, confirms: bool = False) -> Reply:
        """Send `body`; return its only response, or the first one with `of_many`.

        `confirms`: a `01` that confirms the synchronization (D13). Raises `NoEcho` or a
        `LineError`.
        """
        wire = self.send(body)
        self.await_echo(wire)
        return self.receive(wire, of_many=of_many, confirms=confirms)

    def send(self, body: bytes, *, in_stream: bool = False) -> bytes:
        """Send `body` without waiting for the echo; return the wire form.

        `in_stream`: at once, into a gap of a stream; other requests wait until the pause is over.
        """
        wire = encode(body, raw_checksum=self.raw_checksum)
        if not in_stream and self.link.now() < self.heard + self.pause:
            self.wait_for_quiet(0.0, until=self.heard + self.pause)
        self._ahead = _NOTHING
        now = self.link.now()
        self.gap = now - self.heard
        self.sent_until = self.sent_at_latest = now + len(wire) * self.link.byte_time
        self._log_frame(">", wire)
        with self._noting_suspension():
            self.link.write(wire)
        self.sent_at_latest = self.link.now() + len(wire) * self.link.byte_time
        return wire

    def send_after(self, wire: bytes, length: int, body: bytes) -> bytes | None:
        """Let the link send `body` once the answer to `wire` has come; return its wire form.

        `length`: of that answer's body. None: the link can't, or the unit needs a pause.
        `sent_by_link` always follows.
        """
        if self.pause:
            return None
        following = encode(body, raw_checksum=self.raw_checksum)
        can = self.link.write_after(AwaitedAnswer(wire, length), following)
        return following if can else None

    def sent_by_link(self, wire: bytes) -> bool:
        """Whether the link has sent the `wire` of `send_after`; if not, it never will."""
        at = self.link.take_back()
        if at is None:
            return False
        self._ahead = _NOTHING
        self.gap = at - self.heard
        self.sent_until = self.sent_at_latest = at + len(wire) * self.link.byte_time
        self._log_frame(">", wire)
        return True

    @_logged_errors()
    def await_echo(self, wire: bytes, *, hasty: bool = False) -> None:
        """Check the echo of `wire`, which `send` has sent.

        `hasty`: read the echo as it arrives, even before the wire can have carried it.
        """
        if not self.echo:
            return
        if not hasty:  # the whole echo, a little late: the response is later
            self.link.gather(self.sent_until + self.link.byte_time / 2)
        self.echo_heard = self._check_echo(wire, self.sent_at_latest + self.timing.response_timeout)
        self.sent_until = max(self.sent_until, self.echo_heard)
        self.sent_at_latest = max(self.sent_at_latest, self.echo_heard)

    def _check_echo(self, wire: bytes, deadline: float) -> float:
        received = bytearray()
        while len(received) < len(wire):
            chunk = self.read(deadline)
            if not chunk.data:
                error = EchoDiffers if received else NoEcho
                if not received:
                    self.count_silence()
                raise error(request=wire, received=bytes(received), time=chunk.time)
            received += chunk.data
            compared = min(len(received), len(wire))
            if received[:compared] != wire[:compared]:
                raise EchoDiffers(request=wire, received=bytes(received), time=chunk.time)
        extra = bytes(received[len(wire) :])
        self._ahead = Chunk(extra, chunk.time)
        return chunk.time - len(extra) * self.link.byte_time

    @_logged_errors()
    def receive(
        self, wire: bytes, *, of_many: bool = False, min_length: int = 0, confirms: bool = False
    ) -> Reply:
        """Return the only response to the request `wire`, the latest that was sent.

        `of_many`: the first of a stream's responses; more may have arrived with it. `min_length`:
        bytes of the response's shortest possible body; the line is not read before so many can have
        arrived. `confirms`: as for `exchange`. The first byte is read at its arrival, so `began` is
        exact.
        """
        sent_at = self.sent_until
        decoder = self.decoder()
        received = bytearray()
        deadline = self.sent_at_latest + self.timing.response_timeout
        last = deadline + _SLOWEST * _LONGEST * self.link.byte_time + _PAUSES * self._pause()
        while True:
            chunk = self._next(deadline)
            if not chunk.data:
                if not received:
                    self.count_silence()
                    seconds = self.timing.response_timeout
                    raise NoResponse(seconds=seconds, request=wire, received=b"", time=chunk.time)
                raise damaged(wire, bytes(received), chunk.time, _CUT)
            if not received:
                if not self.echo:
                    self._check_not_too_soon(wire, chunk, confirms=confirms)
                self._unanswered = 0
            received += chunk.data
            self.heard = chunk.time
            deadline = chunk.time + self._pause()
            events = self._decoded(decoder, chunk)
            if not events and chunk.time > last:
                raise damaged(wire, bytes(received), chunk.time, DamageReason.TOO_LONG)
            if not events:
                # At most half of the longest pause inside a response (D14), which bounds the delay
                # of its detection.
                missing = min_length + _OVERHEAD - len(received)
                self._gather(chunk.time, missing, most=self.timing.inter_byte_timeout / 2)
                continue
            first, began = events[0]
            if isinstance(first, Damage):
                raise damaged(wire, bytes(received), chunk.time, first.reason)
            if not of_many and (len(events) > 1 or decoder.pending):
                # One of them answers an earlier request; which one is unknown (D13).
                raise damaged(wire, bytes(received), chunk.time, _DOUBLED)
            self._log_frame("<", first.wire)
            self.answered_gaps.append(self.gap)
            began = min(max(sent_at, began), chunk.time)
            return Reply(first.body, first.wire, began, chunk.time)

    def _check_not_too_soon(self, wire: bytes, chunk: Chunk, *, confirms: bool) -> None:
        """Raise for a response before the end of its request, unless an emulator answers at once.

        No echo shows the collision (D2), and two mixed frames may look valid. An emulator without a
        wire shows itself by the answer to a `01` that `confirms` the synchronization (D13): no
        other response is due then, and none follows.
        """
        if chunk.time >= self.sent_until + self.link.byte_time / 2:
            self._at_once = max(0, self._at_once - 1)
        elif self._at_once or confirms:
            self._at_once = _AT_ONCE
        else:
            raise damaged(wire, chunk.data, chunk.time, _TOO_SOON)

    def _log_frame(self, direction: str, wire: bytes) -> None:
        if self._log.isEnabledFor(_DEBUG):
            self._log.debug("%s %s", direction, hex_dump(wire))

    def count_silence(self) -> None:
        """Count a request without a response in `silences`."""
        self._unanswered += 1
        self.silences += self._unanswered == 2

    def decoder(self) -> TimedDecoder:
        """Create a decoder for the bytes that arrive from now on."""
        return TimedDecoder(Decoder(strict=self.strict), self.link.byte_time)

    def _decoded(self, decoder: TimedDecoder, chunk: Chunk) -> list[tuple[Frame | Damage, float]]:
        before = decoder.noise
        events = decoder.feed(chunk)
        self.noise += decoder.noise - before
        return events

    def _next(self, deadline: float) -> Chunk:
        if self._ahead.data:
            chunk, self._ahead = self._ahead, _NOTHING
            return chunk
        return self.read(deadline)

    def read(self, deadline: float) -> Chunk:
        """As `Link.read`. A time without reading is noted, and voids the exchange."""
        with self._noting_suspension():
            return self.link.read(deadline)

    @contextmanager
    def _noting_suspension(self) -> Iterator[None]:
        try:
            yield
        except ReadingSuspended as error:
            if not error.is_short:
                self.suspension = error
                self.silences += bool(error.received)  # another unit may answer, as after silence
            raise

    def _gather(self, since: float, count: int, *, most: float = inf) -> None:
        """Sleep until all but the last of `count` bytes after `since` can have arrived.

        A read takes the last one, for its time. Sleeps `most` seconds at most.
        """
        if count > 1:
            self.link.gather(since + min((count - 1) * self.link.byte_time, most))

    def _pause(self) -> float:
        return self.timing.inter_byte_timeout + self.link.byte_time

    def arrived(self, until: float = -inf) -> bytes:
        """Return bytes that no request caused, without waiting beyond `until` (D2)."""
        ahead, self._ahead = self._ahead.data, _NOTHING
        try:
            return ahead + self.read(max(until, self.link.now())).data
        except ReadingSuspended as error:
            return ahead + (error.received or b"")

    def wait_for_quiet(
        self, seconds: float, *, until: float = -inf, patience: float | None = None
    ) -> bytes:
        """Wait until `until`, and until `seconds` pass without a byte; return the bytes received.

        Raises `LineNotQuiet` if bytes still arrive after `until` and `patience` seconds (by default
        `seconds` and `timing.max_busy_time`).
        """
        received = bytearray(self.arrived())
        if patience is None:
            patience = seconds + self.timing.max_busy_time
        began = self.link.now()
        quiet_at, last = max(until, began + seconds), max(until, began + patience)
        while True:
            try:
                chunk = self.read(quiet_at)
            except ReadingSuspended:  # whether the line was quiet is unknown
                began = self.link.now()
                quiet_at, last = max(until, began + seconds), max(until, began + patience)
                continue
            if not chunk.data:
                return bytes(received)
            received += chunk.data
            self.heard = chunk.time
            quiet_at = max(until, chunk.time + seconds)
            if chunk.time > last:
                raise LineNotQuiet(received=bytes(received[-64:]), time=chunk.time)

    def next_frame(
        self, decoder: TimedDecoder, deadline: float, *, min_length: int, heard: float
    ) -> list[tuple[Frame | Damage, float]]:
        """Return a stream's next events with the times of their first bytes; [] at the deadline.

        `min_length`: bytes of the shortest possible body; `heard`: when the last byte arrived.
        """
        while True:
            missing = min_length + _OVERHEAD - len(decoder.pending)
            self._gather(heard, missing, most=max(0.0, deadline - heard))
            chunk = self._next(deadline)
            if not chunk.data:
                return []
            heard = chunk.time
            if events := self._decoded(decoder, chunk):
                for event, _ in events:
                    if isinstance(event, Frame):
                        self._log_frame("<", event.wire)
                    else:
                        self._log_frame("! damaged:", event.data)
                return events


def damaged(
    wire: bytes, received: bytes, time: float, damage: Text | DamageReason
) -> DamagedResponse:
    """Return the error for a damaged response to the request `wire`."""
    if isinstance(damage, DamageReason):
        damage = _DAMAGE[damage]
    return DamagedResponse(damage=damage, request=wire, received=received, time=time)
