"""What a writer is given: channels, and their rows in stretches of one size, times from zero.

A live log brings rows one by one, bulk decode brings them by the ten thousand. Writers see neither:
they get `STRETCH` rows at a time (and the rest at the end), so a file does not depend on how its
rows arrived, and memory is bounded by `STRETCH` and the longest piece that was brought.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from mikas.i18n import Language
from mikas.recording.export.dialect import Dialect
from mikas.recording.export.moments import Moment, began, moments_of
from mikas.recording.table.channels import Channel, Rows, calendar
from mikas.recording.table.gaps import with_gaps
from mikas.sampling.events import Event

STRETCH = 32_768  # × 24 columns × 8 bytes: 6 MB

Column = NDArray[np.float64]


class Stretches:
    """The rows, once through, at most `longest` at a time. `rows`: how many were handed out;
    `zero`: taken off every time.
    """

    def __init__(self, channels: Sequence[Channel], source: Iterable[Rows]) -> None:
        self.longest = STRETCH
        self.rows = 0
        self.zero = 0.0
        self._names = [channel.name for channel in channels]
        self._pieces = (self._columns(rows) for rows in source if len(rows.times))
        self._held: list[list[Column]] = []  # each: times, then the channels in their order

    def first_time(self) -> float | None:
        """The first row's time, or None if there are no rows. Asked before the rows are taken."""
        if not self._held and (piece := next(self._pieces, None)) is not None:
            self._held.append(piece)
        return float(self._held[0][0][0]) if self._held else None

    def __iter__(self) -> Iterator[tuple[Column, list[Column]]]:
        """(times from zero, the channels' values in their order); never empty."""
        for columns in self._gathered():
            self.rows += len(columns[0])
            yield columns[0] - self.zero, columns[1:]

    def _gathered(self) -> Iterator[list[Column]]:
        size = self.longest
        held, self._held = self._held, []
        count = sum(len(piece[0]) for piece in held)
        for piece in self._pieces:
            held.append(piece)
            count += len(piece[0])
            if count >= size:
                whole = _joined(held)
                for at in range(0, count - size + 1, size):
                    yield [column[at : at + size] for column in whole]
                rest = count % size
                held = [[column[count - rest :] for column in whole]] if rest else []
                count = rest
        if count:
            whole = _joined(held)
            for at in range(0, count, size):
                yield [column[at : at + size] for column in whole]

    def _columns(self, rows: Rows) -> list[Column]:
        times = np.asarray(rows.times, np.float64)
        columns = [times]
        for name in self._names:
            values = rows.values.get(name)
            if values is None:
                values = np.full(len(times), np.nan)
            elif len(values) != len(times):
                raise ValueError(f"{name}: {len(values)} values for {len(times)} times")
            columns.append(np.asarray(values, np.float64))
        return columns


@dataclass(frozen=True, slots=True)
class Sheet:
    """Everything a writer needs to know. `about`: of the recording, by title; no line breaks.

    `moments`: what happened beside the values, in the order of its times.
    """

    channels: tuple[Channel, ...]
    stretches: Stretches
    moments: tuple[Moment, ...]
    started: datetime | None
    about: Mapping[str, str]
    language: Language
    dialect: Dialect


def sheet_of(
    channels: Sequence[Channel],
    rows: Iterable[Rows],
    events: Iterable[Event],
    *,
    start: float | None,
    started: datetime | None,
    about: Mapping[str, str],
    language: Language,
    dialect: Dialect,
) -> Sheet:
    """Looks at the first rows to know when it all began; the rest is taken when it is written."""
    happened = list(events)
    stretches = Stretches(channels, with_gaps(rows, happened))
    first = stretches.first_time()
    zero = start if start is not None else first
    if zero is None and happened:  # nothing came at all, but something was noted
        zero = min(map(began, happened))
    if zero is not None:
        stretches.zero = zero
        if started is None:
            started = calendar(zero)
    if started is not None and started.tzinfo is None:
        raise ValueError("`started` needs its time zone")
    return Sheet(
        channels=tuple(channels),
        stretches=stretches,
        moments=moments_of(happened, stretches.zero),
        started=started,
        about={_line(title): _line(text) for title, text in about.items()},
        language=language,
        dialect=dialect,
    )


def _line(text: str) -> str:
    return " ".join(text.split())


def _joined(pieces: list[list[Column]]) -> list[Column]:
    if len(pieces) == 1:
        return pieces[0]
    return [np.concatenate(columns) for columns in zip(*pieces, strict=True)]
