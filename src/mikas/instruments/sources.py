"""Where an instrument's bytes come from: a port of its own, gpsd, or the virtual car
(`virtual_source`).

A source is opened, read, and opened again after a loss. What it raises is a `MikasError`; the
session's own line never sees it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, Protocol
from urllib.parse import urlencode

from mikas.instruments.choosing import ChosenInstrument, line_baud, network_url
from mikas.instruments.decoders.gpsd import WATCH
from mikas.instruments.places import GPSD
from mikas.link import Link, open_link
from mikas.link.base import Chunk
from mikas.link.ports import Port, find_ports
from mikas.link.reconnecting import ReconnectingPort
from mikas.link.urls import parse

_WITH_BAUD: Final = ("serial", "socket", "rfc2217", "webserial", "webusb")
_WAIT: Final = 0.5  # s of one wait for bytes
_GATHER: Final = 0.02  # s in which the bytes of a message come together


class InstrumentSource(Protocol):
    """Bytes of one instrument, with times of the session's clock."""

    def open(self) -> None:
        """Open it. Raises a `MikasError`."""

    def read(self) -> list[Chunk]:
        """Return the bytes that have come. Raises a `MikasError`: it is lost, to be opened."""

    def reset(self) -> None:
        """Leave a lost one, to be opened again."""

    def close(self) -> None:
        """Close it; any thread may call."""


class LinkSource:
    """A port of its own. `clock`: the session's. `read` waits for bytes, half a second at most.

    An adapter that comes back is found by what it is, as the unit's: after a pulled hub its name
    may be that of the unit's own adapter. `find`: the ports of this computer.
    """

    def __init__(
        self,
        chosen: ChosenInstrument,
        clock: Callable[[], float],
        open_port: Callable[[str], Link] = open_link,
        find: Callable[[], list[Port]] = find_ports,
    ) -> None:
        self._clock = clock
        self._is_gpsd = chosen.url.lower().startswith(GPSD)
        baud = line_baud(chosen.definition, chosen.url)
        url = _with_baud(network_url(chosen.url) if self._is_gpsd else chosen.url, baud)
        self._open: Callable[[], Link] = lambda: open_port(url)
        if parse(url).is_adapter:
            self._open = ReconnectingPort(url, find=find, open_port=open_port).open
        self._link: Link | None = None
        self._closed = False

    def open(self) -> None:
        """As `InstrumentSource.open`."""
        self._link = link = self._open()
        if self._is_gpsd:
            link.write(WATCH)
        if self._closed:
            self.close()

    def read(self) -> list[Chunk]:
        """As `InstrumentSource.read`."""
        link = self._link
        if link is None:
            return []
        link.gather(link.now() + _GATHER)
        chunk = link.read(link.now() + _WAIT)
        if not chunk.data:
            return []
        return [Chunk(chunk.data, self._clock() - (link.now() - chunk.time))]

    def close(self) -> None:
        """As `InstrumentSource.close`."""
        self._closed = True
        if self._link is not None:
            self._link.close()

    def reset(self) -> None:
        """As `InstrumentSource.reset`."""
        if self._link is not None:
            self._link.close()
        self._link = None


def _with_baud(url: str, baud: int) -> str:
    """Return the URL with that baud rate, unless it has one, or its link none."""
    parsed = parse(url)
    if parsed.scheme not in _WITH_BAUD or "baud" in parsed.options:
        return url
    return f"{url.partition('?')[0]}?{urlencode(parsed.options | {'baud': str(baud)})}"
