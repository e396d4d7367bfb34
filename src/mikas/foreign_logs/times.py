"""The time of a row: how a program may write it, and what that is in seconds.

A unit is never guessed from the numbers. Of dates with slashes the order has to be said: 03/04 is
two different days.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from datetime import UTC, datetime, timedelta, timezone
from math import isnan, nan
from typing import Final

UNITS: Final[dict[str, float]] = {
    "s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0, "d": 86400.0,
}  # fmt: skip
"""Seconds in one of each unit in which a time may be counted."""
CLOCK: Final = "clock"
DATES: Final = ("date", "date-dmy", "date-mdy")
TIME_UNITS: Final = (*UNITS, CLOCK, *DATES)
"""All forms of a time: counted, the time of day, a date."""

_SPELT: Final = {
    "s": ("s", "sec", "secs", "second", "seconds", "с", "сек", "секунд", "секунды"),
    "ms": ("ms", "msec", "millisecond", "milliseconds", "мс", "мсек"),
    "us": ("us", "µs", "μs", "usec", "мкс"),
    "min": ("min", "minutes", "мин"),
    "h": ("h", "hours", "ч", "час"),
    "d": ("d", "days", "сут", "дней"),
}
_BY_SPELLING: Final = {word: unit for unit, words in _SPELT.items() for word in words}
_CLOCK: Final = re.compile(
    r"(\d{1,3}):([0-5]?\d):([0-5]?\d(?:[.,]\d{1,9})?)(?:\s*([AaPp])[Mm])?", re.ASCII
)
_ISO: Final = re.compile(r"(\d{4})[-./](\d{1,2})[-./](\d{1,2})(?:[T ]+(.+))?", re.ASCII)
_DOTS: Final = re.compile(r"(\d{1,2})[.](\d{1,2})[.](\d{4})(?:[T, ]+(.+))?", re.ASCII)
_SLASHES: Final = re.compile(r"(\d{1,2})[/-](\d{1,2})[/-](\d{4})(?:[T, ]+(.+))?", re.ASCII)
_ZONE: Final = re.compile(r"(.*?)\s*(?:(Z)|([+-])(\d{2}):?(\d{2}))", re.ASCII)
_DAY: Final = 86400.0
_BACK: Final = 43200.0  # a clock that goes back further than this has passed midnight


def unit_spelt(text: str) -> str | None:
    """Return the unit of time that a program spells so: `msec` is ms; None: it is none."""
    return _BY_SPELLING.get(text.strip().rstrip(".").casefold())


def form_of(cells: Iterable[str]) -> str | None:
    """Return `clock` or `date` if all cells are unmistakably written so; else None."""
    written = [cell.strip() for cell in cells if cell.strip()]
    for form in (CLOCK, DATES[0]):
        read = _READERS[form]
        if written and not any(isnan(read(cell)) for cell in written):
            return form
    return None


def reader_of(unit: str, number: Callable[[str], float | None]) -> Callable[[str], float]:
    """Return what makes seconds of a cell, NaN if it holds no such time; rows are in order.

    `number`: reads a number as the file writes them. A clock that passes midnight goes on.
    """
    if unit in UNITS:
        factor = UNITS[unit]

        def counted(cell: str) -> float:
            value = number(cell)
            return nan if value is None else _scaled(value, factor)

        return counted
    if unit == CLOCK:
        return _Clock()
    return _READERS[unit]


def _scaled(value: float, factor: float) -> float:
    """Return `value` × `factor`, by a division where that is exact: 1234 ms are 1.234 s."""
    return value / round(1 / factor) if factor < 1 else value * factor


class _Clock:
    """A time of day that goes on after midnight."""

    def __init__(self) -> None:
        self._last, self._days = nan, 0.0

    def __call__(self, cell: str) -> float:
        time = _of_clock(cell)
        if isnan(time):
            return nan
        if self._last - time > _BACK:
            self._days += _DAY
        self._last = time
        return time + self._days


def _of_clock(cell: str) -> float:
    found = _CLOCK.fullmatch(cell.strip())
    if not found:
        return nan
    hours, minutes, seconds, half = found.groups()
    hour = int(hours)
    if half:
        if not 1 <= hour <= 12:
            return nan
        hour = hour % 12 + (12 if half in "Pp" else 0)
    return hour * 3600 + int(minutes) * 60 + float(seconds.replace(",", "."))


def _dated(year: str, month: str, day: str, rest: str | None) -> float:
    zone, seconds = UTC, 0.0
    if rest is not None:
        rest = rest.strip()
        if with_zone := _ZONE.fullmatch(rest):
            rest, _, sign, hours, minutes = with_zone.groups()
            if sign:
                away = timedelta(hours=int(hours), minutes=int(minutes))
                if away >= timedelta(days=1):
                    return nan
                zone = timezone(-away if sign == "-" else away)
        seconds = _of_clock(rest if rest.count(":") != 1 else f"{rest}:00")
    try:
        return datetime(int(year), int(month), int(day), tzinfo=zone).timestamp() + seconds
    except (ValueError, OverflowError):
        return nan


def _of_date(cell: str) -> float:
    cell = cell.strip()
    if found := _ISO.fullmatch(cell):
        return _dated(*found.groups())
    if found := _DOTS.fullmatch(cell):
        day, month, year, rest = found.groups()
        return _dated(year, month, day, rest)
    return nan


def _day_first(cell: str) -> float:
    if not (found := _SLASHES.fullmatch(cell.strip())):
        return _of_date(cell)
    day, month, year, rest = found.groups()
    return _dated(year, month, day, rest)


def _month_first(cell: str) -> float:
    if not (found := _SLASHES.fullmatch(cell.strip())):
        return _of_date(cell)
    month, day, year, rest = found.groups()
    return _dated(year, month, day, rest)


_READERS: Final[dict[str, Callable[[str], float]]] = {
    CLOCK: _of_clock, "date": _of_date, "date-dmy": _day_first, "date-mdy": _month_first,
}  # fmt: skip
