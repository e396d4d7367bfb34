"""When a call is to end before its work is done: a deadline, a cancellation, a closed connection.

All three are looked at between two exchanges only. An exchange under way is ended first: the
response that is due would else pass for the next one's (D13).
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from mikas.cancellation import check_cancelled
from mikas.errors import DeadlinePassed, LinkClosed
from mikas.link import Link
from mikas.options import check_number


class _Deadline(NamedTuple):
    """A time of the link's clock, and the seconds that the call was given."""

    time: float
    seconds: float


class CallEnds:
    """The deadlines of one tester's calls, by thread, and whether it is closed."""

    def __init__(self, link: Link) -> None:
        self.closed = False
        self._link = link
        self._deadlines: dict[int, _Deadline] = {}

    @contextmanager
    def within(self, seconds: float | None) -> Iterator[None]:
        """Let what this thread does inside end once `seconds` have passed; None: without one.

        Of two deadlines, one inside the other, the earlier one holds.
        """
        if seconds is None:
            yield
            return
        check_number("timeout", seconds, lowest=0)
        thread, deadline = threading.get_ident(), _Deadline(self._link.now() + seconds, seconds)
        outer = self._deadlines.get(thread)
        self._deadlines[thread] = min(outer, deadline) if outer else deadline
        try:
            yield
        finally:
            if outer:
                self._deadlines[thread] = outer
            else:
                del self._deadlines[thread]

    def check(self) -> None:
        """Raise `Cancelled`, `LinkClosed`, or `DeadlinePassed`."""
        check_cancelled()
        if self.closed:
            raise LinkClosed(url=self._link.url, time=self._link.now())
        deadline = self._deadlines.get(threading.get_ident())
        if deadline and self._link.now() >= deadline.time:
            raise DeadlinePassed(seconds=deadline.seconds, time=self._link.now())
