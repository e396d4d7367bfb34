"""Samples: the columns that causes are looked for in, with values held over short pauses.

Pure Python over lists, so that the page without installation, whose Python has no numpy, computes
the same. A missing value is NaN. A value counts until the next one, at most for `HOLDS` seconds: a
list of parameters read one by one has few values in each row.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import isnan, nan
from typing import Final

Column = list[float]
Span = tuple[float, float]

HOLDS: Final = 2.5
SLOW_HOLDS: Final = 15.0
SLOW: Final = frozenset({"TWAT", "TAIR", "TWATI"})
"""Temperatures change slowly; plans read them seldom."""
PAUSE: Final = 3.0  # s without a row: the rows on both sides do not belong together
STAGGERED: Final = 0.3  # share of rows without a value from which a column is held


@dataclass(frozen=True, slots=True)
class Samples:
    """Rows of one car in one session: rising `times` in seconds, columns of the same length."""

    times: Column
    columns: Mapping[str, Column]

    def __len__(self) -> int:
        return len(self.times)

    @property
    def seconds(self) -> float:
        """The time between the first and the last row."""
        return self.times[-1] - self.times[0] if self.times else 0.0

    def column(self, name: str) -> Column | None:
        """Return a column; None: it was not read, or had no value."""
        return self.columns.get(name)


def samples_of(times: Iterable[float], columns: Mapping[str, Iterable[float]]) -> Samples:
    """Return the samples with short pauses of each channel filled; columns without a value go."""
    rows = [float(time) for time in times]
    held = {name: _held(rows, list(column), name in SLOW) for name, column in columns.items()}
    return Samples(rows, {name: column for name, column in held.items() if column is not None})


def _held(times: Sequence[float], column: Column, slow: bool) -> Column | None:
    missing = sum(1 for value in column if isnan(value))
    if missing == len(column):
        return None
    if not missing:
        return column
    longest = SLOW_HOLDS if slow else HOLDS
    since, last = -longest, nan
    result = []
    for time, value in zip(times, column, strict=True):
        if not isnan(value):
            since, last = time, value
        result.append(last if time - since <= longest else nan)
    return result


def median(values: Sequence[float]) -> float:
    """Return the median; NaN of nothing."""
    return quantile(values, 0.5)


def quantile(values: Sequence[float], share: float) -> float:
    """Return the value below which `share` of the values lie; NaN of nothing."""
    if not values:
        return nan
    ordered = sorted(values)
    place = share * (len(ordered) - 1)
    index = int(place)
    if index + 1 >= len(ordered):
        return ordered[-1]
    return ordered[index] + (ordered[index + 1] - ordered[index]) * (place - index)


def spans_of(times: Sequence[float], rows: Sequence[int], most: int = 5) -> tuple[Span, ...]:
    """Return where the rows (rising numbers) lie in time: the longest spans, in order."""
    spans: list[Span] = []
    for row in rows:
        time = times[row]
        if spans and time - spans[-1][1] <= PAUSE:
            spans[-1] = (spans[-1][0], time)
        else:
            spans.append((time, time))
    longest = sorted(spans, key=lambda span: span[0] - span[1])[:most]
    return tuple(sorted(longest))


def row_at(times: Sequence[float], time: float) -> int:
    """Return the number of the first row at `time` or later."""
    return bisect_left(times, time)
