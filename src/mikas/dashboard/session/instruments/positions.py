"""Positions that a page sends: a phone's own geolocation, as an instrument without a port.

Each is kept as a line of gpsd's JSON, so that a recording can be read again by the same decoder.
"""

from __future__ import annotations

import json
import threading
from collections import deque
from collections.abc import Callable
from typing import Final

from mikas.catalog import Catalog
from mikas.instruments import InstrumentDefinition, definition_of_text
from mikas.link.base import Chunk

PHONE: Final = "phone"
POSITIONS: Final = "position:"
"""The port of an instrument whose values a page sends."""
_MOST: Final = 100  # positions that wait; a page sends one a second
_WAIT: Final = 0.5  # s of one wait for a position
_TOML: Final = """\
# The position of the phone or laptop whose browser shows the page, as that browser gives it.
text = { en = "This phone's position", ru = "Местоположение телефона" }
decoder = "gpsd"
stale = 3.5
source = "W3C Geolocation"
confidence = "confirmed"
"""


def phone(catalog: Catalog) -> InstrumentDefinition:
    """Return the definition of a phone's own position."""
    return definition_of_text(PHONE, _TOML, catalog)


class PositionSource:
    """The positions that pages send. `clock`: the session's."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._come = threading.Condition()
        self._waiting: deque[Chunk] = deque(maxlen=_MOST)
        self._closed = False

    def put(self, keys: dict[str, float]) -> None:
        """Take a position: the keys of gpsd's TPV."""
        report = {"class": "TPV", "mode": 3 if "alt" in keys else 2, **keys}
        line = json.dumps(report, separators=(",", ":")).encode() + b"\n"
        with self._come:
            self._waiting.append(Chunk(line, self._clock()))
            self._come.notify()

    def open(self) -> None:
        """As `InstrumentSource.open`."""

    def read(self) -> list[Chunk]:
        """As `InstrumentSource.read`; waits for a position, half a second at most."""
        with self._come:
            if not self._waiting and not self._closed:
                self._come.wait(_WAIT)
            found = list(self._waiting)
            self._waiting.clear()
        return found

    def reset(self) -> None:
        """As `InstrumentSource.reset`."""

    def close(self) -> None:
        """As `InstrumentSource.close`."""
        with self._come:
            self._closed = True
            self._come.notify()
