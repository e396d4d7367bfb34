"""Any window of a recording, for scrubbing through it: the columns in memory, packed.

Ten hours by list are a million rows. Of such a recording parameters are stored as the whole numbers
of their raw data (one to two bytes each, two to four here), so values equal those of `rows()` bit
for bit; ten hours of all channels take about 130 MB. A short recording is kept as it is.

More rows than a picture has points are decimated (`decimation.py`), wide windows by blocks of rows
whose extremes are computed once, when they are first needed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mikas.catalog.conversion import Conversion
from mikas.recording.exchanges.arrays import Floats, Index
from mikas.recording.table.channels import Rows
from mikas.recording.table.decimation import Pieces, extremes

_SHORT: Final = 1 << 18  # rows of a recording that is not packed: 60 MB of all channels
_BLOCK: Final = 64  # rows
_ENOUGH: Final = 4  # blocks in a piece of time
_ALL: Final = slice(None)
_MISSING: Final = {2: np.iinfo(np.int16).min, 4: np.iinfo(np.int32).min}


@dataclass(frozen=True, eq=False)
class _Packed:
    """A column as whole numbers, or as floats if these would not restore every value."""

    numbers: NDArray[np.generic]
    conversion: Conversion | None = None

    def values(self, chosen: slice = _ALL) -> Floats:
        """Return the values of the rows `chosen`."""
        numbers, conversion = self.numbers[chosen], self.conversion
        if conversion is None:
            return np.asarray(numbers, np.float64)
        whole = numbers.astype(np.int64)
        if conversion.is_flag:
            values = whole.astype(np.float64)
        else:
            exact = whole * conversion.numerator + conversion.constant
            values = exact / float(conversion.denominator)
        values[whole == _MISSING[numbers.dtype.itemsize]] = np.nan
        return values

    @property
    def held(self) -> int:
        """Bytes of memory, with those of `ends` if they were needed."""
        ends: tuple[Floats, Floats] | tuple[()] = self.__dict__.get("ends", ())
        return sum(map(_size, (self.numbers, *ends)))

    @cached_property
    def ends(self) -> tuple[Floats, Floats]:
        """The extremes of each block of rows, in their order."""
        blocks = len(self.numbers) // _BLOCK
        first, second = np.empty(blocks), np.empty(blocks)
        for at in range(0, blocks, 1024):
            stop = min(blocks, at + 1024)
            values = self.values(slice(at * _BLOCK, stop * _BLOCK))
            first[at:stop], second[at:stop] = extremes(values, _BLOCK * np.arange(stop - at))
        return first, second


class Windows:
    """The columns of a recording. `rows`: all of it; `conversions`: of its parameters, by name.

    Where times run back (another session) rows are sorted.
    """

    def __init__(self, rows: Iterable[Rows], conversions: Mapping[str, Conversion]) -> None:
        times: list[Floats] = []
        pieces: dict[str, list[_Packed]] = {}
        count = 0
        for stretch in rows:
            times.append(stretch.times)
            is_long, count = count > _SHORT, count + len(stretch.times)
            for name, column in stretch.values.items():
                parts = pieces.setdefault(name, [])
                if count <= _SHORT:
                    parts.append(_Packed(column))
                    continue
                conversion = conversions.get(name)
                if not is_long:
                    parts[:] = [_packed(part.values(), conversion) for part in parts]
                parts.append(_packed(column, conversion))
        self.times: Floats = np.concatenate([np.empty(0), *times])
        order: Index | None = None
        if (np.diff(self.times) < 0).any():
            order = self.times.argsort(kind="stable")
            self.times = self.times[order]
        self._columns = {name: _joined(pieces.pop(name), order) for name in list(pieces)}

    @property
    def held(self) -> int:
        """Bytes of memory that the columns take."""
        return _size(self.times) + sum(column.held for column in self._columns.values())

    def window(
        self, begin: float, end: float, points: int, names: Sequence[str]
    ) -> tuple[Rows, bool]:
        """Return the rows from `begin` to `end`, and whether there were more than `points`."""
        if points < 2:
            raise ValueError("a picture has at least two points")
        if not self.times.size:  # without rows there are no columns
            return Rows(self.times, {name: np.empty(0) for name in names}), False
        first, last = self.times.searchsorted([begin, np.nextafter(end, np.inf)])
        first, last = int(first), int(max(first, last))
        if last - first <= points:
            rows = slice(first, last)
            columns = {name: self._columns[name].values(rows) for name in names}
            return Rows(self.times[rows], columns), False
        return self._decimated(first, last, points // 2, names), True

    def _decimated(self, first: int, last: int, count: int, names: Sequence[str]) -> Rows:
        pieces = Pieces(float(self.times[first]), float(self.times[last - 1]), count)
        by_blocks = last - first >= _ENOUGH * _BLOCK * count
        shown = _Extracted(self.times, first, last, by_blocks=by_blocks)
        return pieces.extremes(
            shown.times,
            pieces.starts(shown.times),
            pieces.starts(self.times[first:last]),
            names,
            lambda name: shown.values(self._columns[name]),
        )


class _Extracted:
    """The rows of a window, or the extremes of its blocks with the single rows on both sides."""

    def __init__(self, times: Floats, first: int, last: int, *, by_blocks: bool) -> None:
        self._first, self._last = first, last
        self._blocks: slice | None = None
        if not by_blocks:
            self.times = times[first:last]
            return
        self._blocks = slice(-(-first // _BLOCK), last // _BLOCK)
        begin, end = self._blocks.start * _BLOCK, self._blocks.stop * _BLOCK
        self._inner = begin, end
        both = _alternating(times[begin:end:_BLOCK], times[begin + _BLOCK - 1 : end : _BLOCK])
        self.times = np.concatenate((times[first:begin], both, times[end:last]))

    def values(self, column: _Packed) -> Floats:
        """Return the column's values at `times`."""
        if self._blocks is None:
            return column.values(slice(self._first, self._last))
        both = _alternating(*(ends[self._blocks] for ends in column.ends))
        before = column.values(slice(self._first, self._inner[0]))
        after = column.values(slice(self._inner[1], self._last))
        return np.concatenate((before, both, after))


def _alternating(ones: Floats, others: Floats) -> Floats:
    """Return the first of both, the second of both …"""
    both = np.empty(2 * ones.size)
    both[::2], both[1::2] = ones, others
    return both


def _size(array: NDArray[np.generic]) -> int:
    """Return its bytes of memory."""
    return int(array.size * array.dtype.itemsize)


def _packed(column: Floats, conversion: Conversion | None) -> _Packed:
    if conversion is None or conversion.size > 2:
        return _Packed(column)
    size = 2 * conversion.size
    missing = np.isnan(column)
    numbers = np.where(missing, 0.0, column)
    if not conversion.is_flag:
        exact = numbers * float(conversion.denominator) - conversion.constant
        numbers = np.rint(exact / conversion.numerator)
    packed = _Packed(np.where(missing, _MISSING[size], numbers).astype(f"i{size}"), conversion)
    return packed if np.array_equal(packed.values(), column, equal_nan=True) else _Packed(column)


def _joined(parts: list[_Packed], order: Index | None) -> _Packed:
    conversion = parts[0].conversion
    if any(part.conversion is not conversion for part in parts):
        parts, conversion = [_Packed(part.values()) for part in parts], None
    numbers = np.concatenate([part.numbers for part in parts])
    return _Packed(numbers if order is None else numbers[order], conversion)
