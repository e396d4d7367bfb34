"""Where an instrument's bytes come from: a port of its own, gpsd, or the virtual car
(`virtual_source`).

A source is opened, read, and opened again after a loss. What it raises is a `MikasError`; the
session's own line never sees it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, Protocol

from mikas.instruments.choosing import GPSD, ChosenInstrument, network_url
from mikas.instruments.decoders.gpsd import WATCH
from mikas.link import Link, open_link
from mikas.link.base import Chunk
from mikas.link.urls import parse

_WITH_BAUD: Final = ("serial", "socket", "rfc2217", "webserial", "webusb")
_NETWORK_BAUD: Final = 1_000_000  # more than it sends is no GPS
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
    """A port of its own. `clock`: the session's. `read` waits for bytes, half a second at most."""

    def __init__(
        self,
        chosen: ChosenInstrument,
        clock: Callable[[], float],
        open_port: Callable[..., Link] = open_link,
    ) -> None:
        self._chosen, self._clock, self._open_port = chosen, clock, open_port
        self._link: Link | None = None
        self._closed = False

    def open(self) -> None:
        """As `InstrumentSource.open`."""
        url, baud = self._chosen.url, self._chosen.definition.baud
        is_gpsd = url.lower().startswith(GPSD)
        if is_gpsd:
            url, baud = network_url(url), _NETWORK_BAUD
        parsed = parse(url)
        takes_baud = parsed.scheme in _WITH_BAUD and "baud" not in parsed.options
        link = self._open_port(url, baud=baud) if takes_baud else self._open_port(url)
        if is_gpsd:
            link.write(WATCH)
        self._link = link
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
