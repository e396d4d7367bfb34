"""A port that comes and goes: an adapter pulled out in a pothole, and put back in another socket.

A `Link` that is lost stays lost; whoever wants to go on opens a new one here. A USB adapter is
known by vendor, product and serial number, not by its name: `/dev/ttyUSB0` may come back as
`/dev/ttyUSB1`. While there is no link there is no link's clock either, so a plug has one, and is
the only way to wait for the adapter.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from mikas.link.base import Link, WallClock
from mikas.link.ports import Port, find_ports
from mikas.link.urls import open_link, parse


class Plug:
    """Opens the same port again and again.

    `clock` and `nap` are for tests; the links' own clocks go on from this one's time, being UNIX
    time both.
    """

    def __init__(
        self,
        url: str,
        *,
        find: Callable[[], list[Port]] = find_ports,
        open_port: Callable[[str], Link] = open_link,
        clock: Callable[[], float] | None = None,
        nap: Callable[[float], None] = time.sleep,
    ) -> None:
        self.url = url
        self._find = find
        self._open_port = open_port
        self._clock = clock or WallClock().now
        self._nap = nap
        self._identity: tuple[int, int, str | None] | None = None

    def open(self) -> Link:
        """The link, wherever the adapter is now. Raises a `NoConnection` if it is nowhere."""
        self.url = self._where()
        link = self._open_port(self.url)
        self._identity = self._identity or self._identify()
        return link

    def now(self) -> float:
        """Seconds on a clock that goes on while there is no link."""
        return self._clock()

    def wait(self, seconds: float) -> None:
        """Lets time pass. Ctrl-C interrupts it."""
        self._nap(seconds)

    def _where(self) -> str:
        """The port that has the adapter's identity; its old name as long as none has."""
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


def _identity(port: Port) -> tuple[int, int, str | None] | None:
    if port.vid is None or port.pid is None:
        return None
    return port.vid, port.pid, port.serial_number
