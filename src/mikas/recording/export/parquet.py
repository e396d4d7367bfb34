"""Parquet, by duckdb: `time` in seconds, a DOUBLE a channel, a BOOLEAN a flag, missing as NULL.

Units, texts and events have no place in a Parquet column, so they are in the file's own metadata,
as JSON under the key `mikas`. Rows are collected in a duckdb database next to OUT, which packs them
at once, and copied from there: memory stays bounded, and it is faster than a table in memory.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import duckdb
import numpy as np

from mikas.recording.export.sheet import Sheet, program

_MEMORY = "256MB"
_THREADS = 2  # each holds a row group; more gain little with so few columns
_GROUP = 122_880  # rows, duckdb's own choice
_VECTOR = 2_048  # rows; a group is a multiple


def write(path: Path, sheet: Sheet) -> None:
    """Write the whole sheet."""
    with TemporaryDirectory(dir=path.parent, prefix=f"{path.name}.") as folder:
        try:
            with connect(Path(folder)) as database:
                _collect(database, sheet)
                database.execute(_copy_statement(path, sheet))
        except (duckdb.OperationalError, duckdb.FatalException) as error:  # a disk error
            raise system_error(error) from error


def connect(folder: Path) -> duckdb.DuckDBPyConnection:
    """Return a database in `folder`, of bounded memory."""
    return duckdb.connect(
        str(folder / "rows.db"),
        config={
            "memory_limit": _MEMORY,
            "temp_directory": str(folder / "spilt"),
            "threads": str(_THREADS),
        },
    )


def _collect(database: duckdb.DuckDBPyConnection, sheet: Sheet) -> None:
    """Insert all rows into one table, never committed: the database is deleted and needs no log.

    One array is registered and refilled: a transaction keeps every registered array alive.
    """
    names = ["time", *(f"c{number}" for number in range(len(sheet.channels)))]
    batch = {name: np.empty(sheet.batches.longest) for name in names}
    database.execute("SET enable_progress_bar = false")
    database.register("batch", batch)
    database.execute("BEGIN")
    database.execute(f"CREATE TABLE collected ({', '.join(f'{name} DOUBLE' for name in names)})")
    present = ", ".join(f"nullif({name}, 'nan'::DOUBLE)" for name in names)
    for times, values in sheet.batches:
        for column, filled in zip(batch.values(), (times, *values), strict=True):
            column[: len(times)] = filled
        database.execute(f"INSERT INTO collected SELECT {present} FROM batch LIMIT {len(times)}")


def _copy_statement(path: Path, sheet: Sheet) -> str:
    rows = min(_GROUP, 4_000_000 // (len(sheet.channels) + 1)) // _VECTOR * _VECTOR
    return (
        f"COPY (SELECT {', '.join(_selected(sheet))} FROM collected) TO {quoted(str(path))} "
        f"(FORMAT parquet, COMPRESSION zstd, ROW_GROUP_SIZE {max(rows, _VECTOR)}, "
        f"KV_METADATA {{mikas: {quoted(_metadata(sheet))}}})"
    )


def _selected(sheet: Sheet) -> Iterator[str]:
    yield "time"
    for number, channel in enumerate(sheet.channels):
        value = f"c{number} <> 0" if channel.is_flag else f"c{number}"
        name = channel.name.replace('"', '""')
        yield f'{value} AS "{name}"'


def _metadata(sheet: Sheet) -> str:
    started = None if sheet.started is None else sheet.started.isoformat()
    facts = {
        "program": program(),
        "started": started,
        "about": dict(sheet.about),
        "time": {"unit": "s", "en": "Time since the start", "ru": "Время от начала"},
        "channels": {channel.name: channel.facts() for channel in sheet.channels},
        "events": [moment.as_json() for moment in sheet.moments],
    }
    return json.dumps(facts, ensure_ascii=False)


def system_error(error: duckdb.Error) -> OSError:
    """Return the system's error; its number is in the text of duckdb's."""
    if found := re.search(r'"errno":"(\d+)"', str(error)):
        number = int(found[1])
        return OSError(number, os.strerror(number))
    return OSError(str(error).partition("\n")[0])


def quoted(value: str) -> str:
    """Return a text as SQL writes it."""
    return "'" + value.replace("'", "''") + "'"
