"""Bytes whose time is unknown, because the program did not run when they came.

Ctrl-Z, a debugger, a laptop's lid, a browser's frozen tab or a busy computer stop the thread that
reads. What comes meanwhile waits in the adapter, the system or the network, and would be taken for
what comes afterwards: a value half a minute old, with the present time. The order of these bytes
says little of their times, and some may be missing. So they are dropped, and `ReadingSuspended`
says for how long nothing was read.

Only this module judges it, for every link and by the link's own clock: a call that comes, or
returns, much later than it had to. A network that delivers late is another thing; what would show
it (more bytes at once than the line carries meanwhile) passes through `SuspensionGuard.read` too.
"""

from __future__ import annotations

from math import inf
from typing import Final

from mikas.errors import ReadingSuspended
from mikas.link.base import Chunk, Link, LinkWrapper

# D14: a response takes half a second at most, so older bytes are none of the present request. A
# busy computer stops a thread for 0.2 s. A byte can be as old as a wait and the lateness together.
LATE: Final = 0.4  # s
LATE_IN_PROGRAM: Final = 2.0  # s, of a unit in this program: its bytes keep their own times
WAIT: Final = 0.1  # s of one wait; else a stop during a long wait would pass for silence

_ROUND: Final = 0.05  # s in which more of what waited may follow (threads, USB)
_LONGER: Final = 1.2  # times the link's granularity
_FASTER: Final = 2.0  # times the line's rate: what waited still flows
_LONGEST: Final = 2.0  # s of dropping; what goes on flowing so fast is no backlog
_KEPT: Final = 16  # bytes of the dropped ones that the error shows


class SuspensionGuard(LinkWrapper):
    """`link`, without the bytes of the time in which the program did not run.

    `read` and `write` then raise `ReadingSuspended`, once: `read` after it has dropped what
    waited, `write` before it sends. The time before the first use is none of it: a port may be
    opened ahead. A wait without end is one wait. `late`: seconds of lateness that are none of it.
    """

    def __init__(self, link: Link, late: float = LATE) -> None:
        super().__init__(link)
        self._late = late
        self._due = inf  # until when the program has run, or need not
        self._paused = 0.0  # seconds of the latest suspension; 0: none to report

    def read(self, deadline: float) -> Chunk:
        now = self._look()
        polls = deadline <= now
        while not self._paused:
            until = deadline if deadline == inf else max(now, min(deadline, now + WAIT))
            self._due = until
            chunk = self.link.read(until)
            now = self._look()
            if self._paused:
                raise self._suspended(chunk.data, polls=polls)
            if chunk.data or now >= deadline:
                return chunk
        raise self._suspended(b"", polls=polls)

    def write(self, data: bytes) -> None:
        now = self._look()
        if self._paused:
            raise self._error(b"")
        self._due = now + len(data) * self.byte_time
        self.link.write(data)
        self._look()

    def gather(self, until: float) -> None:
        self._due = max(self._look(), until)
        self.link.gather(until)
        self._look()

    def send_break(self, seconds: float) -> None:
        self._due = self._look() + seconds
        self.link.send_break(seconds)
        self._look()

    def _look(self) -> float:
        """Return the time, after a comparison with the one that was due."""
        now = self.link.now()
        if now - self._due > self._late:
            self._paused += now - self._due
        self._due = now
        return now

    def _suspended(self, dropped: bytes, *, polls: bool) -> ReadingSuspended:
        """Drop what waited; return the error. `polls`: nothing was due, so one look is enough."""
        link = self.link
        dropped += link.read(link.now()).data
        span = max(_ROUND, _LONGER * self.granularity)
        most = _FASTER * span / self.byte_time
        until = link.now() + _LONGEST
        flowing = bool(dropped) or not polls
        while flowing and link.now() < until:
            arrived, end = 0, link.now() + span
            while (chunk := link.read(end)).data:
                arrived += len(chunk.data)
                dropped = (dropped + chunk.data)[-_KEPT:]
                if chunk.time >= end:
                    break
            flowing = arrived > most
        return self._error(dropped[-_KEPT:])

    def _error(self, dropped: bytes) -> ReadingSuspended:
        seconds, self._paused = self._paused, 0.0
        self._due = now = self.link.now()
        return ReadingSuspended(seconds=seconds, received=dropped, time=now)
