"""A program that stops while it uses a link: Ctrl-Z, a debugger, a laptop's lid, a frozen tab."""

from __future__ import annotations

from collections.abc import Iterable

from mikas.link import Chunk
from mikas.link.virtual import VirtualLink
from mikas.virtual.bus import Bus
from virtual_harness import TableCar

PLACES = ("waiting", "between", "gathering", "writing")
"""Where the program is when it stops."""


class ClockCar(TableCar):
    """A car whose data of two bytes are the time, in tenths of a second."""

    def raw(self, code: int, now: float) -> bytes:
        known = super().raw(code, now)
        return known if len(known) == 1 else (round(10 * now) & 0xFFFF).to_bytes(2, "little")


def age(raw: bytes, time: float) -> float:
    """Return how much older than `time` a datum of `ClockCar` is, in seconds."""
    return time - int.from_bytes(raw, "little") / 10


class StoppingLink(VirtualLink):
    """A virtual unit, as a port of the system shows it to a program that stops.

    `stops`: when, and for how many seconds. The bytes that come meanwhile wait, and have the time
    at which they are read.
    """

    def __init__(
        self, bus: Bus, stops: Iterable[tuple[float, float]], where: str = "waiting"
    ) -> None:
        super().__init__(bus)
        self.stops = list(stops)
        self._where = where

    def pass_time(self, seconds: float) -> None:
        """Let time pass outside."""
        self._now += seconds

    def _stop(self, where: str) -> None:
        while where == self._where and self.stops and self._now >= self.stops[0][0]:
            self._now += self.stops.pop(0)[1]

    def now(self) -> float:
        self._stop("between")
        return super().now()

    def read(self, deadline: float) -> Chunk:
        self._stop("waiting")
        chunk = super().read(deadline)
        return Chunk(chunk.data, max(chunk.time, self._now))

    def gather(self, until: float) -> None:
        super().gather(until)
        self._stop("gathering")

    def write(self, data: bytes) -> None:
        super().write(data)
        self._stop("writing")
