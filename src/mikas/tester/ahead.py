"""A request that is sent before its exchange begins, while the last response is interpreted.

At most one is under way. Its response is taken by an exchange of the same body, or awaited and
dropped before anything else is sent. From its first byte until either has happened, an interrupt
(Ctrl-C) leaves the synchronization lost (D13): its response never passes for another one's.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from mikas import commands as c
from mikas.errors import MikasError
from mikas.tester.exchange import Statistics
from mikas.tester.line import Line
from mikas.tester.line_sync import LineSync

_FORGOTTEN = 0.1  # s after which a request is sent anew: its response's time is unknown


class _Sent(NamedTuple):
    """A request's body, and as it is on the wire."""

    body: bytes
    wire: bytes


class RequestAhead:
    """The request under way on `line`; the caller holds the tester's lock.

    `announced`: the request that `send` sends next; any thread may set it. `sent`: the one whose
    response no exchange has asked for yet.
    """

    def __init__(self, line: Line, sync: LineSync, statistics: Statistics) -> None:
        self.announced: c.Command[Any] | None = None
        self._line = line
        self._sync = sync
        self._statistics = statistics
        self.sent: _Sent | None = None

    def forget(self) -> None:
        """Forget all, before the line is synchronized by a handshake."""
        self.announced = self.sent = None

    def send(self) -> None:
        """Send the announced request. On a line without an echo nothing is sent (D2)."""
        command, self.announced = self.announced, None
        if command is None or not self._line.echo:
            return
        body = command.body()
        self._sync.mark_lost()
        self.sent = _Sent(body, self._line.send(body))
        self._sync.keep()

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
