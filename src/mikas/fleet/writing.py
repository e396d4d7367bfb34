"""Parquet files of one recording, by duckdb: a file for each table and day.

Samples are collected in a database beside the files, as an export is, so memory stays bounded.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime, timedelta
from math import floor
from pathlib import Path
from typing import Any, Final

import numpy as np

from mikas.cancellation import check_cancelled
from mikas.errors import CaptureError
from mikas.fleet.tables import SMALL
from mikas.i18n import Text
from mikas.recording.export.sheet import BATCH
from mikas.recording.parquet import ParquetTable, quoted
from mikas.recording.table.channels import PLAINLY_UNIX, Channel, Rows, calendar

_MOST_PARAMETERS: Final = 20_000  # of one statement
DAY: Final = 86_400.0
MOST_DAYS: Final = 100
_TOO_MANY: Final = Text(
    "its times lie on more than {most} days: the clock is damaged",
    "время в ней приходится больше чем на {most} дней: часы повреждены",
).filled(most=MOST_DAYS)


def day_of(time: float | None) -> str | None:
    """Return the day of a time of the link's clock, in UTC; None without a calendar."""
    date = None if time is None else calendar(time)
    return None if date is None else f"{date:%Y-%m-%d}"


class TableWriter(ParquetTable):
    """Collects the rows of a recording and writes its files into `folder`, named by table and day.

    Raises `OSError` for a full disk, `CaptureError` for times on very many days.
    """

    def __init__(self, folder: Path, channels: Sequence[Channel]) -> None:
        super().__init__(folder, ["drive", "time", "clock"], channels, BATCH)
        self._folder = folder
        self._days: set[int | None] = set()
        self._rows: dict[str, dict[str | None, list[tuple[object, ...]]]] = {
            name: {} for name in SMALL
        }

    def add_samples(self, drive: int, rows: Rows, zero: float) -> None:
        """Add rows of a drive; `zero`: the time that counts as 0."""
        for begin in range(0, len(rows.times), BATCH):
            check_cancelled()
            times = rows.times[begin : begin + BATCH]
            dated = np.array([calendar(float(times.min())), calendar(float(times.max()))])
            at = np.where(times >= PLAINLY_UNIX, times, np.nan) if all(dated) else _dated(times)
            self._days |= {
                None if np.isnan(day) else int(day) for day in np.unique(np.floor(at / DAY))
            }
            self._check(len(self._days))
            columns = (rows.values[each.name][begin : begin + BATCH] for each in self._channels)
            self.add((drive, times - zero, at, *columns), len(times))

    def add_row(self, table: str, time: float | None, row: Mapping[str, object]) -> None:
        """Add a row to a small table; `time` decides on its day."""
        known = tuple(row[column] for column in SMALL[table])
        self._rows[table].setdefault(day_of(time), []).append(known)
        self._check(len(self._rows[table]))

    def _check(self, days: int) -> None:
        """Raise `CaptureError` for more days than a recording has: each is a file of its own."""
        if days > MOST_DAYS:
            raise CaptureError("", _TOO_MANY)

    def write(
        self, drives: Sequence[str], facts: Mapping[str, Any]
    ) -> Iterator[tuple[str, str | None, Path]]:
        """Yield (table, day, file) for each file. `drives`: by number; `facts`: its metadata."""
        text = json.dumps(facts, ensure_ascii=False)
        selected = ", ".join(self._selected(drives))
        count = 0
        for number in sorted(self._days, key=lambda day: (day is None, day or 0)):
            file = self._folder / f"{count}.parquet"
            count += 1
            where = "clock IS NULL" if number is None else f"floor(clock / {DAY}) = {number}"
            self.copy(f"SELECT {selected} FROM collected WHERE {where}", file, text)
            yield "samples", day_of(None if number is None else number * DAY), file
        for table, days in self._rows.items():
            columns = SMALL[table]
            for day, rows in days.items():
                file = self._folder / f"{count}.parquet"
                count += 1
                listed = ", ".join(f"{name} {kind}" for name, kind in columns.items())
                self.database.execute(f"CREATE OR REPLACE TEMP TABLE small ({listed})")
                for piece in _pieces(rows, len(columns)):
                    row = f"({', '.join('?' * len(columns))})"
                    self.database.execute(
                        f"INSERT INTO small VALUES {', '.join([row] * len(piece))}",
                        [value for values in piece for value in values],
                    )
                self.copy("SELECT * FROM small", file, text)
                yield table, day, file

    def _selected(self, drives: Sequence[str]) -> Iterator[str]:
        listed = ", ".join(map(quoted, drives))
        yield f"list_extract([{listed}], drive::INTEGER + 1) AS drive"
        yield "time"
        yield "make_timestamp(round(clock * 1000000)::BIGINT) AS utc"
        yield from self.channel_columns()


def _dated(times: np.ndarray[Any, np.dtype[np.float64]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the times that have a date, NaN for the others."""
    return np.array([time if calendar(time) else np.nan for time in times.tolist()])


def _pieces(rows: list[tuple[object, ...]], width: int) -> Iterable[list[tuple[object, ...]]]:
    most = max(1, _MOST_PARAMETERS // width)
    return (rows[at : at + most] for at in range(0, len(rows), most))


def timestamp(time: float | None) -> datetime | None:
    """Return the time as a TIMESTAMP in UTC; None without a calendar."""
    if time is None or calendar(time) is None:
        return None
    return datetime(1970, 1, 1, tzinfo=UTC).replace(tzinfo=None) + timedelta(
        microseconds=floor(time * 1e6 + 0.5)  # as duckdb rounds
    )
