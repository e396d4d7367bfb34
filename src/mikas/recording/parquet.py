"""Columns of numbers to Parquet files, by duckdb: for an export, and for the tables of a fleet.

Rows are collected in a duckdb database next to the files, which packs them at once, and copied from
there: memory stays bounded, and it is faster than a table in memory. A missing value is NULL, a
flag a BOOLEAN.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final, Self

import duckdb
import numpy as np

from mikas.errors import refused_number
from mikas.files import utf_8
from mikas.recording.table.channels import Channel

if TYPE_CHECKING:
    from types import TracebackType

    from numpy.typing import NDArray

_MEMORY: Final = "256MB"
_THREADS: Final = 2  # each holds a row group; more gain little with so few columns


class ParquetTable:
    """Rows in a database in `folder`: numbers by the names `before`, then those of the channels.

    At most `longest` rows are added at once. Raises `OSError` for an error of the disk.
    """

    def __init__(
        self, folder: Path, before: Sequence[str], channels: Sequence[Channel], longest: int
    ) -> None:
        self._channels = channels
        with _disk_errors():
            self.database: duckdb.DuckDBPyConnection = duckdb.connect(
                utf_8(folder / "rows.db"),
                config={
                    "memory_limit": _MEMORY,
                    "temp_directory": utf_8(folder / "spilt"),
                    "threads": str(_THREADS),
                },
            )
        names = [*before, *(f"c{number}" for number in range(len(channels)))]
        # One array is registered and refilled: a transaction keeps every registered array alive.
        self._batch = {name: np.empty(longest) for name in names}
        self.database.execute("SET enable_progress_bar = false")
        self.database.register("batch", self._batch)
        self.database.execute("BEGIN")  # never committed: it is deleted, and needs no log
        self.database.execute(
            f"CREATE TABLE collected ({', '.join(f'{name} DOUBLE' for name in names)})"
        )
        present = ", ".join(f"nullif({name}, 'nan'::DOUBLE)" for name in names)
        self._insert = f"INSERT INTO collected SELECT {present} FROM batch LIMIT "

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self.database.close()
        if error is not None:
            with _disk_errors():
                raise error

    def add(self, columns: Iterable[NDArray[np.float64] | float], count: int) -> None:
        """Add `count` rows: a column of each name in their order, or the number of all rows."""
        for place, column in zip(self._batch.values(), columns, strict=True):
            place[:count] = column
        self.database.execute(f"{self._insert}{count}")

    def channel_columns(self) -> Iterator[str]:
        """Yield the channels as a SELECT lists them."""
        for number, channel in enumerate(self._channels):
            value = f"c{number} <> 0" if channel.is_flag else f"c{number}"
            name = channel.name.replace('"', '""')
            yield f'{value} AS "{name}"'

    def copy(self, query: str, path: Path, facts: str, *options: str) -> None:
        """Write what a query finds to `path`. `facts`: JSON, the file's metadata `mikas`."""
        metadata = f"KV_METADATA {{mikas: {quoted(facts)}}}"
        listed = ", ".join(("FORMAT parquet", "COMPRESSION zstd", *options, metadata))
        self.database.execute(f"COPY ({query}) TO {quoted(utf_8(path))} ({listed})")


def quoted(value: str) -> str:
    """Return a text as SQL writes it."""
    return "'" + value.replace("'", "''") + "'"


@contextmanager
def _disk_errors() -> Iterator[None]:
    """Raise the system's error for an error of the disk; its number is in the text of duckdb's."""
    try:
        yield
    except (duckdb.OperationalError, duckdb.FatalException) as error:
        if (number := refused_number(error)) is not None:
            raise OSError(number, os.strerror(number)) from error
        raise OSError(str(error).partition("\n")[0]) from error
