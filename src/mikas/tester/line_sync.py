"""Synchronization with the ECU: when a response can be trusted (D12, D13).

A response has neither its command nor an id. `LineSync` knows until when a late response may still
arrive: `Timing.late` after the latest request (a failed one, a `01` of the resynchronization, the
last of a stream). It waits until then and for a quiet line, so the next response to `01` belongs to
that `01`. It is valid if it is exactly one, with the unit's version code, followed by silence.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from math import inf
from typing import Any, NamedTuple

from mikas import commands as c
from mikas.errors import (
    DamagedResponse,
    EchoOnly,
    LineError,
    LineNotQuiet,
    MikasError,
    NoEcho,
    NoResponse,
    SyncLost,
)
from mikas.framing import TERMINATOR, Decoder, Frame
from mikas.tester.exchange import Statistics
from mikas.tester.line import WRONG_CHECKSUM, Line

AVAILABILITY = b"\x01"

_ROUNDS = 5  # of D13
_HASTY_ROUNDS = 2  # of these, before a stream with long pauses is suspected
_INTERRUPTIONS = 6  # attempts to end a stream before a line break, D12
_CLEAN_TRIES = 3  # to end a stream cleanly: the first `01` often collides with a response
_FORGOTTEN = 0.1  # s after which a request is sent again: its response's time is unknown
_LEAVING = 0.5  # s of silence after which a stream has ended, on a line that is no longer used
_BREAK = 0.05  # s; much more than the ten bits of a byte


class LineSync:
    """Whether the next response belongs to the next request, and how to restore that."""

    def __init__(self, line: Line) -> None:
        self.line = line
        self.lost: bool = False
        self.found_again: int = 0  # resynchronizations (D13)
        self.breaks: int = 0  # without which a stream would not have ended (D12)
        # A stream may be running: its pause looks like a quiet line, its response like one to `01`.
        self.streaming: bool = False
        self._awaited = True  # the latest request's response may still arrive

    def mark_lost(self, error: BaseException | None = None) -> None:
        """Trust no response: after `error`, or before an exchange that may fail.

        A whole frame with a wrong checksum was the latest request's only response. After silence, a
        cut or another request's response the right one may still arrive.
        """
        over = isinstance(error, DamagedResponse) and error.fields.get("damage") == WRONG_CHECKSUM
        self.lost, self._awaited = True, not over

    def keep(self) -> None:
        """Trust the next response: the exchange succeeded."""
        self.lost = self.streaming = False

    def resynchronize(self, version_code: int) -> None:
        """Restore a lost synchronization, or one with bytes that no request caused.

        Raises `NoEcho` or `EchoOnly` if no ECU answers, `LineNotQuiet`, `SyncLost`.
        """
        if not self.lost:
            if not self.line.arrived(self.line.heard + self.line.pause):
                return
            self.mark_lost()
        self.found_again += 1
        if self.streaming:
            self._silence_for_good()
        failure: MikasError = SyncLost()
        for attempt in range(_ROUNDS):
            self.silence(patient=attempt >= _HASTY_ROUNDS)
            try:
                if self._confirm(version_code):
                    self.keep()
                    return
                failure = SyncLost()
            except (NoEcho, EchoOnly) as error:
                if type(error) is type(failure):  # twice in a row
                    raise
                failure = error
            except LineError as error:
                self.mark_lost(error)
                failure = error
        raise failure

    def _confirm(self, version_code: int) -> bool:
        """Whether exactly one response arrives, the unit's own, and then silence (D13)."""
        self.mark_lost()
        try:
            reply = self.line.exchange(AVAILABILITY, confirms=True)
        except NoResponse as error:
            raise no_ecu_error(error, echoes=self.line.echo) from error
        extra = self.line.wait_for_quiet(self.line.idle_time)
        return not extra and reply.body == bytes([version_code])

    def silence(self, *, patient: bool) -> bytes:
        """Wait until no response is due and the line is quiet; return the bytes received.

        A stream is ended, and only what follows its end is returned. A `patient` wait also detects
        one by strokes, with long pauses. Raises `LineNotQuiet` if a stream can't be ended.
        """
        seconds = self.line.timing.late if patient else self.line.idle_time
        try:
            return self.line.wait_for_quiet(seconds, until=self._late_until())
        except LineNotQuiet:
            self.interrupt(seconds)
            return self.line.wait_for_quiet(seconds, until=self._late_until())

    def _late_until(self) -> float:
        return self.line.sent_until + (self.line.timing.late if self._awaited else 0.0)

    def end_stream(
        self, version_code: int, *, by_strokes: bool, bytes_each: int, leaving: bool = False
    ) -> None:
        """End a stream (D12) and resynchronize. Raises as `resynchronize` does.

        `leaving`: nothing is requested any more, so it is not resynchronized, and waits are short.
        """
        own = bytes([version_code])
        tries = 0 if by_strokes or bytes_each == 1 else _CLEAN_TRIES
        for _ in range(tries):
            if _last_frame(self.interrupt(self.line.idle_time)) == own:
                # No datum looks so: it was the answer to `01`, and the last response.
                self.streaming = self._awaited = False
                break
        else:
            unlike = None if bytes_each == 1 else own
            most = _LEAVING if leaving else inf
            self._silence_for_good(unlike, by_strokes=by_strokes, most=most)
        if not leaving:
            self.resynchronize(version_code)

    def _silence_for_good(
        self, own: bytes | None = None, *, by_strokes: bool = True, most: float = inf
    ) -> None:
        """End a possible stream with long pauses, or with data like the answer to `01`.

        `own`: that answer, if no datum looks like it. `most`: seconds of silence that are enough.
        """
        breaks = self.breaks
        last = _last_frame(self.interrupt(min(most, self.line.timing.late)))
        if by_strokes and self.breaks == breaks and (own is None or last != own):
            # At a standing engine the unit is silent anyway, and a unit may end a stream only after
            # a break and ignore `01`.
            self._break()
        self.streaming = False

    def interrupt(self, seconds: float) -> bytes:
        """End a stream by `01` in a gap, repeated if necessary, finally by a line break (D12).

        The stream has ended after `seconds` of silence. Returns the bytes after the last attempt.
        Raises `LineNotQuiet` if the unit still sends.
        """
        self.mark_lost()
        for attempt in range(_INTERRUPTIONS + 1):
            if attempt < _INTERRUPTIONS:
                self._wait_for_gap()
                self.line.send(AVAILABILITY, in_stream=True)
            else:
                self._break()
            try:
                return self.line.wait_for_quiet(seconds, patience=2 * self.line.idle_time)
            except LineNotQuiet:
                if attempt == _INTERRUPTIONS:
                    raise
        raise AssertionError("the last attempt returns or raises")

    def _break(self) -> None:
        self.breaks += 1
        self.line.link.send_break(_BREAK)

    def _wait_for_gap(self) -> None:
        """Wait for the end of a response, or for a short silence."""
        link, timing = self.line.link, self.line.timing
        deadline = link.now() + timing.max_busy_time
        while link.now() < deadline:
            chunk = self.line.read(link.now() + timing.stream_gap)
            if not chunk.data or chunk.data[-1] == TERMINATOR:
                return


def _last_frame(received: bytes) -> bytes | None:
    decoder = Decoder()
    events = decoder.feed(received)
    last = events[-1] if events and not decoder.pending else None
    return last.body if isinstance(last, Frame) else None


def no_ecu_error(error: NoResponse, *, echoes: bool) -> EchoOnly | NoEcho:
    """Return the error for silence after `01`: no ECU, or without an echo perhaps no adapter."""
    if echoes:
        return EchoOnly(request=error.request, received=error.request, time=error.time)
    return NoEcho(request=error.request, received=b"", time=error.time)


class _Sent(NamedTuple):
    """A request's body, and as it is on the wire."""

    body: bytes
    wire: bytes


class RequestAhead:
    """A request that is sent before its exchange begins, while the last response is interpreted.

    At most one is under way. Its response is taken by an exchange of the same body, or awaited and
    dropped before anything else is sent. From its first byte until either has happened, an
    interrupt (Ctrl-C) leaves the synchronization lost (D13): its response never passes for another
    one's. The caller holds the tester's lock.

    `announced`: the request that `send` sends next; any thread may set it. `sent`: the one whose
    response no exchange has asked for yet.
    """

    def __init__(self, sync: LineSync, statistics: Statistics) -> None:
        self.announced: c.Command[Any] | None = None
        self.sent: _Sent | None = None
        self._line = sync.line
        self._sync = sync
        self._statistics = statistics

    def forget(self) -> None:
        """Forget all, before the line is synchronized by a handshake."""
        self.announced = self.sent = None

    def send(self, *, after: c.Command[Any]) -> None:
        """Send the announced request, unless the link has, or it or `after` changes something.

        On a line without an echo nothing is sent (D2).
        """
        command = self._may_follow(after)
        self.announced = None
        if command is None or self.sent is not None:
            return
        body = command.body()
        self._sync.mark_lost()
        self.sent = _Sent(body, self._line.send(body))
        self._sync.keep()

    @contextmanager
    def by_link(self, wire: bytes, command: c.Command[Any]) -> Iterator[None]:
        """Let the link send the announced request, if it can, while the block awaits an answer.

        That is the answer of `command` to `wire`; after the block the request is `sent`, or was
        never sent.
        """
        prepared = self._prepared(wire, command)
        try:
            yield
        finally:
            if prepared is not None and self._line.sent_by_link(prepared.wire):
                self.sent = prepared

    def _prepared(self, wire: bytes, command: c.Command[Any]) -> _Sent | None:
        lengths, following = command.response_lengths(), self._may_follow(command)
        if following is None or len(lengths) != 1:
            return None
        body = following.body()
        following_wire = self._line.send_after(wire, lengths[0], body)
        return None if following_wire is None else _Sent(body, following_wire)

    def _may_follow(self, command: c.Command[Any]) -> c.Command[Any] | None:
        """Return the announced request, if it may be sent without a decision of the caller."""
        following = self.announced
        if following is None or not (self._line.echo and command.repeatable) or self._line.pause:
            return None
        return following if following.repeatable else None

    def claim(self, body: bytes) -> bytes | None:
        """Return the wire form of `body` if it is under way, for whoever awaits the response.

        None: it is not, or so long ago that nothing says when the response began. The line then
        counts as lost until the exchange has succeeded.
        """
        sent = self.sent
        if sent is None or self._sync.lost or sent.body != body:
            return None
        if self._line.link.now() > self._line.sent_until + _FORGOTTEN:
            return None
        self._sync.mark_lost()
        self.sent = None
        return sent.wire

    def settle(self) -> None:
        """Await and drop the response that is under way; raises no `MikasError`."""
        if self.sent is None:
            return
        was_lost = self._sync.lost
        self._sync.mark_lost()
        sent, self.sent = self.sent, None
        self._statistics.requests += 1
        try:
            self._line.await_echo(sent.wire)
            self._line.receive(sent.wire)
        except MikasError as error:  # the next request meets it
            self._sync.mark_lost(error)
            return
        if not was_lost:
            self._sync.keep()
