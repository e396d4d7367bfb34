"""Frames out of chunks, and when each of them began on the wire.

A chunk's time is when its last byte was there, or later: adapters hand bytes over in lumps. So a
frame that began `n` bytes before a chunk's end can't have begun later than `n` byte times before
that chunk came. Of all the chunks that brought any of it the one that says the earliest is right,
or the least wrong.

Chunks that all come late, and then at once, would still have their last frames begin before the
first. Such a frame counts as begun one byte time after the previous one.
"""

from __future__ import annotations

from collections import deque
from math import inf

from mikas.framing import Damage, Decoder, Frame
from mikas.link import Chunk


class TimedDecoder:
    """A `Decoder` that knows when its bytes came."""

    def __init__(self, decoder: Decoder, byte_time: float) -> None:
        self._decoder = decoder
        self._byte_time = byte_time
        # Of unfinished bytes: where a chunk ends, and when byte 0 began according to it.
        self._chunks: deque[tuple[int, float]] = deque()
        self._latest = -inf  # when the frame before began

    @property
    def pending(self) -> bytes:
        """The bytes of an unfinished frame."""
        return self._decoder.pending

    def feed(self, chunk: Chunk) -> list[tuple[Frame | Damage, float]]:
        """Decode `chunk`; return what it completes, each with the time of its first byte."""
        end = self._decoder.offset + len(chunk.data)
        self._chunks.append((end, chunk.time - end * self._byte_time))
        events = [(event, self._began(event.offset)) for event in self._decoder.feed(chunk.data)]
        begun = end - len(self._decoder.pending)
        while self._chunks and self._chunks[0][0] <= begun:
            self._chunks.popleft()
        return events

    def _began(self, offset: int) -> float:
        zero = min(zero for end, zero in self._chunks if end > offset)
        began = zero + offset * self._byte_time
        if began <= self._latest:
            began = self._latest + self._byte_time
        self._latest = began
        return began
