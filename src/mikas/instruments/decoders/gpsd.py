"""gpsd's JSON: one object a line; TPV has position and speed. What gpsd is asked is in `WATCH`."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from math import isfinite
from typing import Any, Final

from mikas.instruments.decoders.splitting import LineSplitter
from mikas.instruments.events import (
    NO_FIX,
    NOT_UNDERSTOOD,
    OUT_OF_RANGE,
    TOO_LONG,
    InstrumentEvent,
    InstrumentValues,
    NoValues,
)

WATCH: Final = b'?WATCH={"enable":true,"json":true};\n'
LONGEST_OBJECT: Final = 10_240  # bytes; gpsd's own limit of a response
_NO_FIX_BELOW: Final = 2  # TPV's mode: 2 is a position, 3 one with its altitude
# The key of TPV, and by how much its number is multiplied; of several, the first that is there.
_KEYS: Final = {
    "GPS_LAT": (("lat",), 1.0),
    "GPS_LON": (("lon",), 1.0),
    "GPS_SPEED": (("speed",), 3.6),
    "GPS_ALT": (("altMSL", "alt"), 1.0),
    "GPS_COURSE": (("track",), 1.0),
}


class GpsdDecoder:
    """Decodes gpsd's lines. `fits`: whether a channel can have a value."""

    def __init__(self, fits: Callable[[Mapping[str, float]], bool]) -> None:
        self._fits = fits
        self._lines = LineSplitter(LONGEST_OBJECT)

    def drop(self) -> None:
        """As `InstrumentDecoder.drop`."""
        self._lines.drop()

    def feed(self, data: bytes) -> list[InstrumentEvent]:
        """As `InstrumentDecoder.feed`."""
        return list(self._events(data))

    def _events(self, data: bytes) -> Iterator[InstrumentEvent]:
        for line in self._lines.feed(data):
            shown = line.data[:256]
            if not line.is_whole:
                yield NoValues(line.end, TOO_LONG, shown)
                continue
            try:
                found = json.loads(line.data)
                values = _values(found)
            except (ValueError, RecursionError, TypeError, OverflowError):
                yield NoValues(line.end, NOT_UNDERSTOOD, shown)
                continue
            if values is None:
                yield NoValues(line.end, NO_FIX, shown)
            elif not self._fits(values):
                yield NoValues(line.end, OUT_OF_RANGE, shown)
            elif values:
                yield InstrumentValues(line.end, values)


def _values(found: Any) -> dict[str, float] | None:  # noqa: ANN401  (JSON of another program)
    """Return the values of a report; none of another class; None: no position."""
    if not isinstance(found, dict):
        raise TypeError(type(found))
    if found.get("class") != "TPV":
        return {}
    mode = found.get("mode")
    if not isinstance(mode, int) or mode < _NO_FIX_BELOW:
        return None
    values: dict[str, float] = {}
    for channel, (keys, factor) in _KEYS.items():
        number = next((found[key] for key in keys if found.get(key) is not None), None)
        if number is None:
            continue
        if isinstance(number, bool) or not isinstance(number, int | float):
            raise TypeError(number)
        if not isfinite(value := float(number) * factor):
            raise ValueError(number)
        values[channel] = value
    return values
