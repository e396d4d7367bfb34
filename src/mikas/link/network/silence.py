"""A connection over a network that looks alive and carries nothing.

A bridge that loses its Wi-Fi or its supply sends no end, and one that hangs keeps its connection
open. The system gives such a connection up after a quarter of an hour, and a bridge that is back
does not know it. So a connection that brings not one byte for `SILENT` seconds, although something
was written, is dead. An adapter returns each byte at once, so one without an echo, whose unit is
off, is taken for dead too: it is opened again, which does no harm. Over a slow network the user
allows a request more time (D14), and so does this module.

Time counts while a read waits, so a stopped or busy program does not make a connection dead.
"""

from __future__ import annotations

from math import inf
from typing import Final

from mikas.errors import ConnectionSilent, ReadingSuspended, met_on
from mikas.link.base import Chunk, Link, LinkWrapper

SILENT: Final = 2.0  # s without a byte
_MORE: Final = 0.3  # s after a write, beyond the time in which the answer has to begin
_NEAR: Final = 0.001  # s; a clock of 1970 does not resolve much less


class SilenceGuard(LinkWrapper):
    """`link`, until it is silent for `SILENT` seconds; then all calls raise `ConnectionSilent`.

    `link` is given up then. `timeout`: the time-out of a request, after which no answer is awaited.
    """

    def __init__(self, link: Link, *, timeout: float) -> None:
        super().__init__(link)
        self._after_write = timeout + _MORE
        self._silent = 0.0  # s of waiting since the latest byte
        self._unanswered = inf  # s of waiting since the first write after it; inf: none
        self._dead = False

    def write(self, data: bytes) -> None:
        self._check(data)
        try:
            self.link.write(data)
        except ReadingSuspended:
            self._begin_again()
            raise
        if data and self._unanswered == inf:
            self._unanswered = 0.0

    def read(self, deadline: float) -> Chunk:
        self._check()
        while True:
            began = self.link.now()
            until = min(deadline, began + self._left())
            try:
                chunk = self.link.read(until)
            except ReadingSuspended:
                self._begin_again()
                raise
            if chunk.data:
                self._begin_again()
                return chunk
            self._count(max(0.0, min(chunk.time, until) - began))
            if self._left() == 0:
                self._dead = True
                self.link.give_up()
                self._check()
            if chunk.time >= deadline:
                return chunk

    def send_break(self, seconds: float) -> None:
        self._check()
        self.link.send_break(seconds)

    def _left(self) -> float:
        """Return the seconds of waiting until the connection is dead; inf: nothing is awaited."""
        if self._unanswered == inf:
            return inf
        left = max(SILENT - self._silent, self._after_write - self._unanswered)
        return left if left > _NEAR else 0.0

    def _count(self, waited: float) -> None:
        self._silent += waited
        self._unanswered += waited

    def _begin_again(self) -> None:
        self._silent, self._unanswered = 0.0, inf

    def _check(self, request: bytes | None = None) -> None:
        if self._dead:
            silent = ConnectionSilent(
                url=self.url, seconds=round(self._silent), request=request, time=self.now()
            )
            raise met_on(self.kind, silent)
