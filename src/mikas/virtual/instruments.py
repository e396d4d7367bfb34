"""Virtual instruments beside the virtual unit: a λ meter in its exhaust, a GPS on its roof.

No I/O and no clock: `sent` returns the messages up to a time, with the moment of each one's last
byte. They agree with the car: λ is what burns in its cylinders (and air while nothing does), speed
is the drive's, and the position is where that speed has brought it. Reading them changes nothing of
the car.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from math import cos, floor, radians, sin
from operator import xor
from typing import Final

from mikas.errors import usage_error
from mikas.virtual.cars import EngineCar
from mikas.virtual.model.engine import EngineState

LATITUDE, LONGITUDE, ALTITUDE = 56.2965, 43.9361, 84.0  # where a Volga comes from
_STOICHIOMETRIC: Final = 14.7
_LEANEST_SHOWN: Final = 1.35  # of the meters: free air is more
_DEGREE: Final = 111_195.0  # m of a degree of latitude
_BENDS: Final = 900.0  # m of road from one bend to the next like it
_PERIODS: Final = {"aem": 0.1, "14point7": 0.1, "innovate": 0.08192, "nmea": 1.0}
BAUDS: Final = {"aem": 9600, "14point7": 9600, "innovate": 19200, "nmea": 9600}
"""The instruments that there are, with the bits a second of their wires."""


def check_virtual_instrument(name: str) -> None:
    """Raise `UsageError` for an instrument that no virtual car has."""
    if name not in _PERIODS:
        raise usage_error(
            f"There is no virtual “{name}”; there are: {', '.join(_PERIODS)}",
            f"Виртуального прибора «{name}» нет; есть: {', '.join(_PERIODS)}",
        )


class VirtualInstrument:
    """One instrument of the kind `name` in `car`, switched on at `start` of the caller's clock."""

    def __init__(self, name: str, car: EngineCar, start: float) -> None:
        check_virtual_instrument(name)
        self.name = name
        self._car = car
        self._period = _PERIODS[name]
        self._byte_time = 10 / BAUDS[name]
        self._start = start
        self._number = 0  # of the next message
        self._distance = 0.0  # m
        self._east = self._north = 0.0  # m
        self._message: Callable[[EngineState, float], bytes] = {
            "aem": _aem, "14point7": _spartan, "innovate": _innovate, "nmea": self._nmea
        }[name]  # fmt: skip

    @property
    def next_time(self) -> float:
        """The time of the next message."""
        return self._start + (self._number + 1) * self._period

    def sent(self, now: float) -> list[tuple[float, bytes]]:
        """Return the messages up to `now`, with the time of each one's last byte."""
        found = []
        while (time := self.next_time) <= now:
            self._number += 1
            state = self._car.state(time)
            message = self._message(state, time)
            found.append((time + len(message) * self._byte_time, message))
        return found

    def _nmea(self, state: EngineState, time: float) -> bytes:
        """Return RMC and GGA of the place to which the car's speed has brought it."""
        course = 70.0 + 35.0 * sin(self._distance / _BENDS)
        step = state.speed / 3.6 * self._period
        self._distance += step
        self._east += step * sin(radians(course))
        self._north += step * cos(radians(course))
        latitude = LATITUDE + self._north / _DEGREE
        longitude = LONGITUDE + self._east / (_DEGREE * cos(radians(LATITUDE)))
        place = f"{_minutes(latitude, 2)},N,{_minutes(longitude, 3)},E"
        clock, date = _clock(time)
        knots = state.speed / 1.852
        rmc = f"GPRMC,{clock},A,{place},{knots:.2f},{course:.1f},{date},,,A"
        gga = f"GPGGA,{clock},{place},1,09,0.9,{ALTITUDE:.1f},M,14.0,M,,"
        return _sentence(rmc) + _sentence(gga)


def _lambda(state: EngineState) -> float:
    return min(_LEANEST_SHOWN, state.burnt)


def _aem(state: EngineState, _: float) -> bytes:
    return f"{_lambda(state) * _STOICHIOMETRIC:.1f}\r\n".encode()


def _spartan(state: EngineState, _: float) -> bytes:
    return f"{_lambda(state):.3f}\r\n".encode()


def _innovate(state: EngineState, _: float) -> bytes:
    thousandths = round((_lambda(state) - 0.5) * 1000)
    ratio = round(_STOICHIOMETRIC * 10)
    high, low = divmod(max(0, thousandths), 128)
    return bytes([0xB2, 0x82, 0x42 | ratio >> 7, ratio & 0x7F, high, low])


def _minutes(degrees: float, digits: int) -> str:
    """Return `5617.7900` of 56.2965°."""
    whole = floor(degrees)
    minutes = round((degrees - whole) * 60, 4)
    if minutes >= 60:
        whole, minutes = whole + 1, 0.0
    return f"{whole:0{digits}d}{minutes:07.4f}"


def _clock(time: float) -> tuple[str, str]:
    """Return a receiver's time of day, and a date that no decoder here reads."""
    seconds = time % 86400
    hours, rest = divmod(seconds, 3600)
    return f"{int(hours):02d}{int(rest // 60):02d}{rest % 60:05.2f}", "010126"


def _sentence(body: str) -> bytes:
    return f"${body}*{reduce(xor, body.encode(), 0):02X}\r\n".encode()
