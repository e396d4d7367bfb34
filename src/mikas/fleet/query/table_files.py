"""The Parquet files of a dataset, before they are read: which are not what our tables are.

duckdb reads all files of a table as one, so a single one that is damaged, or has a column of
another type, would cost all others. Only the ends of the files are read here.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import duckdb

from mikas.fleet.tables import LATER, PARTITIONS, TABLES
from mikas.i18n import Text
from mikas.recording.parquet import quoted

if TYPE_CHECKING:
    from mikas.fleet.entries import LedgerEntry
    from mikas.fleet.ledger import Ledger

_MOST_COLUMNS: Final = 2000  # a catalog has some hundred
_MOST_ROWS: Final = 8  # for each byte of a file; ours have less than one
_EXTRA: Final = frozenset(("DOUBLE", "BOOLEAN"))  # types of a channel
_UNREADABLE: Final = Text(
    "{name}: the file is damaged, or no Parquet file; remove it, and `mikas fleet add` makes it "
    "anew from its recording",
    "{name}: файл повреждён или это не Parquet; удалите его, и `mikas fleet add` создаст его "
    "заново из записи",
)
_NOT_OURS: Final = Text(
    "{name}: the file is none of mikas ({what})", "{name}: файл создан не программой mikas ({what})"
)
_ROWS: Final = Text("{rows} rows in {bytes} bytes", "строк: {rows}, байт: {bytes}")
_COLUMN: Final = Text("column {column}", "столбец {column}")

_VIEWS: Final = """
SELECT table_name, column_name, data_type FROM duckdb_columns() WHERE NOT internal
ORDER BY table_name, column_index
"""
_SCHEMAS: Final = """
SELECT columns, list(file_name) FROM (
    SELECT file_name,
        list(row(name, duckdb_type, repetition_type, num_children) ORDER BY number) AS columns
    FROM (FROM parquet_schema([{files}]) SELECT *, row_number() OVER () AS number)
    GROUP BY file_name
) GROUP BY columns
"""
_LONG: Final = """
SELECT file_name, num_rows, file_size_bytes FROM parquet_file_metadata([{files}])
WHERE num_rows NOT BETWEEN 0 AND {each} * file_size_bytes
"""


def other_files(
    connection: duckdb.DuckDBPyConnection, root: str, ledger: Ledger
) -> dict[str, Text]:
    """Return the names of files that are none of our tables, and why. `root`: before names."""
    return _others(connection, root, [*ledger.entries.values()])


def look_sound(connection: duckdb.DuckDBPyConnection) -> bool:
    """Return whether the views of the tables have our columns."""
    columns: dict[str, list[tuple[str, str, None, None]]] = {table: [] for table in TABLES}
    for table, name, kind in connection.execute(_VIEWS).fetchall():
        columns[table].append((name, kind, None, None))
    return all(
        _wrong(table, of_table[len(PARTITIONS) :]) is None for table, of_table in columns.items()
    )


def most_rows(ledger: Ledger) -> int:
    """Return how many rows the tables of a dataset can have."""
    return _MOST_ROWS * sum(ledger.sizes[it] for e in ledger.entries.values() for it in e.files)


def long_files(connection: duckdb.DuckDBPyConnection, root: str, ledger: Ledger) -> dict[str, Text]:
    """Return the names of files of more rows than their size allows, and why not."""
    found: dict[str, Text] = {}
    if files := _listed(root, ledger.entries.values()):
        question = _LONG.format(files=files, each=_MOST_ROWS)
        for file, rows, size in connection.execute(question).fetchall():
            name = file.removeprefix(root)
            found[name] = _NOT_OURS.filled(name=name, what=_ROWS.filled(rows=rows, bytes=size))
    return found


def refuse_files(ledger: Ledger, files: Mapping[str, Text]) -> None:
    """Let no entry count that names one of these files."""
    for entry in list(ledger.entries.values()) if files else ():
        if (name := next((it for it in entry.files if it in files), None)) is not None:
            ledger.refuse(entry, files[name])


def _others(
    connection: duckdb.DuckDBPyConnection, root: str, entries: Sequence[LedgerEntry]
) -> dict[str, Text]:
    """Return the names of files that are none of our tables, and why."""
    files = _listed(root, entries)
    try:
        schemas = connection.execute(_SCHEMAS.format(files=files)).fetchall() if files else []
    except duckdb.Error:  # one that can't be read hides all others
        if len(entries) > 1:
            half = len(entries) // 2
            halves = (entries[:half], entries[half:])
            return {
                name: why for it in halves for name, why in _others(connection, root, it).items()
            }
        return dict(_damaged(connection, root, entries[0]))
    found = {}
    for columns, names in schemas:
        for file in names:
            name = file.removeprefix(root)
            if (column := _wrong(name.partition("/")[0], columns[1:])) is not None:
                what = _COLUMN.filled(column=column[:100])
                found[name] = _NOT_OURS.filled(name=name, what=what)
    return found


def _damaged(
    connection: duckdb.DuckDBPyConnection, root: str, entry: LedgerEntry
) -> Iterator[tuple[str, Text]]:
    for name in entry.files:
        try:
            connection.execute(_SCHEMAS.format(files=quoted(f"{root}{name}"))).fetchall()
        except duckdb.Error:
            yield name, _UNREADABLE.filled(name=name)


def _listed(root: str, entries: Iterable[LedgerEntry]) -> str:
    return ", ".join(quoted(f"{root}{name}") for entry in entries for name in entry.files)


def _wrong(table: str, columns: Sequence[Sequence[Any]]) -> str | None:
    """Return the name of the first column that a table of ours can't have; None: there is none."""
    ours = TABLES[table]
    seen = {name.casefold() for name in PARTITIONS}
    for number, (name, kind, repetition, children) in enumerate(columns):
        known = name.casefold() in seen or number >= _MOST_COLUMNS
        fits = kind == ours[name] if name in ours else table == "samples" and kind in _EXTRA
        if known or not fits or children is not None or repetition == "REPEATED":
            return str(name)
        seen.add(name.casefold())
    earlier = LATER.get(table, frozenset())
    return next((name for name in ours if name not in seen and name not in earlier), None)
