"""Labels of the time axis at round times: of the day, or since the start on a simulated clock.

The rule of the dashboard's chart (`axisTimes` in its `timeAxis.ts`), whose cases hold both equal.
"""

from __future__ import annotations

from datetime import datetime
from math import ceil, floor
from typing import Final

from mikas.cleaning import is_in_calendar
from mikas.i18n import Language

_STEPS: Final = (
    0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200,
    14_400, 28_800, 43_200,
)  # fmt: skip
_DAY: Final = 86_400
_MOST: Final = 9  # labels


def step_of(begin: float, end: float, most: int = _MOST) -> float:
    """Return the distance in seconds between labels, of which there are at most `most`."""
    length = end - begin
    days = _DAY * ceil(length / _DAY / most)
    return next((each for each in _STEPS if length / each <= most), days)


def round_times(begin: float, end: float, origin: float, most: int = _MOST) -> list[float]:
    """Return the times from `begin` to `end` that are round, counted from `origin`."""
    step = step_of(begin, end, most)
    first = ceil((begin - origin) / step - 1e-9)
    last = floor((end - origin) / step + 1e-9)
    return [origin + count * step for count in range(first, last + 1)]


def midnight_offset(time: float) -> float:
    """Return the seconds after 1970 at which local time was round: times of day count from it."""
    if not is_in_calendar(time):
        return 0.0
    zone = datetime.fromtimestamp(time).astimezone().utcoffset()
    return -zone.total_seconds() if zone else 0.0


def time_of_day(time: float, step: float, language: Language) -> str:
    """Return `13:37`, with seconds and their parts where labels are near to each other."""
    if not is_in_calendar(time):
        return ""
    date = datetime.fromtimestamp(time)
    if step >= 60:
        return f"{date:%H:%M}"
    if step >= 1:
        return f"{date:%H:%M:%S}"
    digits = f"{date.microsecond // 1000:03}"[: 1 if step >= 0.1 else 3]
    return f"{date:%H:%M:%S}{_point(language)}{digits}"


def elapsed(seconds: float, step: float, language: Language) -> str:
    """Return `1:05`, `−0:10`, `1:02:00`, with as many decimals as the step needs."""
    decimals = 0 if step >= 1 else 1 if step >= 0.1 else 2
    tidy = round(abs(seconds), decimals)
    hours, minutes = int(tidy // 3600), int(tidy % 3600 // 60)
    width = decimals + 3 if decimals else 2
    rest = f"{tidy % 60:0{width}.{decimals}f}".replace(".", _point(language))
    sign = "−" if seconds < 0 and tidy > 0 else ""
    return f"{sign}{hours}:{minutes:02}:{rest}" if hours else f"{sign}{minutes}:{rest}"


def _point(language: Language) -> str:
    return "," if language == "ru" else "."
