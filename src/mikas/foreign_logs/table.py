"""A table that another program has recorded: times, columns with their own names and units.

Nothing here knows a channel of ours: a column called `RPM` stays `RPM`, whatever its unit. Values
are plain 64-bit floats; NaN: no value in that row. What could not be read is said in `problems`,
never passed over.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from math import isfinite, nan
from typing import TYPE_CHECKING, Final

from mikas.errors import ForeignLogError, library
from mikas.i18n import Text

if TYPE_CHECKING:
    import pandas as pd

MOST_BYTES: Final = 64 << 20
"""Of a file."""
MOST_CELLS: Final = 12_000_000
"""Rows × columns: 96 MB."""
MOST_COLUMNS: Final = 1000


@dataclass(frozen=True, slots=True)
class ForeignColumn:
    """One column of another program's log."""

    name: str
    """As in the file; a second column of the same name has a number after it."""
    unit: str
    """As in the file, or as the user gave it; empty: none."""
    values: Sequence[float]
    """One for each row; NaN: none."""


@dataclass(frozen=True, slots=True)
class ForeignMark:
    """A mark of another program's log."""

    time: float
    """Seconds, on the clock of the rows."""
    text: str
    """Its words."""


@dataclass(frozen=True, slots=True)
class ForeignProblem:
    """Something in the file that was not taken, and why."""

    text: Text
    """What, how often, and where first."""
    line: int | None = None
    """The first line concerned, from 1; None: the file has no lines, or it concerns all."""


@dataclass(frozen=True, slots=True)
class ForeignLog:
    """Another program's log as a table."""

    name: str
    """The file's name."""
    format: str
    """csv, msl, mlg or mdf."""
    times: Sequence[float]
    """Seconds, never decreasing: as the file counts them, of the day, or from 1970."""
    columns: tuple[ForeignColumn, ...]
    """The columns but the time."""
    started: datetime | None = None
    """The date of the first row, if the file has one; without a zone in the file it is UTC."""
    marks: tuple[ForeignMark, ...] = ()
    """In the order of their times."""
    problems: tuple[ForeignProblem, ...] = ()
    """What was not taken."""

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.times)

    def __getitem__(self, name: str) -> ForeignColumn:
        """Return the column of that name. Raises `KeyError`."""
        for column in self.columns:
            if column.name == name:
                return column
        raise KeyError(name)

    def to_pandas(self) -> pd.DataFrame:
        """Return a `pandas.DataFrame`, its index `time`; units are in `attrs`.

        Raises `MissingExtra` if pandas is not installed.
        """
        pandas = library(
            "pandas",
            feature=Text("A table for pandas", "Таблица для pandas"),
            advice=Text("Install it with: pip install pandas.", "Установите: pip install pandas."),
        )
        index = pandas.Index(list(self.times), name="time")
        columns = {column.name: list(column.values) for column in self.columns}
        frame: pd.DataFrame = pandas.DataFrame(columns, index=index)
        frame.attrs["units"] = {column.name: column.unit for column in self.columns}
        return frame


@dataclass(slots=True)
class TableBuilder:
    """Collects rows for a `ForeignLog`: those without a time, or older than the last, stay out."""

    name: str
    """The file's name, for errors."""
    heads: Sequence[tuple[str, str]]
    """Name and unit of each column."""
    times: array[float] = field(default_factory=lambda: array("d"))
    """Of the rows so far."""
    _values: list[array[float]] = field(default_factory=list)
    _timeless: list[int | None] = field(default_factory=list)
    _older: list[int | None] = field(default_factory=list)

    def __post_init__(self) -> None:
        if len(self.heads) > MOST_COLUMNS:
            raise ForeignLogError(
                self.name,
                Text(
                    f"{len(self.heads)} columns; at most {MOST_COLUMNS} can be taken: choose fewer",
                    f"столбцов {len(self.heads)}, а взять можно не больше {MOST_COLUMNS}: "
                    "выберите меньше",
                ),
            )
        self._values = [array("d") for _ in self.heads]

    def add(self, time: float, values: Iterable[float], line: int | None = None) -> None:
        """Add one row; `line`: where it is in the file. Raises `ForeignLogError` for too many."""
        if not isfinite(time):
            self._timeless.append(line)
            return
        if self.times and time < self.times[-1]:
            self._older.append(line)
            return
        if (len(self.times) + 1) * (len(self.heads) + 1) > MOST_CELLS:
            raise ForeignLogError(
                self.name,
                Text(
                    f"more than {MOST_CELLS:,} values: take fewer columns, or a part of the file",
                    f"больше {MOST_CELLS:,} значений: возьмите меньше столбцов или часть файла",
                ),
                line=line,
            )
        self.times.append(time)
        for column, value in zip(self._values, values, strict=True):
            column.append(value if isfinite(value) else nan)

    def skipped(self) -> list[ForeignProblem]:
        """Return the problems of the rows that were left out."""
        found = []
        for lines, why in ((self._timeless, _TIMELESS), (self._older, _OLDER)):
            if lines:
                first = lines[0]
                where = Text(f", the first in line {first}", f", первая — строка {first}")
                place = Text("", "") if first is None else where
                found.append(ForeignProblem(why.filled(n=str(len(lines)), place=place), first))
        return found

    def columns(self) -> tuple[ForeignColumn, ...]:
        """Return the columns."""
        return tuple(
            ForeignColumn(name, unit, values)
            for (name, unit), values in zip(self.heads, self._values, strict=True)
        )

    def check(self, *, problem: Text | None = None) -> None:
        """Raise `ForeignLogError` if there is no row."""
        if not self.times:
            raise ForeignLogError(self.name, problem or NO_ROWS)


def unique(names: Iterable[str]) -> list[str]:
    """Return the names, all different: the second `RPM` is `RPM (2)`, a nameless column has its
    number.
    """
    last: dict[str, int] = {}  # the number behind the last one of each name
    for number, name in enumerate(names, 1):
        own = name or f"№ {number}"
        more, count = own, last.get(own, 1)
        while more in last:
            count += 1
            more = f"{own} ({count})"
        last[own] = count
        last.setdefault(more, 1)
    return list(last)


def date_of(seconds: float) -> datetime | None:
    """Return the date of a time from 1970; None: beyond any calendar."""
    try:
        return datetime.fromtimestamp(seconds, UTC)
    except (OverflowError, OSError, ValueError):
        return None


def check_size(name: str, data: bytes) -> None:
    """Raise `ForeignLogError` for a file that is empty or too large."""
    if not data:
        raise ForeignLogError(name, Text("the file is empty", "файл пустой"))
    if len(data) > MOST_BYTES:
        raise ForeignLogError(name, TOO_LARGE)


TOO_LARGE: Final = Text(
    f"larger than {MOST_BYTES >> 20} MiB: save a part of the log as a file of its own",
    f"больше {MOST_BYTES >> 20} МиБ: сохраните часть лога отдельным файлом",
)
NO_ROWS: Final = Text(
    "there is no row with a time: choose another column as the time, or another unit for it",
    "нет ни одной строки со временем: выберите другой столбец времени или другую его единицу",
)
_TIMELESS: Final = Text(
    "rows without a time, left out: {n}{place}", "строки без времени, пропущены: {n}{place}"
)
_OLDER: Final = Text(
    "rows older than the one before, left out: {n}{place} (a second run in the same file?)",
    "строки, у которых время идёт назад, пропущены: {n}{place} (второй заезд в том же файле?)",
)
