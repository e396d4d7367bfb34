"""gpsd's JSON: one object a line; TPV has position and speed. What gpsd is asked is in `WATCH`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import isfinite
from typing import Any, Final

from mikas.i18n import Text
from mikas.instruments.decoders.lines import LineDecoder
from mikas.instruments.events import NO_FIX

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


class GpsdDecoder(LineDecoder):
    """Decodes gpsd's lines."""

    longest = LONGEST_OBJECT

    def _decoded(self, line: bytes) -> Mapping[str, float] | Text:
        return _values(json.loads(line))


def _values(found: Any) -> Mapping[str, float] | Text:  # noqa: ANN401  (JSON of another program)
    """Return the values of a report; none of another class; `NO_FIX` without a position.

    Raises `TypeError`, `ValueError` or `OverflowError`.
    """
    if not isinstance(found, dict):
        raise TypeError(type(found))
    if found.get("class") != "TPV":
        return {}
    mode = found.get("mode")
    if not isinstance(mode, int) or mode < _NO_FIX_BELOW:
        return NO_FIX
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
