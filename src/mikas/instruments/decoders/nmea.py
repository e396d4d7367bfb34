"""NMEA 0183: the sentences RMC, GGA and VTG of any GPS, GLONASS or combined receiver.

    $GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A
    talker GP, sentence RMC; A: valid; 48° 07.038′; 22.4 knots; 84.4°; checksum

A sentence without a right checksum gives no value: a GPS beside an ignition coil has such ones.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from operator import xor
from typing import Final

from mikas.i18n import Text
from mikas.instruments.decoders.lines import LineDecoder
from mikas.instruments.events import NO_FIX, NOT_UNDERSTOOD, WRONG_CHECKSUM

CHANNELS: Final = ("GPS_SPEED", "GPS_LAT", "GPS_LON", "GPS_ALT", "GPS_COURSE")
LONGEST_SENTENCE: Final = 200  # 82 by the standard; receivers have longer ones of their own
KNOT: Final = 1.852  # km/h
_DIGITS: Final = frozenset("0123456789.+-")


class NmeaDecoder(LineDecoder):
    """Decodes sentences."""

    longest = LONGEST_SENTENCE

    def _decoded(self, line: bytes) -> Mapping[str, float] | Text:
        start = line.rfind(b"$")  # what stands before it is the rest of another sentence
        if start < 0:
            return NOT_UNDERSTOOD
        body, star, given = line[start + 1 :].partition(b"*")
        if not star or f"{reduce(xor, body, 0):02X}".encode() != given.strip().upper():
            return WRONG_CHECKSUM
        return _values(body.decode("ascii").split(","))


def _values(words: list[str]) -> Mapping[str, float] | Text:
    """Return the values of a sentence; none of another kind; `NO_FIX` without a position.

    Raises `ValueError` or `IndexError`.
    """
    match words[0][2:]:
        case "RMC":
            if words[2] != "A":
                return NO_FIX
            found = _position(words[3:7])
            if words[7]:
                found["GPS_SPEED"] = _number(words[7]) * KNOT
            if words[8]:
                found["GPS_COURSE"] = _number(words[8])
            return found
        case "GGA":
            if words[6] in ("", "0"):
                return NO_FIX
            found = _position(words[2:6])
            if words[9]:
                found["GPS_ALT"] = _number(words[9])
            return found
        case "VTG":
            if len(words) > 9 and words[9] == "N":
                return NO_FIX
            found = {}
            if words[1]:
                found["GPS_COURSE"] = _number(words[1])
            if words[7]:
                found["GPS_SPEED"] = _number(words[7])
            return found
    return {}


def _position(words: list[str]) -> dict[str, float]:
    """Return latitude and longitude of `4807.038,N,01131.000,E`."""
    latitude, north, longitude, east = words
    return {
        "GPS_LAT": _degrees(latitude) * {"N": 1, "S": -1}.get(north, 1000),
        "GPS_LON": _degrees(longitude) * {"E": 1, "W": -1}.get(east, 1000),
    }


def _degrees(text: str) -> float:
    """Return `4807.038` in degrees: two digits before the point are minutes, padded or not."""
    place = len(text.partition(".")[0]) - 2
    degrees = text[: max(place, 0)]
    if not degrees.isdecimal() or not 0 <= (minutes := _number(text[place:])) < 60:
        raise ValueError(text)
    return int(degrees) + minutes / 60


def _number(text: str) -> float:
    """Return a plain number: `float` alone would take “nan” and “1_0”, too."""
    if not _DIGITS.issuperset(text):
        raise ValueError(text)
    return float(text)
