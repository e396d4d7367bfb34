"""Raw rows as columns of values in one interpretation: the last step from bytes to numbers (§4).

A conversion's normal form is three integers (`catalog.conversion`), and every quotient of 64-bit
floats below is the one that `Conversion.decode` computes: values are equal bit for bit. A response
whose length does not fit its request makes a row without a value.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import pairwise
from math import inf, nextafter
from typing import Final

import numpy as np

from mikas.catalog import Catalog
from mikas.catalog.conversion import Conversion
from mikas.recording.capture.reader import Source
from mikas.recording.exchanges.arrays import Bytes, Floats
from mikas.recording.table.channels import Channel, Rows, joined_rows
from mikas.recording.table.raw_recording import RawRows

MOST_ROWS: Final = 65536
_MANY: Final = 4096  # rows that are worth a stretch where a clock runs to and fro
_JITTER: Final = 1.0  # s; two lumps of bytes can be taken for overlapping by so much at most


class Converter:
    """The parameters of `catalog` with these `codes`, in one interpretation.

    `channels`: their columns, in the catalog's order. Raises `UsageError` for an unknown
    interpretation.
    """

    def __init__(self, catalog: Catalog, interpretation: str, codes: Collection[int]) -> None:
        self._by_code: dict[int, list[tuple[str, Conversion]]] = {}
        channels = []
        for each in catalog.parameters:
            conversion = each.interpretation(interpretation)
            if each.code in codes:
                channels.append(
                    Channel(
                        each.name,
                        conversion.unit,
                        each.text,
                        each.is_flag,
                        each.decimals,
                        conversion.unit_text,
                    )
                )
                self._by_code.setdefault(each.code, []).append((each.name, conversion))
        self.channels: tuple[Channel, ...] = tuple(channels)

    def stretches(
        self,
        raw: Iterable[RawRows],
        names: Iterable[str],
        *,
        size: int = MOST_ROWS,
        rising: bool = True,
    ) -> Iterator[tuple[Source, Rows]]:
        """Yield the columns `names` in stretches of at most `size` rows, each with its port.

        Times rise within a stretch, unless `rising` is false: where a clock runs to and fro, a
        stretch is a single row. They may run back between two: another port, another session.
        """
        waiting: dict[Source, _PortRows] = {}
        wanted = list(names)
        for rows in raw:
            source = rows.source
            if source not in waiting:
                for before in [each for each in waiting if each.recording != source.recording]:
                    yield from waiting.pop(before).rest()
                waiting[source] = _PortRows(source, size, rising=rising)
            yield from waiting[source].add(Rows(rows.times, self._columns(rows, wanted)))
        for port in waiting.values():
            yield from port.rest()

    def _columns(self, rows: RawRows, names: Collection[str]) -> dict[str, Floats]:
        count = len(rows.times)
        columns = {name: np.full(count, np.nan) for name in names}
        for group in rows.groups:
            for code, begin, size in group.layout.places:
                for name, conversion in self._by_code.get(code, ()):
                    if name not in columns:
                        continue
                    raw = [group.column(at) for at in range(begin, begin + size)]
                    if group.at is None:
                        columns[name] = values(raw, conversion)
                    else:
                        columns[name][group.at] = values(raw, conversion)
        return columns


class _PortRows:
    """Rows of one port that wait until they are `size`, or until time runs back."""

    def __init__(self, source: Source, size: int, *, rising: bool) -> None:
        self._source = source
        self._size = size
        self._rising = rising
        self._waiting: list[Rows] = []
        self._count = 0
        self._last = -np.inf

    def add(self, rows: Rows) -> Iterator[tuple[Source, Rows]]:
        """Take these rows; yield those that need not wait."""
        back = (np.diff(rows.times, prepend=self._last) < -_JITTER).nonzero()[0].tolist()
        backs = {*back}
        for start, stop in pairwise([0, *back, rows.times.size]):
            if start in backs:
                if self._rising or self._count >= _MANY:
                    yield from self._flush()
                self._last = -np.inf
            if start < stop:
                part = rows.part(slice(start, stop))
                rising = _rising(part.times, self._last, self._source.byte_time)
                self._last = float(rising[-1])
                self._waiting.append(Rows(rising, part.values))
                self._count += stop - start
            if self._count >= self._size:
                yield from self._flush(self._count // self._size * self._size)

    def rest(self) -> Iterator[tuple[Source, Rows]]:
        """Yield the waiting rows; the next times may be earlier."""
        yield from self._flush()
        self._last = -np.inf

    def _flush(self, count: int | None = None) -> Iterator[tuple[Source, Rows]]:
        """Yield the first `count` waiting rows, all by default."""
        count = self._count if count is None else count
        if count:
            rows = joined_rows(self._waiting)
            for at in range(0, count, self._size):
                yield self._source, rows.part(slice(at, min(count, at + self._size)))
            self._count -= count
            self._waiting = [rows.part(slice(count, None))] if self._count else []


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
