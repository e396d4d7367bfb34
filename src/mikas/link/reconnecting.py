"""A port that is opened again after its adapter was unplugged, perhaps under another name.

A lost `Link` stays lost; this port opens a new one. A USB adapter is identified by vendor, product
and serial number: `/dev/ttyUSB0` may return as `/dev/ttyUSB1`. The port has a clock of its own for
the time without a link. A new link whose clock would run back (the computer's date was set back)
continues the port's clock.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from mikas.link.base import CaptureTee, Chunk, Link, LinkWrapper, Sink, WallClock
from mikas.link.ports import Port, find_ports
from mikas.link.urls import open_link, parse


class ReconnectingPort:
    """Opens the same port repeatedly. `sink` records every link; `clock`, `nap` are for tests."""

    def __init__(
        self,
        url: str,
        *,
        find: Callable[[], list[Port]] = find_ports,
        open_port: Callable[[str], Link] = open_link,
        clock: Callable[[], float] | None = None,
        nap: Callable[[float], object] = time.sleep,
        sink: Sink | None = None,
    ) -> None:
        self.url = url
        self._find = find
        self._open_port = open_port
        self._clock = clock or WallClock().now
        self._nap = nap
        self._sink = sink
        self._link: Link | None = None
        self._ahead = 0.0  # the latest link's clock minus `_clock`
        self._identity: tuple[int, int, str | None] | None = None

    def open(self) -> Link:
        """Open the link under the adapter's present name. Raises `NoConnection`."""
        self.url = self._where()
        link = self._open_port(self.url)
        self._identity = self._identity or self._identify()
        if self._link is not None and (lag := self.now() - link.now()) > 0:
            link = _AheadLink(link, lag)
        self._link = link
        self._ahead = link.now() - self._clock()
        return link if self._sink is None else CaptureTee(link, self._sink)

    def now(self) -> float:
        """Return the seconds of a clock that runs without a link and never runs back."""
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


class _AheadLink(LinkWrapper):
    """`link`, with a clock that is `ahead` of its own."""

    def __init__(self, link: Link, ahead: float) -> None:
        super().__init__(link)
        self._ahead = ahead

    def read(self, deadline: float) -> Chunk:
        chunk = self.link.read(deadline - self._ahead)
        return Chunk(chunk.data, chunk.time + self._ahead)

    def gather(self, until: float) -> None:
        self.link.gather(until - self._ahead)

    def now(self) -> float:
        return self.link.now() + self._ahead


def _identity(port: Port) -> tuple[int, int, str | None] | None:
    if port.vid is None or port.pid is None:
        return None
    return port.vid, port.pid, port.serial_number
