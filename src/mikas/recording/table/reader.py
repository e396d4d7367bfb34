"""A recording as a table: columns over time, in stretches, always from the raw bytes (§3, §4).

The file is read twice: once for its parameters, so that the columns are known before the first row,
and for the `01`s that are refusals (D10), which later responses decide; once for the values.
Decoded values are not stored: a formula corrected in the catalog corrects old recordings.

A conversion's normal form is three integers (`catalog.conversion`), and every quotient of 64-bit
floats below is the one that `Conversion.decode` computes: values are equal bit for bit. A response
whose length does not fit its request makes a row without a value.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import pairwise
from math import inf, nextafter
from pathlib import Path
from typing import Final

import numpy as np

from mikas.cancellation import check_cancelled
from mikas.catalog import Catalog
from mikas.catalog.conversion import Conversion
from mikas.recording.capture.reader import Problem, Source
from mikas.recording.exchanges import read_columns
from mikas.recording.exchanges.arrays import (
    Bytes,
    ExchangeColumns,
    Floats,
    Index,
    ResponseColumns,
)
from mikas.recording.exchanges.groups import (
    RefusalColumns,
    ResponseClassifier,
    ResponseGroup,
)
from mikas.recording.exchanges.layouts import Layouts
from mikas.recording.table.channels import Channel, Rows

STRETCH: Final = 65536
_MOST_PROBLEMS: Final = 1000
_JITTER: Final = 1.0  # s; two lumps of bytes can be taken for overlapping by so much at most

Columns = dict[str, Floats]


class TableReader:
    """The samples of a capture as rows of columns.

    A row is a response, its time the response's begin on the wire; a value not in it is NaN.
    `channels`: the parameters with at least one value, in the catalog's order.
    `problems`: the unreadable places of the file, up to a thousand; `problem_count` counts all.

    Raises `CaptureError` for a file that is no capture, `UsageError` for an unknown interpretation.
    Every iteration reads the file again; memory does not grow with it.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        catalog: Catalog,
        interpretation: str = "corrected",
    ) -> None:
        self.path = Path(path)
        self.problems: list[Problem] = []
        self.problem_count = 0
        self._definitions = Definitions(catalog, interpretation)
        self._refused: dict[Source, Index] = {}  # numbers of responses that do not count
        self.channels = self._definitions.channels(self._find_codes())

    def rows(self, size: int = STRETCH) -> Iterator[Rows]:
        """Yield the whole recording in stretches of at most `size` rows.

        Times rise within a stretch. They may run back between two: another port, another session.
        """
        for _, rows in self.stretches(size):
            yield rows

    def stretches(self, size: int = STRETCH) -> Iterator[tuple[Source, Rows]]:
        """Yield the rows, each stretch with the port and the recording that it comes from."""
        waiting: dict[Source, _PortRows] = {}
        taken: Counter[Source] = Counter()
        for source, exchanges, groups in self._groups(lambda _: None):
            if source not in waiting:
                for before in [each for each in waiting if each.recording != source.recording]:
                    yield from waiting.pop(before).rest()
                waiting[source] = _PortRows(source, self.channels, self._definitions, size)
            first, refused = taken[source], self._refused[source]
            taken[source] += len(exchanges.responses.starts)
            counts = np.ones(len(exchanges.responses.starts), np.bool_)
            counts[refused[slice(*refused.searchsorted([first, taken[source]]))] - first] = False
            counting = [it.only(it.fitting[counts[it.fitting]]) for it in groups]
            yield from waiting[source].add(exchanges.responses, counting)
        for rows in waiting.values():
            yield from rows.rest()

    def _find_codes(self) -> set[int]:
        """Return the codes that have a value; find problems and refusals."""
        found: set[int] = set()
        ports: dict[Source, RefusalColumns] = {}
        for source, exchanges, groups in self._groups(self._note):
            refusals = ports.setdefault(source, RefusalColumns(exchanges.bodies))
            found |= refusals.add_responses(groups, exchanges.responses)
        for source, refusals in ports.items():
            self._refused[source], believed = refusals.conclude()
            found |= believed
        return found

    def _groups(
        self, note: Callable[[Problem], None]
    ) -> Iterator[tuple[Source, ExchangeColumns, list[ResponseGroup]]]:
        """Yield the exchanges, with their responses with data."""
        ports: dict[Source, ResponseClassifier] = {}
        for item in read_columns(self.path):
            check_cancelled()
            if isinstance(item, Problem):
                note(item)
                continue
            if item.source not in ports:
                ports[item.source] = ResponseClassifier(self._definitions.layouts)
            yield item.source, item, list(ports[item.source].groups(item))

    def _note(self, problem: Problem) -> None:
        self.problem_count += 1
        if len(self.problems) < _MOST_PROBLEMS:
            self.problems.append(problem)


class _PortRows:
    """Rows of one port that wait until they are `size`, or until time runs back."""

    def __init__(
        self, source: Source, channels: Iterable[Channel], definitions: Definitions, size: int
    ) -> None:
        self._source = source
        self._names = [channel.name for channel in channels]
        self._definitions = definitions
        self._size = size
        self._waiting: list[Rows] = []
        self._count = 0
        self._last = -np.inf

    def add(
        self, responses: ResponseColumns, groups: list[ResponseGroup]
    ) -> Iterator[tuple[Source, Rows]]:
        """Take these responses; yield the rows that need not wait."""
        times, columns = self._table(responses, groups)
        back = (np.diff(times, prepend=self._last) < -_JITTER).nonzero()[0].tolist()
        backs = {*back}
        for start, stop in pairwise([0, *back, times.size]):
            if start in backs:
                yield from self.rest()
            if start < stop:
                rows = _rows(times, columns, slice(start, stop))
                rising = _rising(rows.times, self._last, self._source.byte_time)
                self._last = float(rising[-1])
                self._waiting.append(Rows(rising, rows.values))
                self._count += stop - start
            if self._count >= self._size:
                yield from self._flush()

    def rest(self) -> Iterator[tuple[Source, Rows]]:
        """Yield the waiting rows; the next times may be earlier."""
        yield from self._flush()
        self._last = -np.inf

    def _flush(self) -> Iterator[tuple[Source, Rows]]:
        if self._waiting:
            times = np.concatenate([rows.times for rows in self._waiting])
            columns = {
                name: np.concatenate([rows.values[name] for rows in self._waiting])
                for name in self._names
            }
            for at in range(0, times.size, self._size):
                yield self._source, _rows(times, columns, slice(at, at + self._size))
        self._waiting, self._count = [], 0

    def _table(
        self, responses: ResponseColumns, groups: list[ResponseGroup]
    ) -> tuple[Floats, Columns]:
        row_of = np.full(responses.times.size, -1)
        for group in groups:
            row_of[group.rows] = 0
        rows = (row_of == 0).nonzero()[0]
        row_of[rows] = np.arange(rows.size)
        columns = {name: np.full(rows.size, np.nan) for name in self._names}
        for group in groups:
            at = row_of[group.fitting]
            for name, values in converted(group, responses, self._definitions, self._names):
                if at.size == rows.size:
                    columns[name] = values
                else:
                    columns[name][at] = values
        return responses.times[rows], columns


def _rows(times: Floats, columns: Columns, part: slice) -> Rows:
    return Rows(times[part], {name: column[part] for name, column in columns.items()})


def _rising(times: Floats, last: float, byte_time: float) -> Floats:
    """Return the times; a row that seems to begin before its predecessor is one byte after it.

    Only the chunks of the bytes differ; `mikas.tester.exchange` does the same on a live line.
    """
    begins = (np.diff(times, prepend=last) <= 0).nonzero()[0]
    if not begins.size:
        return times
    times = times.copy()
    for begin in begins.tolist():
        row, before = begin, float(times[begin - 1]) if begin else last
        while row < times.size and times[row] <= before:
            before = max(before + byte_time, nextafter(before, inf))
            times[row] = before
            row += 1
    return times


class Definitions:
    """A catalog in one interpretation, as layouts and channels."""

    def __init__(self, catalog: Catalog, interpretation: str) -> None:
        self._catalog = catalog
        self._conversions = {p.name: p.interpretation(interpretation) for p in catalog.parameters}
        self.layouts = Layouts(catalog.size_of)

    def conversions(self, code: int) -> list[tuple[str, Conversion]]:
        """Return the parameters that have this code, with their conversions."""
        return [(p.name, self._conversions[p.name]) for p in self._catalog.by_code(code)]

    def channels(self, codes: Collection[int]) -> tuple[Channel, ...]:
        """Return the columns of the parameters with these codes, in the order of the catalog."""
        return tuple(
            Channel(p.name, self._conversions[p.name].unit, p.text, p.is_flag, p.decimals)
            for p in self._catalog.parameters
            if p.code in codes
        )


def converted(
    group: ResponseGroup,
    responses: ResponseColumns,
    definitions: Definitions,
    names: Collection[str],
) -> Iterator[tuple[str, Floats]]:
    """Yield the values of the group's fitting rows, a parameter at a time."""
    if not group.fitting.size:
        return
    starts = responses.starts[group.fitting]
    for code, begin, size in group.layout.places:
        if wanted := [each for each in definitions.conversions(code) if each[0] in names]:
            raw = [responses.bodies[starts + at] for at in range(begin, begin + size)]
            for name, conversion in wanted:
                yield name, values(raw, conversion)


def values(raw: Sequence[Bytes], conversion: Conversion) -> Floats:
    """Return `Conversion.decode` of every row, flags as 0 and 1.

    `raw`: the first byte of all rows, the second of all rows …
    """
    floats: Floats
    if conversion.size == 1:
        floats = _of_bytes(conversion)[raw[0]]
        return floats
    numbers = raw[0].astype(np.int64)
    for at in range(1, conversion.size):
        numbers += raw[at].astype(np.int64) * (1 << (8 * at))
    if conversion.signed:
        numbers -= (numbers & (1 << (8 * conversion.size - 1))) * 2
    if conversion.is_flag:
        floats = ((numbers & conversion.mask) != 0).astype(np.float64)
    else:
        exact = numbers * conversion.numerator + conversion.constant
        floats = exact / float(conversion.denominator)
    return floats


@lru_cache
def _of_bytes(conversion: Conversion) -> Floats:
    """Return the values of all bytes."""
    return np.array([float(conversion.decode(bytes([byte]))) for byte in range(256)])
