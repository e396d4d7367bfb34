"""Where a line of the chart is interrupted, and why: gaps of the connection, and missing values."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from mikas.recording.table.channels import Rows, Span, united
from mikas.recording.table.decimation import decimated
from mikas.sampling.events import SLEPT, Event, Gap, StateChanged

if TYPE_CHECKING:
    from mikas.i18n import Text
    from mikas.recording.exchanges.arrays import Floats
    from mikas.recording.recording import Recording

# As the dashboard's chart: a line is interrupted after a few of its usual intervals.
_DEFAULT: Final = 3.0  # s, with too few values to measure the interval
_LEAST: Final = 0.5  # s; a short pause of the line never counts
_INTERVALS: Final = 5
_ENOUGH: Final = 3


def reasons_of_gaps(events: Sequence[Event]) -> Iterator[tuple[Gap, Text | None]]:
    """Yield the gaps, each with the state of the line in it, or else the reason that was noted.

    The state is short; the reason is advice in full. A sleep of the computer is its own reason.
    """
    states = sorted(
        (
            ((event.recording, event.time), event.text)
            for event in events
            if isinstance(event, StateChanged) and event.reason is not None
        ),
        key=lambda state: state[0],
    )
    times = [time for time, _ in states]  # each in its session
    for gap in events:
        if isinstance(gap, Gap):
            ended = np.inf if gap.ended is None else gap.ended
            last = bisect_right(times, (gap.recording, ended)) - 1
            in_it = last >= 0 and times[last] >= (gap.recording, gap.began) and gap.reason != SLEPT
            yield gap, states[last][1] if in_it else gap.reason


def span_of(gap: Gap, recording: Recording) -> Span:
    """Return begin and end of a gap.

    One that its session ended in lasts until the next session, or without one to infinity.
    """
    if gap.ended is not None:
        return gap.began, gap.ended
    following = recording.session_after(gap.recording, gap.began)
    return gap.began, np.inf if following is None else following


def longest_interval(times: Floats) -> float:
    """Return how many seconds may be between two values of a line that is not interrupted.

    `times`: of its values. The 80 % quantile, not the median: the rate may change on the way.
    """
    intervals = np.diff(times)
    if intervals.size < _ENOUGH:
        return _DEFAULT
    at = int((intervals.size - 1) * 0.8)
    usual = float(np.partition(intervals, at)[at])
    return max(_LEAST, _INTERVALS * usual)


def interruptions(times: Floats, gaps: Iterable[Span] = ()) -> list[Span]:
    """Return where a line with values at `times` is interrupted, those that overlap as one."""
    wide = np.flatnonzero(np.diff(times) > longest_interval(times))
    found = [*zip(times[wide].tolist(), times[wide + 1].tolist(), strict=True), *gaps]
    return united(found)


def broken(times: Floats, values: Floats, spans: Sequence[Span]) -> tuple[Floats, Floats]:
    """Return the points of a line with a NaN where one of `spans` lies between two of them."""
    if len(times) < 2 or not spans:
        return times, values
    begins, ends = np.array([span[0] for span in spans]), np.array([span[1] for span in spans])
    # Spans do not overlap: the first that ends after a point is the one that may follow it.
    following = np.minimum(ends.searchsorted(times[:-1], "right"), ends.size - 1)
    cut = np.flatnonzero((ends[following] > times[:-1]) & (begins[following] < times[1:]))
    places = np.maximum(times[cut], begins[following[cut]])
    return np.insert(times, cut + 1, places), np.insert(values, cut + 1, np.nan)


def course(
    times: Floats, values: Floats, gaps: Iterable[Span], points: int
) -> tuple[Floats, Floats]:
    """Return a line of about `points` points at most, with a NaN where it is interrupted.

    `times`: of its values, all of which there are.
    """
    spans = interruptions(times, gaps)
    fewer = decimated(Rows(times, {"": values}), points)
    present = np.isfinite(fewer.values[""])  # a piece of time without values is no gap
    return broken(fewer.times[present], fewer.values[""][present], spans)
