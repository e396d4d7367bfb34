"""The tester: requests that can be trusted, on a line that can not (D1, D2, D11–D14).

The tester decides when to repeat, when to resynchronize, and how to interpret silence. It blocks;
the link has the clock and all waits. Several threads may use one tester; a stream holds its lock.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from math import inf
from typing import Any, TypeVar

from mikas import commands as c
from mikas.errors import (
    EcuRefused,
    LineError,
    MikasError,
    NoConnection,
    NoEcho,
    NoResponse,
    NotSupported,
    ReadingSuspended,
    errors_met_on,
    usage_error,
)
from mikas.link import Link
from mikas.tester.call_ends import CallEnds
from mikas.tester.exchange import Reply, Statistics, Timing
from mikas.tester.handshake import Echo, Handshake, ask_for_words
from mikas.tester.line import Line
from mikas.tester.line_sync import LineSync, RequestAhead
from mikas.tester.pauses import Pauses
from mikas.tester.stream import Stream

T = TypeVar("T")

_ATTEMPTS_AT_UNKNOWN = 2  # a unit that does not know a command is silent each time (D10)
_TURN = 0.02  # s that a waiting thread occupies the line at a time
_STREAM_CODES = frozenset(c.StreamCyclic.CODES + c.StreamAtStroke.CODES)


class Tester:
    """Exchanges requests with one ECU over `link`, after `connect()`.

    `line` has the time-outs and whether there is an echo, `sync` whether a stream may be running.
    `retries`: how often a failed exchange of a repeatable command is repeated. `pause`: the least
    seconds from a response to the next request (D14); None: found by trying where it is needed.
    """

    def __init__(
        self,
        link: Link,
        *,
        timing: Timing | None = None,
        echo: Echo = Echo.AUTO,
        retries: int = 2,
        pause: float | None = None,
        raw_checksum: bool = False,
        strict: bool = False,
    ) -> None:
        self.link: Link = link
        self.echo = echo
        self.retries = retries
        self.version_code: int | None = None
        self._may_ask_for_words = True  # once, of an unknown other end
        self.statistics: Statistics = Statistics()
        self.line: Line = Line(link, timing or Timing(), raw_checksum=raw_checksum, strict=strict)
        self.sync: LineSync = LineSync(self.line)
        self._lock = threading.Lock()
        self._stream: Stream | None = None
        self._stream_thread: int | None = None
        self._ahead = RequestAhead(self.sync, self.statistics)
        self.ends: CallEnds = CallEnds(link)
        self.pauses: Pauses = Pauses(self.line, self.sync, pause, self.ends.check)
        self._known: set[int] = set()  # command codes that this unit has answered

    def connect(self, *, listening_since: float = inf) -> int:
        """Detect the echo and the unit; return its version code.

        `listening_since`: the link's clock when the port was opened, if nothing has been sent on it
        since; the half second of silence (D13) counts from then.

        Raises `NoEcho`, `EchoOnly`, `EchoDiffers`, `NotAKLineAdapter`, `LineNotQuiet`,
        `AnswersLate`, `LinkLost`.
        """
        with self._holding(), self._explaining():
            self._ahead.forget()
            shaking = Handshake(
                self.line, self.sync, self.pauses, self.ends.check, self.statistics.fail
            )
            self.version_code = shaking.repeated(
                self.echo, self.retries, listening_since=listening_since
            )
            self._may_ask_for_words = False
            self._known.update(c.Availability.CODES)
            return self.version_code

    @contextmanager
    def _explaining(self) -> Iterator[None]:
        """Raise the error of the link's other end, where that explains the one raised inside."""
        try:
            yield
        except (LineError, NoConnection) as error:
            if isinstance(error, NoEcho) and self._may_ask_for_words:
                self._may_ask_for_words = False
                ask_for_words(self.link)
            explained = self.link.explained(error)
            if explained is error:
                raise
            raise explained from error

    def within(self, seconds: float | None) -> AbstractContextManager[None]:
        """Let the exchanges that this thread makes inside end once `seconds` have passed.

        An exchange under way is ended first, so the line stays in step; the next one raises
        `DeadlinePassed`. None: without a deadline.
        """
        return self.ends.within(seconds)

    def end_calls(self) -> None:
        """Let the calls of other threads end before their next exchange, with `LinkClosed`.

        Only `close` may follow.
        """
        self.ends.closed = True

    def close(self) -> None:
        """End a running stream and close the link; a second call does nothing.

        What another thread is doing ends at once, or between two exchanges, with `LinkClosed`.
        """
        self.end_calls()
        stream = self._stream
        try:
            if stream:
                with suppress(MikasError):  # the line is no longer used
                    stream.close()
        finally:
            self.link.close()

    def wrap_link(self, wrap: Callable[[Link], Link]) -> None:
        """Pass all bytes from here on through `wrap(link)`; begins between two exchanges.

        Raises `UsageError` if this thread runs a stream.
        """
        with self._holding():
            self._ahead.settle()
            self.link = self.line.link = wrap(self.link)

    def request(self, command: c.Command[T]) -> T:
        """Return the ECU's answer to `command`; repeat a failed exchange if that is safe.

        Raises `EcuRefused`, a `LineError` or a `NoConnection`, with the bytes on the wire.
        """
        return self.exchange(command)[0]

    def has_answered(self, code: int) -> bool:
        """Whether this unit has given a valid answer to this command code."""
        return code in self._known

    def exchange(
        self, command: c.Command[T], *, retries: int | None = None, trial: bool = False
    ) -> tuple[T, Reply]:
        """As `request`, and return the response's bytes and times too.

        `retries`: instead of the tester's; an unsafe command is never repeated. `trial`: a probe:
        silence is expected and is not counted as an error.
        """
        with self._holding():
            retries = self.retries if retries is None else retries
            try:
                return self._exchange(command, retries, trial=trial)
            finally:
                self._ahead.announced = None

    def announce(self, command: c.Command[Any]) -> None:
        """Send `command` as soon as the next exchange has succeeded; both must be repeatable.

        So the wire carries it while the caller interprets that response. The next exchange of an
        equal command finds it sent; before any other one, its response is awaited and dropped.
        Whoever announces calls `settle` at the end. Nothing is sent ahead on a line without an
        echo, where a byte that no request caused could pass for the response (D2).
        """
        self._ahead.announced = command

    def settle(self) -> None:
        """Await and drop the response to a command sent ahead; raises no `MikasError`."""
        self._ahead.announced = None
        if self._ahead.sent is not None:
            with self._holding():
                self._ahead.settle()

    def in_a_row(self, *commands: c.Command[T]) -> list[T]:
        """As `request` for each of `commands`, without another thread's request between them."""
        with self._holding():
            self._ahead.announced = None
            return [self._exchange(command, self.retries)[0] for command in commands]

    def _exchange(
        self, command: c.Command[T], retries: int, *, trial: bool = False
    ) -> tuple[T, Reply]:
        failed: list[LineError] = []
        try:
            return self._attempts(command, retries, failed)
        except (NoResponse, NotSupported) as error:
            if not error.received and (trial or isinstance(error, NotSupported)):
                # Silence was the refusal (D10, D11).
                failed = [each for each in failed if not isinstance(each, NoResponse)]
            raise
        finally:
            for each in failed:
                self.statistics.fail(each)

    def _attempts(
        self, command: c.Command[T], retries: int, failed: list[LineError]
    ) -> tuple[T, Reply]:
        self.ends.check()
        attempts = 1 + (retries if command.repeatable else 0)
        if command.code not in self._known:
            attempts = min(attempts, _ATTEMPTS_AT_UNKNOWN)
        while True:
            wire = self._ahead.claim(command.body())
            if wire is None:
                self._ensure_in_sync()
            attempts -= 1
            try:
                return self._once(command, wire)
            except LineError as error:
                failed.append(error)
                if self._came_too_soon(command, error):
                    if not command.repeatable:
                        raise
                    failed.pop()
                    attempts += 1
                moved = isinstance(error, ReadingSuspended) and not error.is_short
                if not attempts or moved:  # perhaps another unit
                    raise self._verdict(command, error) from error
                self.ends.check()
                self.statistics.repeated += 1

    def _came_too_soon(self, command: c.Command[Any], error: LineError) -> bool:
        """Whether a pause between requests was found that `command` would have needed."""
        suspicious = self.pauses.suspects(error, known=command.code in self._known)
        return suspicious and self.pauses.found_by_trying(self.version_code or 0)

    def _once(self, command: c.Command[T], wire: bytes | None) -> tuple[T, Reply]:
        """Exchange `command` once; `wire`: it was sent ahead."""
        self.statistics.requests += 1
        self.sync.mark_lost()  # until the exchange has succeeded; Ctrl-C may end it
        try:
            shortest = min(command.response_lengths(), default=0)
            if wire is None:
                wire = self.line.send(command.body())
            with self._ahead.by_link(wire, command):
                self.line.await_echo(wire)
                reply = self.line.receive(wire, min_length=shortest)
            try:
                value = command.read(reply.body)
            except MikasError as error:
                error.request, error.received, error.time = wire, reply.wire, reply.ended
                raise
        except LineError as error:
            self.sync.mark_lost(error)
            raise
        except EcuRefused:
            self.sync.keep()
            raise
        self.sync.keep()
        self._ahead.send(after=command)
        self._known.add(command.code)
        return value, reply

    def _verdict(self, command: c.Command[Any], error: LineError) -> MikasError:
        """Return the error after the last attempt: of the line, the command, or the ignition."""
        if isinstance(error, NoResponse):
            self._ensure_in_sync()  # raises NoEcho or EchoOnly if no ECU answers
            if command.code not in self._known:
                return NotSupported(
                    command=command.name, request=error.request, received=b"", time=error.time
                )
        return error

    def time_echo(self, body: bytes) -> float:
        """Return the seconds from the write of a harmless `body` to the end of its echo.

        The answer is ignored. Raises `NoEcho` or `EchoDiffers`.
        """
        with self._holding():
            self.ends.check()
            self._ensure_in_sync()
            self.sync.mark_lost()
            began = self.link.now()
            wire = self.line.send(body)
            self.line.await_echo(wire, hasty=True)
            with suppress(LineError):
                self.line.receive(wire)
                self.sync.keep()
            return self.line.echo_heard - began

    def raw(self, body: bytes) -> bytes | None:
        """Send any body once; return the response's body, None for silence.

        Raises `NoEcho` or a `LineError` for a damaged or doubled response.
        """
        with self._holding():
            self.ends.check()
            self._ensure_in_sync()
            self.statistics.requests += 1
            self.sync.mark_lost()
            self.sync.streaming = not _STREAM_CODES.isdisjoint(body[:1])
            try:
                reply = self.line.exchange(body, of_many=self.sync.streaming)
            except NoResponse:
                return None
            if not self.sync.streaming:
                self.sync.keep()
            return reply.body

    def stream(self, command: c.StreamCyclic | c.StreamAtStroke) -> Stream:
        """Start `command`; return the stream of its responses, which the caller closes (D12).

        The stream holds the tester's lock until then.
        """
        self.check_free()
        self._lock.acquire()
        try:
            with errors_met_on(self.link.kind):
                self.ends.check()
                self._ensure_in_sync()
                self.statistics.requests += 1
                self.sync.mark_lost()
                self.sync.streaming = True
                self.line.await_echo(request := self.line.send(command.body()))
            stream = Stream(
                self.line,
                command,
                request,
                end=self._end_stream,
                check=self.ends.check,
                on_error=self.statistics.fail,
            )
        except BaseException:
            self._lock.release()
            raise
        self._stream, self._stream_thread = stream, threading.get_ident()
        return stream

    def _end_stream(self) -> None:
        assert self._stream is not None
        assert self.version_code is not None
        command = self._stream.command
        try:
            with errors_met_on(self.link.kind):
                self.sync.end_stream(
                    self.version_code,
                    by_strokes=isinstance(command, c.StreamAtStroke),
                    bytes_each=command.response_lengths()[0],
                    leaving=self.ends.closed,
                )
        finally:
            self._stream = self._stream_thread = None
            self._lock.release()

    def wait(self, until: float) -> None:
        """Wait until this time of the link's clock, letting other threads send requests.

        Bytes without a request that arrive meanwhile require a resynchronization.
        """
        while (now := self.link.now()) < until:
            self.ends.check()
            with self._holding():
                self._ahead.settle()
                try:
                    unasked = self.line.read(min(until, now + _TURN)).data
                except ReadingSuspended as error:
                    unasked = error.received or b""
                if unasked:
                    self.sync.mark_lost()

    def _ensure_in_sync(self) -> None:
        if self.version_code is None:
            raise usage_error("connect() comes first", "сначала нужен connect()")
        self._ahead.settle()
        self.sync.resynchronize(self.version_code)

    @contextmanager
    def _holding(self) -> Iterator[None]:
        self.check_free()
        with self._lock, errors_met_on(self.link.kind):
            yield

    def check_free(self) -> None:
        """Raise `UsageError` if this thread runs a stream, which occupies the line."""
        if self._stream_thread == threading.get_ident():
            raise usage_error(
                "a stream is running in this thread; close it before asking for anything else",
                "в этом потоке выполнения идёт поток данных; сначала закройте его",
            )
