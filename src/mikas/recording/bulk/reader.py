"""A recording as a table: columns over time, in stretches, from the raw bytes every time anew.

The file is read twice: once to learn which parameters it has, so that the columns are known before
the first row, and which `01`s are refusals (D10), as what comes later tells; once for the values.
Nothing decoded is kept: a formula that was corrected in the catalog gives corrected values of an
old recording.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Final

import numpy as np

from mikas.catalog import Catalog
from mikas.recording.bulk.arrays import Floats
from mikas.recording.bulk.capture import read
from mikas.recording.bulk.columns import Definitions, Part, Sorter, converted
from mikas.recording.bulk.doubt import Doubt, Verdicts
from mikas.recording.bulk.match import Answers, Matcher
from mikas.recording.bulk.packets import Packets
from mikas.recording.reader import Problem, Source
from mikas.recording.table import Channel, Rows

STRETCH: Final = 65536
_MOST_PROBLEMS: Final = 1000
_JITTER: Final = 1.0  # s; two lumps of bytes can be taken for overlapping by so much at most

Columns = dict[str, Floats]


class TableReader:
    """The samples of a capture as rows of columns.

    A row is a response, its time when that began on the wire; what was not in it is NaN. `channels`
    are the parameters that have at least one value, or `names`, in the order of the catalog.
    `problems` are the places of the file that could not be read, up to a thousand of them, complete
    once `channels` is known; `problem_count` counts them all.

    Raises `CaptureError` for a file that is no capture, `UsageError` for no such reading. Every
    iteration reads the file anew; memory does not grow with it.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        catalog: Catalog,
        interpretation: str = "corrected",
        *,
        names: Collection[str] | None = None,
    ) -> None:
        self.path = Path(path)
        self.problems: list[Problem] = []
        self.problem_count = 0
        self._definitions = Definitions(catalog, interpretation)
        self._verdicts: dict[Source, Verdicts] = {}
        found = self._look_through()
        if names is not None:
            found = {catalog.parameter(name).name for name in names}
        self.channels: tuple[Channel, ...] = self._definitions.channels(found)

    def rows(self, size: int = STRETCH) -> Iterator[Rows]:
        """The whole recording in stretches of at most `size` rows.

        Times rise within a stretch. They may run back between two: another port, another session.
        """
        for _, rows in self.stretches(size):
            yield rows

    def stretches(self, size: int = STRETCH) -> Iterator[tuple[Source, Rows]]:
        """As `rows`, each with the port and the recording that it comes from."""
        names = [channel.name for channel in self.channels]
        waiting: dict[Source, _Stretch] = {}
        doubts: dict[Source, Doubt] = {}
        for source, answers, sorter in self._answers(problems=False):
            if source not in waiting:
                for before in [it for it in waiting if it.recording != source.recording]:
                    yield from waiting.pop(before).rest()
                waiting[source] = _Stretch(source, names, size)
                doubts[source] = Doubt(sorter.bodies, self._verdicts.get(source, Verdicts()))
            parts = list(doubts[source].weighed(list(sorter.parts(answers)), answers))
            yield from waiting[source].add(answers, parts)
        for left in waiting.values():
            yield from left.rest()

    def _look_through(self) -> set[str]:
        found: set[str] = set()
        doubts: dict[Source, Doubt] = {}
        for source, answers, sorter in self._answers(problems=True):
            if source not in doubts:
                doubts[source] = Doubt(sorter.bodies)
            for part in doubts[source].weighed(list(sorter.parts(answers)), answers):
                if part.fitting.size:
                    found.update(place.name for place in part.layout.places)
        for source, doubt in doubts.items():
            self._verdicts[source], believed = doubt.conclude()
            found |= self._definitions.names(believed)
        return found

    def _answers(self, *, problems: bool) -> Iterator[tuple[Source, Answers, Sorter]]:
        lines: dict[Source, tuple[Matcher, Sorter]] = {}
        for item in read(self.path):
            if isinstance(item, Problem):
                for matcher, _ in lines.values():
                    matcher.interrupt()
                if problems:
                    self._note(item)
                continue
            matcher, sorter = self._line(lines, item)
            yield item.source, matcher.feed(item), sorter

    def _line(
        self, lines: dict[Source, tuple[Matcher, Sorter]], packets: Packets
    ) -> tuple[Matcher, Sorter]:
        source = packets.source
        if source not in lines:
            if any(line.recording != source.recording for line in lines):
                lines.clear()
            matcher = Matcher(source)
            lines[source] = matcher, Sorter(self._definitions, matcher.bodies)
        return lines[source]

    def _note(self, problem: Problem) -> None:
        self.problem_count += 1
        if len(self.problems) < _MOST_PROBLEMS:
            self.problems.append(problem)


class _Stretch:
    """Rows of one port that wait until there are enough of them, or time runs back."""

    def __init__(self, source: Source, names: list[str], size: int) -> None:
        self._source = source
        self._names = names
        self._size = size
        self._times: list[Floats] = []
        self._columns: list[Columns] = []
        self._count = 0
        self._last = -np.inf

    def add(self, answers: Answers, parts: list[Part]) -> Iterator[tuple[Source, Rows]]:
        """Takes these answers; gives stretches that are full."""
        times, columns = self._table(answers, parts)
        if not times.size:
            return
        steps = np.diff(times, prepend=self._last)
        back = (steps < -_JITTER).nonzero()[0].tolist()
        for start, stop in zip([0, *back], [*back, times.size], strict=True):
            if start in back:
                yield from self.rest()
            if start < stop:
                yield from self._append(times, columns, slice(start, stop))

    def _append(
        self, times: Floats, columns: Columns, rows: slice
    ) -> Iterator[tuple[Source, Rows]]:
        start, stop = rows.start, rows.stop
        _raise(times[rows], self._last, 10 / (self._source.baud or 9600))
        while start < stop:
            end = min(stop, start + self._size - self._count)
            self._times.append(times[start:end])
            self._columns.append({name: column[start:end] for name, column in columns.items()})
            self._last = float(times[end - 1])
            self._count += end - start
            start = end
            if self._count == self._size:
                yield from self._flush()

    def rest(self) -> Iterator[tuple[Source, Rows]]:
        """What waits; after that, times begin anew."""
        yield from self._flush()
        self._last = -np.inf

    def _flush(self) -> Iterator[tuple[Source, Rows]]:
        if self._count:
            values = {
                name: np.concatenate([columns[name] for columns in self._columns])
                for name in self._names
            }
            yield self._source, Rows(np.concatenate(self._times), values)
        self._times, self._columns, self._count = [], [], 0

    def _table(self, answers: Answers, parts: list[Part]) -> tuple[Floats, Columns]:
        row_of = np.full(answers.times.size, -1)
        for part in parts:
            row_of[part.rows] = 0
        rows = (row_of == 0).nonzero()[0]
        row_of[rows] = np.arange(rows.size)
        columns = {name: np.full(rows.size, np.nan) for name in self._names}
        for part in parts:
            for name, values in converted(part, answers, self._names):
                columns[name][row_of[part.fitting]] = values
        return answers.times[rows], columns


def _raise(times: Floats, last: float, byte_time: float) -> None:
    """What seems to begin before its predecessor only came in another lump: a byte behind it, as
    live (`mikas.tester.timed_decoder`).
    """
    begins = (np.diff(times, prepend=last) <= 0).nonzero()[0]
    for begin in begins.tolist():
        row, before = begin, float(times[begin - 1]) if begin else last
        while row < times.size and times[row] <= before:
            before += byte_time
            times[row] = before
            row += 1


def read_table(
    path: str | os.PathLike[str],
    catalog: Catalog,
    interpretation: str = "corrected",
    rows: int = STRETCH,
) -> tuple[tuple[Channel, ...], Iterator[Rows], list[Problem]]:
    """The columns of a capture, its rows in stretches, and what could not be read of the file."""
    table = TableReader(path, catalog, interpretation)
    return table.channels, table.rows(rows), table.problems
