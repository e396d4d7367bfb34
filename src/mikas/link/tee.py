"""A link that also passes every byte to a sink: the capture's tap on the wire.

The tee knows a sink only as an object with `record`; recording implements it. It sits between the
tester and any link, changes nothing, and is itself a link.
"""

from __future__ import annotations

from enum import Enum
from typing import Protocol

from mikas.link.base import Chunk, Link


class Direction(Enum):
    """Which way the bytes went, seen from the tester."""

    SENT = "sent"
    RECEIVED = "received"


class Sink(Protocol):
    """The receiver of the bytes."""

    def record(self, direction: Direction, data: bytes, time: float) -> None:
        """Record `data`; `time` is the link's clock and never runs back."""


class CaptureTee(Link):
    """`link`, with every byte also recorded by `sink`, in the order in which the tester met them.

    - What was received is recorded with its chunk's time; empty chunks are not.
    - What was sent is recorded once the system has taken it, with the time of that: about when its
      first bit goes out, and never later than its echo. What the link refused is not recorded.
    - A sink that fails must not cost the session: `failure` keeps the exception, nothing is
      recorded after that, and the link goes on. The owner of the sink looks at `failure` and
      reports it.
    - Closing the tee closes the link. The owner of the sink closes it after the tee.
    """

    def __init__(self, link: Link, sink: Sink) -> None:
        self.link = link
        self.url = link.url
        self.baud = link.baud
        self.failure: Exception | None = None
        self._sink = sink

    @property
    def description(self) -> str:
        """That of the link."""
        return self.link.description

    @property
    def can_break(self) -> bool:
        """That of the link."""
        return self.link.can_break

    def write(self, data: bytes) -> None:
        """Write, then record."""
        self.link.write(data)
        if data:
            self._record(Direction.SENT, data, self.link.now())

    def read(self, deadline: float) -> Chunk:
        """Read, then record."""
        chunk = self.link.read(deadline)
        if chunk.data:
            self._record(Direction.RECEIVED, chunk.data, chunk.time)
        return chunk

    def gather(self, until: float) -> None:
        """Gather on the link."""
        self.link.gather(until)

    def now(self) -> float:
        """The link's clock."""
        return self.link.now()

    def send_break(self, seconds: float) -> None:
        """Send the break on the link; it is no byte, so nothing is recorded."""
        self.link.send_break(seconds)

    def close(self) -> None:
        """Close the link, not the sink."""
        self.link.close()

    def _record(self, direction: Direction, data: bytes, time: float) -> None:
        if self.failure is not None:
            return
        try:
            self._sink.record(direction, data, time)
        except Exception as error:
            self.failure = error  # foreign code: whatever happened in it, the session goes on
