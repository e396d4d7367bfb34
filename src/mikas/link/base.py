"""What a link is: bytes out, bytes in with their arrival times, and the clock (§1).

Everything above talks to the wire through this one interface, in plain blocking code, and takes the
time from it too: `Link.read` is the only way to wait and `Link.now` the only clock. So the same
tester runs against an adapter in real time and against a simulated bus as fast as it can.

A link refuses to know about frames, echo, requests or retries. It belongs to one thread at a time;
only `close` may come from another.

A back end passes the contract suite in `tests/link/contract.py`; the sentences below are what that
suite checks. Whatever else a method raises is a bug.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, NamedTuple, Self

if TYPE_CHECKING:
    from types import TracebackType

BITS_PER_BYTE = 10  # §1: start bit, eight data bits, stop bit


class Chunk(NamedTuple):
    """The result of one read. `data` is empty if the deadline came first."""

    data: bytes
    """The bytes in the order of their arrival."""

    time: float
    """When the last of them was seen here, or when the wait ended; in the link's clock."""


class Link(ABC):
    """A wire with a clock. Opened by `mikas.link.open_link`; usable as a context manager."""

    url: str
    """The port, as the user wrote it."""

    baud: int = 9600
    """Bits a second on the wire (§1)."""

    @property
    def can_break(self) -> bool:
        """Whether `send_break` pulls the wire low. May turn false at the first attempt."""
        return True

    @property
    def description(self) -> str:
        """The adapter behind the URL, for a person; never empty."""
        return self.url

    @property
    def byte_time(self) -> float:
        """Seconds that one byte takes on the wire: 1.0417 ms at 9600 baud."""
        return BITS_PER_BYTE / self.baud

    @abstractmethod
    def write(self, data: bytes) -> None:
        """Hand `data` to the adapter; return once the system has taken all of it.

        The bytes are not yet on the wire then: n of them take n times `byte_time`. Empty
        data are allowed and do nothing.

        Raises `LinkLost` if the adapter is gone, takes nothing for seconds, or the link is closed;
        how much of `data` got out is then unknown.
        """

    @abstractmethod
    def read(self, deadline: float) -> Chunk:
        """Wait for bytes, until `deadline` of this link's clock at the latest.

        Returns as soon as anything has arrived, with all that has. At the deadline it returns an
        empty chunk, never earlier. A deadline in the past looks once and does not wait. Ctrl-C
        interrupts the wait.

        Raises `LinkLost`, without waiting for the deadline, if the adapter is gone or the link is
        closed. What arrived before the loss may come first, or be lost with it.
        """

    @abstractmethod
    def now(self) -> float:
        """Seconds on this link's clock, which never runs back.

        UNIX time on a link in real time (see `WallClock`); the simulated time on a simulated one.
        Works on a closed or lost link too.
        """

    def gather(self, until: float) -> None:  # noqa: B027  (a back end may leave it at that)
        """Sleep until this time of the link's clock, so that bytes accumulate.

        For a caller that has no use for earlier bytes: the next `read` returns them all at once,
        and the computer wakes up once and not for every byte. A link whose bytes should be read as
        they come does not sleep at all, which is the default. Never raises
        `LinkLost`; the next `read` does.
        """

    @abstractmethod
    def send_break(self, seconds: float) -> None:
        """Hold the wire low for `seconds`, the way to silence a talker (D12); return after that.

        Where the port has no means for it, `can_break` is then false, and the time just passes.
        Raises `LinkLost` as `write` does.
        """

    @abstractmethod
    def close(self) -> None:
        """Close the port. A second call does nothing.

        From then on `read`, `write` and `send_break` raise `LinkLost`; a `read` that another thread
        waits in does so within a second.
        """

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()


class WallClock:
    """The clock of every link in real time: UNIX time when made, and steady from there.

    A change of the system's date, or its slow correction, does not touch it: intervals are exact
    and it never runs back. The price is that it may drift from UNIX time over hours, and that it
    may stand still while the computer sleeps. `perf_counter` and not `monotonic`, which on Windows
    moves in steps of 15.6 ms up to Python 3.12.
    """

    __slots__ = ("_offset",)

    def __init__(self) -> None:
        self._offset = time.time() - time.perf_counter()

    def now(self) -> float:
        """Seconds since 1970; to about a quarter of a microsecond, which is what a float leaves."""
        return self._offset + time.perf_counter()
