"""Columns over time, the source of every export and data frame; and which ones a recording has.

Ten hours do not fit one table, so rows come in stretches (`Rows`) with the same columns. A missing
value (a gap, a parameter read less often) is NaN, never the last value. A recorded gap is one row
without values: otherwise a plot would join the samples on both sides.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Any, Final

from mikas.catalog import Catalog
from mikas.catalog.conversion import NO_TEXT
from mikas.cleaning import is_in_calendar
from mikas.errors import UnknownParameter, usage_error
from mikas.i18n import Language, Text
from mikas.json_values import json_of
from mikas.recording.capture.clock import LONGEST
from mikas.sampling.events import Event, Gap

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

Span = tuple[float, float]

PLAINLY_UNIX: Final = 1e9  # 2001; a simulated clock would have run for 31 years


@dataclass(frozen=True, slots=True)
class Channel:
    """A column: mnemonic, unit, description in both languages, number of decimals.

    `unit_text`: the unit for people; empty: as `unit`.
    """

    name: str
    """The mnemonic."""
    unit: str
    """The key of the unit."""
    text: Text
    """Its name for a person."""
    is_flag: bool = False
    """Whether its values are 0 and 1."""
    decimals: int = 0
    """Digits after the point."""
    unit_text: Text = NO_TEXT

    def unit_in(self, language: Language) -> str:
        """Return the unit in a language."""
        return (self.unit_text.ru if language == "ru" else "") or self.unit

    def facts(self) -> dict[str, Any]:
        """Return unit, description and decimals, for metadata."""
        return {"unit": self.unit, **json_of(self.text), "decimals": self.decimals}


@dataclass(frozen=True, slots=True)
class Rows:
    """A stretch of samples. `times`: seconds on the link's clock (UNIX time on a real one), rising.

    `values`: by channel name, as long as `times`, float64; flags are 0 and 1.
    """

    times: Floats
    values: Mapping[str, Floats]

    def part(self, chosen: slice | NDArray[np.bool_]) -> Rows:
        """Return the chosen rows."""
        columns = {name: column[chosen] for name, column in self.values.items()}
        return Rows(self.times[chosen], columns)


def joined_rows(pieces: Sequence[Rows]) -> Rows:
    """Return the rows of all pieces, which have the same columns, in their order."""
    import numpy as np

    if len(pieces) == 1:
        return pieces[0]
    names = pieces[0].values
    return Rows(
        np.concatenate([rows.times for rows in pieces]),
        {name: np.concatenate([rows.values[name] for rows in pieces]) for name in names},
    )


def calendar(time: float) -> datetime | None:
    """Return the date of `time` on the link's clock; None unless that clock counts from 1970.

    A damaged time beyond the calendar has no date either.
    """
    if time < PLAINLY_UNIX or not is_in_calendar(time):
        return None
    return datetime(1970, 1, 1, tzinfo=UTC) + timedelta(seconds=time)


def named(catalog: Catalog, name: str) -> str:
    """Return the channel's full name. Raises `UsageError` for a name without a column."""
    found = catalog.channel(name).name
    if found not in catalog.channels:
        raise usage_error(
            f"{name}: a bare code has no column; name a parameter, or describe the code in a "
            "catalog file of your own",
            f"{name}: у голого кода нет столбца; назовите параметр или опишите код в своём "
            "файле каталога",
        )
    return found


def known_but(catalog: Catalog, names: Iterable[str]) -> frozenset[str]:
    """Return the names that are no channel of the unit: perhaps an instrument's, with its label.

    Raises `UsageError` for a bare code.
    """
    unknown = set()
    for name in names:
        try:
            named(catalog, name)
        except UnknownParameter:
            unknown.add(name)
    return frozenset(unknown)


def is_recorded(name: str, catalog: Catalog, recorded: Collection[str]) -> bool:
    """Return whether the channel, or all inputs of a derived one, are recorded."""
    if name not in catalog.derived:
        return name in recorded
    needed = (*catalog.required_by([name]), *catalog.required_beside([name]))
    return all(each in recorded for each in needed)


def all_channels(
    recorded: Mapping[str, Channel],
    catalog: Catalog,
    wanted: Iterable[str],
    beside: Mapping[str, Channel],
) -> dict[str, Channel]:
    """Return the recorded channels, those derived from them, those of the instruments `beside` the
    unit, and the wanted ones, by name.
    """
    known = dict(recorded)
    both = {**recorded, **beside}
    derived = [name for name in catalog.derived if is_recorded(name, catalog, both)]
    for name in (*derived, *beside, *wanted):
        if name in beside:
            known[name] = beside[name]
        elif name not in known:
            each = catalog.instruments.get(name) or catalog.channel(name)
            known[name] = Channel(
                name, each.unit, each.text, each.is_flag, each.decimals, each.unit_text
            )
    return known


def with_gaps(rows: Iterable[Rows], events: Iterable[Event]) -> Iterator[Rows]:
    """Yield `rows`, times rising within a stretch, with a row of NaN in each gap of `events`.

    The row stands half-way between the gap's begin and its end, or the next row if that is earlier.
    A gap before the first row of all has none, nor has one years after the last.
    """
    import numpy as np

    gaps = [event for event in events if isinstance(event, Gap)]
    left = sorted((gap.began, gap.began if gap.ended is None else gap.ended) for gap in gaps)
    last: Rows | None = None
    for stretch in rows:
        if not len(stretch.times):
            continue
        begin, end = float(stretch.times[0]), float(stretch.times[-1])
        if last is not None and last.times[-1] <= begin:  # the same session: times rise
            begin = float(last.times[-1])
        inside = _pop_between(left, begin, end)
        last = stretch
        if not inside:
            yield stretch
            continue
        places = np.searchsorted(stretch.times, [began for began, _ in inside], "right")
        times = _middles(inside, stretch.times[places])
        values = {
            name: np.insert(column, places, np.nan) for name, column in stretch.values.items()
        }
        yield Rows(np.insert(stretch.times, places, times), values)
    if last is None:
        return
    ended = float(last.times[-1])
    if later := _pop_between(left, ended, ended + LONGEST):
        times = _middles(later, np.full(len(later), np.inf))
        yield Rows(times, {name: np.full(len(times), np.nan) for name in last.values})


def united(spans: Iterable[Span], distance: float = 0.0) -> list[Span]:
    """Return the spans in their order; those that overlap, or are so near, as one."""
    joined: list[Span] = []
    for begin, end in sorted(spans):
        if joined and begin <= joined[-1][1] + distance:
            joined[-1] = joined[-1][0], max(joined[-1][1], end)
        else:
            joined.append((begin, end))
    return joined


def _pop_between(spans: list[Span], begin: float, end: float) -> list[Span]:
    """Take the spans that begin from `begin` to before `end` out of all, which are sorted."""
    inside = slice(bisect_left(spans, (begin,)), bisect_left(spans, (end,)))
    taken = spans[inside]
    del spans[inside]
    return taken


def _middles(gaps: list[Span], following: Floats) -> Floats:
    """Return the times of the gaps' rows, rising. `following`: the time of the row after each."""
    import numpy as np

    began, ended = np.array([gap[0] for gap in gaps]), np.array([gap[1] for gap in gaps])
    middles: Floats = began + np.maximum(0.0, np.minimum(ended, following) - began) / 2
    return np.sort(middles)  # a gap may lie in another
