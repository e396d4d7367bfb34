"""A bound on what arrives: a line carries no more than its baud rate (§1), whoever is behind it.

A network port, a broken adapter or a program that shares one may send at any speed, for ever. The
bytes are not kept in memory and not recorded: the link is given up with `LineFlooded`, once more
has arrived than a line can have carried.

Bytes may come late and together, so `BURST` of the line may come at once, and after a pause of the
reader as much as the line can have carried meanwhile. A request is an allowance for its answer, as
an emulator without a wire answers at once.
"""

from __future__ import annotations

from typing import Final

from mikas.errors import LineFlooded, met_on
from mikas.link.base import BITS_PER_BYTE, Chunk, Link, LinkWrapper

BURST: Final = 16.0  # s of the line's bytes that may come at once
FASTER: Final = 2.0  # times the line's rate that may come for ever: a unit's clock is not exact
ANSWER: Final = 1100  # bytes that may follow each request: the longest echo and response
BACKLOG: Final = 4096  # bytes; a shorter read has emptied the system's buffers


class FloodGuard(LinkWrapper):
    """`link`, until it has brought more than a line can carry; then all calls raise `LineFlooded`.

    `link` is closed then. No byte that arrived before is withheld.
    """

    def __init__(self, link: Link) -> None:
        super().__init__(link)
        rate = link.baud / BITS_PER_BYTE
        self._rate = FASTER * rate
        self._burst = BURST * rate
        self._allowed = self._burst  # bytes that may still come
        self._time = self._began = link.now()
        self._count = 0  # bytes since `_began`, when all of the burst was allowed
        self._flooded: LineFlooded | None = None

    def write(self, data: bytes) -> None:
        self._check(data)
        self._allowed += ANSWER
        self.link.write(data)

    def read(self, deadline: float) -> Chunk:
        self._check()
        chunk = self.link.read(deadline)
        size, time = len(chunk.data), chunk.time
        self._allowed += (time - self._time) * self._rate - size
        self._time = time
        self._count += size
        if self._allowed < 0:
            self._give_up()
        elif size < BACKLOG and self._allowed >= self._burst:
            self._allowed, self._began, self._count = self._burst, time, 0
        return chunk

    def send_break(self, seconds: float) -> None:
        self._check()
        self.link.send_break(seconds)

    def _check(self, request: bytes | None = None) -> None:
        if self._flooded is not None:
            self._flooded.request = request
            raise self._flooded

    def _give_up(self) -> None:
        seconds = max(self._time - self._began, 0.001)
        flooded = LineFlooded(
            url=self.url,
            rate=round(self._count / seconds),
            baud=self.baud,
            most=round(self.baud / BITS_PER_BYTE),
            time=self._time,
        )
        self._flooded = met_on(self.kind, flooded)
        self.link.close()
