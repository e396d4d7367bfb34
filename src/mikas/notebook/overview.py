"""The facts that a recording shows of itself: its car, faults, gaps, markers and channels.

A channel's extremes, rate and course come from all of its values; the first time the recording is
read into memory for them, as for a plot.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from mikas.notebook.interruptions import course, reasons_of_gaps, span_of
from mikas.recording.recorded_faults import RecordedFaults, faults_in
from mikas.recording.summary import Summary, summary_of
from mikas.recording.table.channels import Channel
from mikas.sampling.events import Gap, Marker

if TYPE_CHECKING:
    from mikas.i18n import Text
    from mikas.recording.recording import Recording

_CURVE: Final = 120  # points of a channel's course, two for each of its columns

Curve = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class ChannelOverview:
    """A channel and its values; None: it has none.

    `rate`: values a second, by the median time between two. `share`: of a flag, how much of its
    values is set. `curve`: its course as points of (time, value), NaN where it is interrupted.
    """

    channel: Channel
    is_derived: bool
    count: int = 0
    least: float | None = None
    most: float | None = None
    share: float | None = None
    rate: float | None = None
    curve: Curve = ()


@dataclass(frozen=True, slots=True)
class Overview:
    """`zero`: the time of the first row, from which a table counts; 0.0 without rows."""

    summary: Summary
    zero: float
    rows: int
    channels: tuple[ChannelOverview, ...]
    gaps: tuple[tuple[Gap, Text | None], ...]
    markers: tuple[Marker, ...]
    faults: RecordedFaults


def overview_of(recording: Recording) -> Overview:
    """Read the facts. Raises `CaptureError` if the file can't be read any more."""
    span = recording.span
    return Overview(
        summary=summary_of(recording),
        zero=span[0] if span else 0.0,
        rows=recording.row_count,
        channels=tuple(_channels(recording)),
        gaps=tuple(reasons_of_gaps(recording.events)),
        markers=tuple(event for event in recording.events if isinstance(event, Marker)),
        faults=faults_in(recording),
    )


def _channels(recording: Recording) -> Iterator[ChannelOverview]:
    begin, end = recording.span or (0.0, 0.0)
    gaps = [span_of(event, recording) for event in recording.events if isinstance(event, Gap)]
    for channel in recording.channels:
        is_derived = channel.name in recording.catalog.derived
        rows, _ = recording.window(begin, end, sys.maxsize, [channel.name])
        values = rows.values[channel.name]
        present = np.isfinite(values)
        times, values = rows.times[present], values[present]
        if not values.size:
            yield ChannelOverview(channel, is_derived)
            continue
        intervals = np.diff(times)
        drawn = course(times, values, gaps, _CURVE)
        usual = float(np.median(intervals)) if intervals.size else 0.0
        yield ChannelOverview(
            channel,
            is_derived,
            count=values.size,
            least=float(values.min()),
            most=float(values.max()),
            share=float(values.mean()) if channel.is_flag else None,
            rate=1 / usual if usual > 0 else None,
            curve=tuple(zip(*(it.tolist() for it in drawn), strict=True)),
        )
