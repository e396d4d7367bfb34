"""Streams: responses that the unit sends on its own, 71 and 7F … 83 (§3, D12, D15)."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from mikas import commands as c
from mikas.commands.base import lengths_in_words
from mikas.errors import (
    LineError,
    MikasError,
    NoConnection,
    NoResponse,
    NotSupported,
    WrongLength,
)
from mikas.framing import Frame
from mikas.tester.line import Line

_STANDING_ENGINE = 2.0  # s without a stroke (D15): what turns slower than 60 rpm stands


@dataclass(frozen=True, slots=True)
class StreamItem:
    """One response: a datum a parameter, the body they came in, and when its first byte began."""

    data: c.Data
    body: bytes
    time: float


class Stream:
    """An iterator over the responses of one stream command; close it, or use it with `with`.

    Iterating raises `NoResponse` when nothing has come for `silence` seconds, `LinkLost` when the
    adapter is gone. A damaged response, or one whose length does not fit, is counted, passed
    to `on_error` and left out.
    """

    def __init__(
        self,
        line: Line,
        command: c.StreamCyclic | c.StreamAtStroke,
        *,
        end: Callable[[], None],
        on_error: Callable[[LineError], None],
        silence: float | None = None,
    ) -> None:
        self.command = command
        self.damaged = 0
        self.foreign = 0
        by_strokes = isinstance(command, c.StreamAtStroke)
        self.silence = silence or (_STANDING_ENGINE if by_strokes else line.timing.response_timeout)
        self._line = line
        self._end = end
        self._on_error = on_error
        self._decoder = line.decoder()
        self._min_length = min(command.response_lengths())
        self._items: deque[StreamItem | LineError] = deque()
        self._held: StreamItem | None = None
        self._count = 0
        self._open = True
        self._request = b""

    @property
    def running(self) -> bool:
        """Whether it has not been ended."""
        return self._open

    def start(self) -> None:
        """Send the request and check its echo; the tester calls it."""
        self._request, self._heard = self._line.send(self.command.body())

    def read(self, deadline: float, *, raise_errors: bool = False) -> StreamItem | None:
        """Return the next response; None if none has come by `deadline` of the link's clock.

        Raises `NotSupported` if the unit answers `01`, its way to say that it does not know (D10).
        `raise_errors`: also raises the `LineError` of each response that is left out.
        """
        while self._open:
            while self._items:
                item = self._items.popleft()
                if isinstance(item, StreamItem):
                    return item
                if raise_errors:
                    raise item
            events = self._line.next_frame(
                self._decoder, deadline, min_length=self._min_length, heard=self._heard
            )
            if not events:
                return None
            for event, time in events:
                self._heard = self._line.link.now()
                if isinstance(event, Frame):
                    self._take(event.body, time)
                else:
                    self.damaged += 1
                    self._leave_out(self._line.damaged(self._request, event, time))
        return None

    def _leave_out(self, error: LineError) -> None:
        self._on_error(error)
        self._items.append(error)

    def _take(self, body: bytes, time: float) -> None:
        self._count += 1
        if len(body) not in self.command.response_lengths():
            if body == b"\x01" and self._count == 1:
                raise self._unknown(body)
            self.foreign += 1
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
            # One byte asked, 01 came: the datum, or D10's refusal? A refusal comes only once.
            self._held = item
            return
        if self._held:
            self._items.append(self._held)
            self._held = None
        self._items.append(item)

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> StreamItem:
        if not self._open:
            raise StopIteration
        item = self.read(max(self._heard, self._line.link.now()) + self.silence)
        if item is not None:
            return item
        if not self._open:
            raise StopIteration
        raise self.fallen_silent()

    def fallen_silent(self) -> NoResponse | NotSupported:
        """Return the error for a stream that has sent nothing for `silence` seconds."""
        if self._held:
            return self._unknown(self._held.body)
        return NoResponse(
            seconds=self.silence, request=self._request, received=b"", time=self._line.link.now()
        )

    def _unknown(self, body: bytes) -> NotSupported:
        return NotSupported(command=self.command.display_name, request=self._request, received=body)

    def close(self) -> None:
        """End the stream (D12) and release the tester. A second call does nothing.

        Raises `LineNotQuiet` if the unit can't be made to stop.
        """
        if self._open:
            self._open = False
            self._end()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        try:
            self.close()
        except NoConnection:
            # No ECU, so nothing streams; the first error is the one to raise.
            if error is None:
                raise
        except MikasError:
            if not isinstance(error, MikasError):
                raise
