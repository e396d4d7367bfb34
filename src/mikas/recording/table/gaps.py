"""Rows for what did not come: one without any value in every gap that a recording notes.

Without it the last sample before a gap and the first behind it are neighbours, and whoever draws or
counts them takes the hole for a line.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mikas.recording.table.channels import Rows
from mikas.sampling.events import Event, Gap


def with_gaps(rows: Iterable[Rows], events: Iterable[Event]) -> Iterator[Rows]:
    """`rows`, times rising within a stretch, with a row of NaN in each gap of `events`.

    It stands half-way from where the gap begins to where it ends, or to the next row if that comes
    first. A gap before the first row of all has none.
    """
    left = sorted(
        (_Span(e.began, e.ended) for e in events if isinstance(e, Gap)),
        key=lambda span: span.began,
    )
    if not left:
        yield from rows
        return
    last: Rows | None = None
    for stretch in rows:
        if not len(stretch.times):
            continue
        begin, end = float(stretch.times[0]), float(stretch.times[-1])
        if last is not None and last.times[-1] <= begin:  # else it is another session
            begin = float(last.times[-1])
        inside = [span for span in left if begin <= span.began < end]
        left = [span for span in left if not begin <= span.began < end]
        yield _filled(stretch, inside)
        last = stretch
    if last is not None and (behind := [s for s in left if s.began >= last.times[-1]]):
        times = np.sort([span.middle(np.inf) for span in behind])
        yield Rows(times, {name: np.full(len(times), np.nan) for name in last.values})


@dataclass(frozen=True, slots=True)
class _Span:
    began: float
    ended: float | None

    def middle(self, following: float) -> float:
        """Where its row stands, if the next one comes at `following`."""
        end = min(self.began if self.ended is None else self.ended, following)
        return self.began + max(0.0, end - self.began) / 2


def _filled(rows: Rows, spans: Sequence[_Span]) -> Rows:
    if not spans:
        return rows
    places = np.searchsorted(rows.times, [span.began for span in spans], "right")
    middles = np.sort(  # gaps may lie in each other
        [span.middle(float(rows.times[place])) for span, place in zip(spans, places, strict=True)]
    )
    values = {name: np.insert(column, places, np.nan) for name, column in rows.values.items()}
    return Rows(np.insert(rows.times, places, middles), values)
