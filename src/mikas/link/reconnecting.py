"""A port that comes and goes: an adapter pulled out in a pothole, and put back in another socket.

A `Link` that is lost stays lost; to go on, open a new one here. A USB adapter is
known by vendor, product and serial number, not by its name: `/dev/ttyUSB0` may come back as
`/dev/ttyUSB1`. While there is no link there is no link's clock either, so a plug has one, and is
the only way to wait for the adapter.

Each link begins with the computer's date of that moment. If that was set back meanwhile, the new
link's clock would run through times that have been: it goes on from the plug's instead.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from mikas.link.base import Chunk, Link, WallClock
from mikas.link.ports import Port, find_ports
from mikas.link.tee import CaptureTee, Sink
from mikas.link.urls import open_link, parse


class ReconnectingPort:
    """Opens the same port again and again. `sink` gets the bytes of every link (a `CaptureTee`).

    `clock` and `nap` are for tests.
    """

    def __init__(
        self,
        url: str,
        *,
        find: Callable[[], list[Port]] = find_ports,
        open_port: Callable[[str], Link] = open_link,
        clock: Callable[[], float] | None = None,
        nap: Callable[[float], None] = time.sleep,
        sink: Sink | None = None,
    ) -> None:
        self.url = url
        self._find = find
        self._open_port = open_port
        self._clock = clock or WallClock().now
        self._nap = nap
        self._sink = sink
        self._link: Link | None = None
        self._ahead = 0.0  # of the latest link's clock, before this one's
        self._identity: tuple[int, int, str | None] | None = None

    def open(self) -> Link:
        """Open the link under the adapter's present name. Raises a `NoConnection` without one."""
        self.url = self._where()
        link = self._open_port(self.url)
        self._identity = self._identity or self._identify()
        if self._link is not None and (behind := self.now() - link.now()) > 0:
            link = _AheadLink(link, behind)
        self._link = link
        self._ahead = link.now() - self._clock()
        return link if self._sink is None else CaptureTee(link, self._sink)

    def now(self) -> float:
        """Return the seconds of a clock that goes on without a link, and never runs back."""
        now = self._clock() + self._ahead
        return now if self._link is None else max(now, self._link.now())

    def wait(self, seconds: float) -> None:
        """Sleep. Ctrl-C interrupts it."""
        self._nap(seconds)

    def _where(self) -> str:
        """Return the port with the adapter's identity; its old name if there is none."""
        if self._identity is None:
            return self.url
        same = [port.url for port in self._find() if _identity(port) == self._identity]
        if not same or parse(self.url).address in same:
            return self.url
        _, question, options = self.url.partition("?")
        return f"{same[0]}{question}{options}"

    def _identify(self) -> tuple[int, int, str | None] | None:
        address = parse(self.url)
        if address.scheme != "serial":
            return None
        return next((_identity(p) for p in self._find() if p.url == address.address), None)


class _AheadLink(Link):
    """`link`, with a clock that is `ahead` of its own."""

    def __init__(self, link: Link, ahead: float) -> None:
        self.link = link
        self.url = link.url
        self.baud = link.baud
        self._ahead = ahead

    @property
    def can_break(self) -> bool:
        return self.link.can_break

    @property
    def description(self) -> str:
        return self.link.description

    def write(self, data: bytes) -> None:
        self.link.write(data)

    def read(self, deadline: float) -> Chunk:
        chunk = self.link.read(deadline - self._ahead)
        return Chunk(chunk.data, chunk.time + self._ahead)

    def gather(self, until: float) -> None:
        self.link.gather(until - self._ahead)

    def now(self) -> float:
        return self.link.now() + self._ahead

    def send_break(self, seconds: float) -> None:
        self.link.send_break(seconds)

    def close(self) -> None:
        self.link.close()


def _identity(port: Port) -> tuple[int, int, str | None] | None:
    if port.vid is None or port.pid is None:
        return None
    return port.vid, port.pid, port.serial_number
