"""What a plot of a recording shows: its panes with their lines, and what stands over them.

panes ──► lines: all values of the window ──► interruptions, extremes ──► axes
                            └──► decimated: at most `points`, with the extremes kept
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from math import isfinite, isinf
from numbers import Real
from typing import TYPE_CHECKING, Final

import numpy as np

from mikas.cleaning import clean_line
from mikas.errors import usage_error
from mikas.i18n import Text
from mikas.notebook.interruptions import course, reasons_of_gaps, span_of
from mikas.notebook.panes import Pane, Trace, axis_key
from mikas.notebook.value_axes import Axis, AxisLine, axes_of, scale_of, stacked_axes
from mikas.recording.annotations.events import car_of
from mikas.recording.formatting import date_of
from mikas.recording.table.channels import Span
from mikas.sampling.events import AlarmChanged, Event, Marker, UnitFound

if TYPE_CHECKING:
    from mikas.catalog import Catalog
    from mikas.i18n import Language
    from mikas.recording.exchanges.arrays import Floats
    from mikas.recording.recording import Recording

Moment = float | datetime
"""Seconds from the first row, or a date."""

_BESIDE: Final = 0.02  # of the window, drawn on both sides, so that lines go on to the edge
_ROOM: Final = 0.01  # of a whole recording, on both sides of it; at least so many seconds
_SHORTEST: Final = 1e-3
_MOST_FLAGS: Final = 100  # flags that are nearer are one, with a count


@dataclass(frozen=True, slots=True, eq=False)
class PlottedLine:
    """A line to draw. `band`: a range behind it; `times`: seconds from the first row.

    `covered`: the number of lines before it that are the same, on the same axis.
    """

    trace: Trace
    times: Floats
    values: Floats
    axis: Axis
    key: str
    band: Span | None
    covered: int = 0

    def covers(self, other: PlottedLine) -> bool:
        """Return whether another line has the same points, on the same axis."""
        same = self.key == other.key and np.array_equal(self.times, other.times)
        return same and np.array_equal(self.values, other.values, equal_nan=True)


@dataclass(frozen=True, slots=True)
class Flag:
    """A moment marked over the panes.

    `kind`: `marker`, `unit`, or an alarm's `warning` or `danger`. `count`: how many of its kind are
    so near that they are one flag.
    """

    time: float
    kind: str
    text: Text
    count: int = 1


@dataclass(frozen=True, slots=True)
class Picture:
    """All that is drawn. `zero`: the time of the first row, `begin` and `end` count from it."""

    title: str
    panes: Sequence[Sequence[PlottedLine]]
    gaps: Sequence[tuple[Span, Text | None]]
    flags: Sequence[Flag]
    catalog: Catalog
    zero: float
    begin: float
    end: float
    stacked: bool
    language: Language


def picture_of(
    recording: Recording,
    panes: Sequence[Pane],
    *,
    language: Language,
    start: Moment | None = None,
    end: Moment | None = None,
    stacked: bool = False,
    reference: bool = False,
    points: int = 2000,
) -> Picture:
    """Return what a plot of these panes shows."""
    span = recording.span
    if span is None or not panes:
        raise usage_error(
            f"{clean_line(recording.path.name)} has no values to draw",
            f"{clean_line(recording.path.name)}: рисовать нечего, значений нет",
        )
    zero = span[0]
    room = max(_SHORTEST, (span[1] - zero) * _ROOM)
    begin = zero - room if start is None else _time(start, zero)
    last = span[1] + room if end is None else _time(end, zero)
    if not begin < last:
        raise usage_error(
            "The plot ends before it begins: start has to be before end and before the last row",
            "График кончается раньше, чем начинается: start должен быть раньше end и раньше "
            "последней строки",
        )
    gaps = list(_gaps(recording, begin, last))
    window = _Window(recording, begin, last, [span for span, _ in gaps], points)
    bands = _references(recording) if reference else {}
    car = car_of(recording.notes).name
    date = date_of(zero)
    titles = (car, clean_line(recording.path.name), f"{date:%d.%m.%Y}" if date else "")
    return Picture(
        title=" · ".join(filter(None, titles)),
        panes=[window.lines(pane, bands, stacked=stacked) for pane in panes],
        gaps=[((left - zero, right - zero), reason) for (left, right), reason in gaps],
        flags=list(_flags(recording.events, begin, last, zero)),
        catalog=recording.catalog,
        zero=zero,
        begin=begin - zero,
        end=last - zero,
        stacked=stacked,
        language=language,
    )


def _time(moment: Moment, zero: float) -> float:
    """Return the time on the link's clock."""
    if isinstance(moment, datetime):
        if date_of(zero) is None:
            raise usage_error(
                "This recording has no date: give start and end in seconds from its first row",
                "У этой записи нет даты: задайте start и end в секундах от её первой строки",
            )
        return moment.timestamp()
    if isinstance(moment, bool) or not isinstance(moment, Real) or not isfinite(moment):
        raise usage_error(
            "start and end are seconds from the first row, or a datetime",
            "start и end — секунды от первой строки или datetime",
        )
    return zero + float(moment)


def _gaps(recording: Recording, begin: float, end: float) -> Iterator[tuple[Span, Text | None]]:
    """Yield the gaps that overlap the window; one without an end lasts until the window's."""
    for gap, reason in reasons_of_gaps(recording.events):
        began, ended = span_of(gap, recording)
        if max(begin, began) <= min(end, ended):
            yield (began, end if isinf(ended) else ended), reason


def _flags(events: Iterable[Event], begin: float, end: float, zero: float) -> Iterator[Flag]:
    """Yield markers, alarms and changes of the unit; those of a kind that are near, as one."""
    latest: dict[str, list[float]] = {}  # by kind: of each flag its time, and how many it counts
    found: list[tuple[str, Text, list[float]]] = []
    inside = (event for event in events if begin <= event.time <= end)
    for event in sorted(inside, key=lambda event: event.time):
        match event:
            case Marker():
                kind, text = "marker", Text(event.label, event.label)
            case AlarmChanged(level="warning" | "danger"):
                kind, text = event.level, event.text
            case UnitFound(another=True):
                kind, text = "unit", event.model or Text("", "")
            case _:
                continue
        before = latest.get(kind)
        if before is not None and event.time - before[0] < (end - begin) / _MOST_FLAGS:
            before[1] += 1
            continue
        latest[kind] = [event.time, 1]
        found.append((kind, text, latest[kind]))
    for kind, text, (time, count) in found:
        yield Flag(time - zero, kind, text, int(count))


def _references(recording: Recording) -> dict[str, Span]:
    """Return the catalog's range at warm idle of each channel that has one in this unit."""
    catalog = recording.catalog
    known = (
        (it, catalog.channel(it.name)) for it in recording.channels if it.name in catalog.channels
    )
    return {
        channel.name: one.reference
        for channel, one in known
        if one.reference and one.unit == channel.unit
    }


class _Window:
    """The values of a recording from `begin` to `end`, and a little beside."""

    def __init__(
        self, recording: Recording, begin: float, end: float, gaps: Sequence[Span], points: int
    ) -> None:
        self._recording, self._begin, self._end = recording, begin, end
        self._gaps, self._points = gaps, points
        self._zero = (recording.span or (begin, end))[0]

    def lines(self, pane: Pane, bands: dict[str, Span], *, stacked: bool) -> list[PlottedLine]:
        """Return the lines of a pane, with the axis of each."""
        values = [self._values(trace.channel.name) for trace in pane]
        keys = [axis_key(trace.channel) for trace in pane]
        catalog = self._recording.catalog
        lines = [
            AxisLine(
                scale_of(catalog.described(trace.channel.name) or trace.channel, key),
                self._seen(*columns),
                bands.get(trace.channel.name),
            )
            for trace, key, columns in zip(pane, keys, values, strict=True)
        ]
        axes = stacked_axes(lines) if stacked else axes_of(lines)
        drawn: list[PlottedLine] = []
        for trace, key, columns, axis, line in zip(pane, keys, values, axes, lines, strict=True):
            times, shown = course(*columns, self._gaps, self._points)
            new = PlottedLine(trace, times - self._zero, shown, axis, key, line.band)
            covered = 0 if stacked else sum(map(new.covers, drawn))
            drawn.append(replace(new, covered=covered))
        return drawn

    def _values(self, name: str) -> tuple[Floats, Floats]:
        """Return the times and the values of a channel, those that there are."""
        beside = (self._end - self._begin) * _BESIDE
        begin, end = self._begin - beside, self._end + beside
        rows, _ = self._recording.window(begin, end, sys.maxsize, [name])
        present = np.isfinite(rows.values[name])
        return rows.times[present], rows.values[name][present]

    def _seen(self, times: Floats, values: Floats) -> Span | None:
        """Return the extremes in the window; if it has none, of the values beside it."""
        inside = values[(times >= self._begin) & (times <= self._end)]
        seen = inside if inside.size else values
        return (float(seen.min()), float(seen.max())) if seen.size else None
