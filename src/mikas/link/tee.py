"""A link that also passes every byte to a sink, which a recording implements."""

from __future__ import annotations

from enum import Enum
from typing import Protocol

from mikas.link.base import Chunk, Link, LinkWrapper


class Direction(Enum):
    """The direction of bytes, seen from the tester."""

    SENT = "sent"
    RECEIVED = "received"


class Sink(Protocol):
    """The receiver of the bytes."""

    def record(self, direction: Direction, data: bytes, time: float) -> None:
        """Record `data`; `time` is the link's clock and never runs back."""


class CaptureTee(LinkWrapper):
    """`link`, with every byte also recorded by `sink`, in the order of the tester's calls.

    - Received bytes have their chunk's time.
    - Sent bytes have the time when the system had accepted them: about when the first bit goes out,
      and never later than the echo. Bytes that the link refused are not recorded.
    - A failing sink does not end the session: `failure` keeps the exception for the sink's owner,
      and recording stops.
    - Closing the tee closes the link, not the sink.
    """

    def __init__(self, link: Link, sink: Sink) -> None:
        super().__init__(link)
        self.failure: Exception | None = None
        self._sink = sink

    def write(self, data: bytes) -> None:
        self.link.write(data)
        if data:
            self._record(Direction.SENT, data, self.link.now())

    def read(self, deadline: float) -> Chunk:
        chunk = self.link.read(deadline)
        if chunk.data:
            self._record(Direction.RECEIVED, chunk.data, chunk.time)
        return chunk

    def _record(self, direction: Direction, data: bytes, time: float) -> None:
        if self.failure is not None:
            return
        try:
            self._sink.record(direction, data, time)
        except Exception as error:
            self.failure = error  # the sink's code must not end the session
