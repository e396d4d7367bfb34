"""Streams: responses that the unit sends on its own, 71 and 7F … 83 (§3, D12, D15)."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Self

from mikas import commands as c
from mikas.commands.base import lengths_in_words
from mikas.errors import (
    LineError,
    MikasError,
    NoConnection,
    NoResponse,
    NotSupported,
    ReadingSuspended,
    WrongLength,
    met_on,
)
from mikas.framing import Damage, Frame
from mikas.tester.line import Line, damaged

_STANDING_ENGINE = 2.0  # s without a stroke (D15): an engine below 60 rpm counts as standing
_TURN = 0.2  # s of one wait on the line; whoever closes the stream waits so long for its turn


@dataclass(frozen=True, slots=True)
class StreamItem:
    """One response: a datum a parameter, the body, and the time of its first byte."""

    data: c.Data
    body: bytes
    time: float


class Stream:
    """An iterator over the responses of a stream command; close it, or use it in a `with`.

    Iterating raises `NoResponse` after `silence` seconds without a response (2 s by strokes, else
    `response_timeout`), `LinkLost` if the adapter is gone. A damaged response, or one
    of a wrong length, is passed to `on_error` and left out; so is all that came while the program
    did not run.

    `request`: the wire form of `command`, sent. `running`: not closed.
    """

    def __init__(
        self,
        line: Line,
        command: c.StreamCyclic | c.StreamAtStroke,
        request: bytes,
        *,
        end: Callable[[], None],
        check: Callable[[], None],
        on_error: Callable[[LineError], None],
    ) -> None:
        self.command = command
        self.running: bool = True
        by_strokes = isinstance(command, c.StreamAtStroke)
        self.silence: float = _STANDING_ENGINE if by_strokes else line.timing.response_timeout
        self._line = line
        self._end = end
        self._check = check
        self._turn = threading.RLock()  # of the thread that uses the line
        self._on_error = on_error
        self._decoder = line.decoder()
        self._min_length = min(command.response_lengths())
        self._items: deque[StreamItem | LineError] = deque()
        self._held: StreamItem | None = None
        self._count = 0
        self._cut = False  # what comes next may begin in the middle of a response
        self._request = request
        self._heard = line.sent_until

    def read(self, deadline: float, *, raise_errors: bool = False) -> StreamItem | None:
        """Return the next response; None at `deadline` of the link's clock.

        Raises `NotSupported` if the unit answers `01`: it does not know the command (D10);
        `ReadingSuspended`, after which the stream goes on.
        `raise_errors`: also raises the `LineError` of each response that is left out.
        """
        self._check()
        while self.running:
            while self._items:
                item = self._items.popleft()
                if isinstance(item, StreamItem):
                    return item
                if raise_errors:
                    raise item
            until = min(deadline, self._line.link.now() + _TURN)
            events = self._events(until)
            self._check()
            if not events and until >= deadline:
                return None
            for event, time in events:
                self._heard = self._line.link.now()
                if isinstance(event, Frame):
                    self._take(event.body, time)
                else:
                    self._leave_out(damaged(self._request, event.data, time, event.reason))
                self._cut = False
        self._check()
        return None

    def _events(self, until: float) -> list[tuple[Frame | Damage, float]]:
        """Return the next events with the times of their first bytes; []: none came, or closed."""
        with self._turn:
            if not self.running:
                return []
            try:
                return self._line.next_frame(
                    self._decoder, until, min_length=self._min_length, heard=self._heard
                )
            except ReadingSuspended as error:
                self._decoder, self._heard = self._line.decoder(), self._line.link.now()
                self._cut = True
                self._on_error(error)
                raise

    def _leave_out(self, error: LineError) -> None:
        if self._cut:
            return
        met_on(self._line.link.kind, error)
        self._on_error(error)
        self._items.append(error)

    def _take(self, body: bytes, time: float) -> None:
        self._count += 1
        if len(body) not in self.command.response_lengths():
            if body == b"\x01" and self._count == 1:
                raise self._unknown(body)
            self._leave_out(
                WrongLength(
                    length=len(body),
                    expected=lengths_in_words(self.command.response_lengths()),
                    request=self._request,
                    received=body,
                    time=time,
                )
            )
            return
        item = StreamItem(self.command.read(body), body, time)
        if body == b"\x01" and self._count == 1:
            # 01 to a request of one byte: a datum, or D10's refusal, which is sent only once.
            self._held = item
            return
        if self._held:
            self._items.append(self._held)
            self._held = None
        self._items.append(item)

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> StreamItem:
        while self.running:
            with suppress(ReadingSuspended):
                item = self.read(max(self._heard, self._line.link.now()) + self.silence)
                if item is not None:
                    return item
                if self.running:
                    raise self.fallen_silent()
        self._check()
        raise StopIteration

    def fallen_silent(self) -> NoResponse | NotSupported:
        """Return the error for `silence` seconds without a response."""
        if self._held:
            return self._unknown(self._held.body)
        link = self._line.link
        silent = NoResponse(
            seconds=self.silence, request=self._request, received=b"", time=link.now()
        )
        return met_on(link.kind, silent)

    def _unknown(self, body: bytes) -> NotSupported:
        return NotSupported(command=self.command.name, request=self._request, received=body)

    def close(self) -> None:
        """End the stream (D12) and release the tester; a second call does nothing.

        Raises `LineNotQuiet` if the unit does not stop.
        """
        with self._turn:
            if self.running:
                self.running = False
                self._end()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: BaseException | None, traceback: object) -> None:
        try:
            self.close()
        except NoConnection:
            # No ECU, so no stream; the first error matters more.
            if error is None:
                raise
        except MikasError:
            if not isinstance(error, MikasError):
                raise
