"""A dataset in a database that can only read it: a view for each table.

    database ──► views drives, samples … ──► the files that the ledger counts, and no other file

duckdb reads through a file system of ours (`table_system`): what it reads by itself it may also
write (`allowed_paths`, and its folder for spilt rows). A URL needs no extension of duckdb so. After
the views are made the configuration is locked: no other file, no network, no extension, no change
of a setting. `questions` says which SQL is a question. The database itself is in memory, and is
dropped; nothing is spilt to a disk.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, wait
from contextlib import AbstractContextManager, closing, contextmanager, suppress
from typing import Any, Final, NamedTuple, TypeVar

import duckdb

from mikas.errors import FleetError, UsageError, usage_error
from mikas.files import allow_open, open_files
from mikas.fleet.ledger import Ledger, open_ledger
from mikas.fleet.places import is_utf_8, shown
from mikas.fleet.query.memory import memory_limit, too_much_memory
from mikas.fleet.query.questions import is_question
from mikas.fleet.query.table_files import (
    long_files,
    look_sound,
    most_rows,
    other_files,
    refuse_files,
)
from mikas.fleet.query.table_system import NO_TABLE, PROTOCOL, DatasetFileSystem
from mikas.fleet.stores import Store, store
from mikas.fleet.tables import LATER, PARTITIONS, TABLES
from mikas.i18n import Text
from mikas.recording.parquet import quoted

T = TypeVar("T")

_ROOT: Final = f"{PROTOCOL}://"
_WAIT: Final = 0.2  # s
_IN_PYTHON: Final = re.compile(
    r"Traceback \(most recent.*\b(?:\w+Error|UnfitFile): (?:\[Errno \d+\] )?", re.DOTALL
)
_FILE: Final = re.compile(
    rf"bytes outside file: |File '[^']+\.parquet'|{_IN_PYTHON.pattern}", re.DOTALL
)  # unreadable
_ZONE: Final = "'pytz'"  # which Python needs for a time with a zone
_SPARE: Final = 200  # open files
_AT_ONCE: Final = 10_000  # rows
_SETTINGS: Final = (
    "enable_progress_bar = false",
    "TimeZone = 'UTC'",  # else `utc > now()` compares with the local time
    "python_enable_replacements = false",
    "http_proxy = ''",  # of the environment, maybe with a password, which settings show
    "secret_directory = ''",
    "temp_directory = ''",  # it would be a place that a statement may write to
    f"allowed_directories = [{quoted(_ROOT)}]",
    "enable_external_access = false",
)


class Database:
    """The views of a dataset, read-only. Not for two threads at a time.

    `ledger.refused`: what of the dataset is left out, and why.
    """

    def __init__(self, dataset: str) -> None:
        files = store(dataset)
        self._place = shown(files.place)
        while True:
            self.ledger: Ledger = open_ledger(files)
            known = set(self.ledger.entries)  # before any of them is refused
            tables = sum(len(it.files) for it in self.ledger.entries.values())
            allow_open(open_files() + tables + _SPARE)
            self._connection = duckdb.connect(
                config={
                    "autoload_known_extensions": "false",
                    "autoinstall_known_extensions": "false",
                    "memory_limit": f"{memory_limit() >> 20}MiB",
                }
            )
            try:
                self._run(lambda: self._prepare(files))
            except duckdb.Error as error:
                self.close()
                if set(open_ledger(files).entries) == known:
                    raise _unreadable(self._place, error) from error
            except BaseException:
                self.close()
                raise
            else:
                return

    def close(self) -> None:
        """Drop the database."""
        with suppress(duckdb.Error):
            self._connection.unregister_filesystem(PROTOCOL)
        self._connection.close()

    def ask(self, sql: str) -> QueryRows:
        """Return the answer to one SELECT, DESCRIBE, SUMMARIZE or EXPLAIN. Raises `UsageError`;
        `FleetError` for a file of the dataset that can't be read.
        """
        if not is_utf_8(sql):
            raise usage_error("SQL: the text is not UTF-8", "SQL: текст не в UTF-8")
        with self._errors_of(sql):
            is_asked = self._run(lambda: is_question(self._connection, sql))
        if not is_asked:
            raise usage_error(
                "a dataset is only read: one SELECT, DESCRIBE, SUMMARIZE or EXPLAIN at a time",
                "набор можно только читать: один запрос SELECT, DESCRIBE, SUMMARIZE или EXPLAIN",
            )
        with self._errors_of(sql):
            first = self._run(lambda: self._begin(sql, most=_AT_ONCE))
            names = [column[0] for column in self._connection.description or ()]
        return QueryRows(names, self._answers(sql, first))

    def _answers(self, sql: str, rows: list[tuple[Any, ...]]) -> Iterator[tuple[Any, ...]]:
        while rows:
            yield from rows
            with self._errors_of(sql):
                rows = self._run(lambda: self._connection.fetchmany(_AT_ONCE))

    def rows(self, sql: str, *values: object) -> list[tuple[Any, ...]]:
        """Return all rows of a question of the program's own. Raises `FleetError`."""
        try:
            most = most_rows(self.ledger) + 1
            rows = self._run(lambda: self._begin(sql, *values, most=most))
            if len(rows) == most and self._run(self._refuse_unsound):
                rows = self._run(lambda: self._begin(sql, *values, most=most))
        except duckdb.Error as error:
            raise _unreadable(self._place, error) from error
        return rows

    @contextmanager
    def _errors_of(self, sql: str) -> Iterator[None]:
        """Raise a duckdb error as a `UsageError` with its place in `sql`; as a `FleetError`, if a
        file can't be read.
        """
        try:
            yield
        except duckdb.Error as error:
            text = str(error)
            if isinstance(error, duckdb.OutOfMemoryException):
                raise too_much_memory() from error
            if NO_TABLE in text:
                raise _wrong(sql, error) from error
            if isinstance(error, duckdb.IOException) or (_FILE.search(text) and _ZONE not in text):
                raise _unreadable(self._place, error) from error
            raise _wrong(sql, error) from error

    def _run(self, work: Callable[[], T]) -> T:
        """Do it in a thread, as duckdb does not notice Ctrl-C."""
        done: Future[T] = Future()

        def run() -> None:
            try:
                done.set_result(work())
            except BaseException as error:  # raised below
                done.set_exception(error)

        thread = threading.Thread(target=run)
        try:
            thread.start()
            while not done.done():  # a wait without an end can't be interrupted everywhere
                wait([done], _WAIT)
        finally:
            while thread.ident and not done.done():  # until it is heard: it may only begin now
                self._connection.interrupt()
                wait([done], _WAIT)
        return done.result()

    def _prepare(self, files: Store) -> None:
        run = self._connection.execute
        sizes = self.ledger.sizes
        listed = {it: sizes[it] for entry in self.ledger.entries.values() for it in entry.files}
        self._tables = DatasetFileSystem(files, listed)
        self._connection.register_filesystem(self._tables)
        for setting in _SETTINGS:
            run(f"SET {setting}")
        run("SET parquet_metadata_cache = true")  # each question would read the ends of all files
        try:
            self._make_views()
            is_sound = look_sound(self._connection)
        except duckdb.Error:
            is_sound = False
        if not is_sound:
            self._refuse_unsound()
        run("SET lock_configuration = true")

    def _refuse_unsound(self) -> bool:
        """Look at each file, and let no entry count with one that is not sound; return whether
        there is one. Raises `FleetError` if the place fails: that says nothing of a file.
        """
        before = len(self.ledger.refused)
        for look in (other_files, long_files):
            self._tables.failures.clear()
            found = look(self._connection, _ROOT, self.ledger)
            self._tables.raise_failure()
            refuse_files(self.ledger, found)
        self._make_views()
        return len(self.ledger.refused) > before

    def _begin(self, sql: str, *values: object, most: int) -> list[tuple[Any, ...]]:
        """Execute a question and return its first rows; once more without a file by which it fails.

        Raises `duckdb.Error`, `FleetError`.
        """
        try:
            rows = self._connection.execute(sql, list(values)).fetchmany(most)
        except duckdb.Error as error:
            if _ROOT not in str(error) or not self._refuse_unsound():
                raise
            rows = self._connection.execute(sql, list(values)).fetchmany(most)
        return rows

    def _make_views(self) -> None:
        run = self._connection.execute
        named: dict[str, list[str]] = {table: [] for table in TABLES}
        for entry in self.ledger.entries.values():
            for name in entry.files:
                named[name.partition("/")[0]].append(f"{_ROOT}{name}")
        types = ", ".join(f"{quoted(name)}: {kind}" for name, kind in PARTITIONS.items())
        for table, names in named.items():
            if names:
                listed = ", ".join(map(quoted, sorted(names)))
                read = (
                    f"read_parquet([{listed}], union_by_name = true, hive_partitioning = true, "
                    f"hive_types = {{{types}}})"
                )
                absent = self._absent(table, read)
                run(
                    f"CREATE OR REPLACE VIEW {table} AS SELECT car, day, * EXCLUDE (car, day)"
                    f"{absent} FROM {read}"
                )
            else:
                columns = {**PARTITIONS, **TABLES[table]}
                nulls = ", ".join(f"NULL::{kind} AS {name}" for name, kind in columns.items())
                run(f"CREATE OR REPLACE VIEW {table} AS SELECT {nulls} WHERE false")

    def _absent(self, table: str, read: str) -> str:
        """Return, as SQL, the later columns of a table that all its files lack."""
        if table not in LATER:
            return ""
        described = self._connection.execute(f"DESCRIBE SELECT * FROM {read}").fetchall()
        there = {row[0].casefold() for row in described}
        return "".join(
            f", NULL::{kind} AS {name}"
            for name, kind in TABLES[table].items()
            if name in LATER[table] and name not in there
        )


class QueryRows(NamedTuple):
    """An answer. `rows` are read as they are needed; they raise `UsageError` for a value that can't
    be computed, and `FleetError`.
    """

    columns: list[str]
    rows: Iterator[tuple[Any, ...]]


def opened(dataset: str) -> AbstractContextManager[Database]:
    """Open a dataset for questions. Raises `FleetError`, `MissingExtra`."""
    return closing(Database(dataset))


_PLACE: Final = re.compile(r"\n\nLINE (\d+): (.*)\n( *)\^", re.DOTALL)
_RESERVED: Final = re.compile(r"""(?<!["\w])lambda(?!["\w])""", re.IGNORECASE)
"""A channel of λ meters whose name duckdb takes for the beginning of a function."""
_KIND: Final = re.compile(r"^[A-Z][A-Za-z]+(?: [A-Za-z]+)? Error: ")


def _wrong(sql: str, error: duckdb.Error) -> UsageError:
    """Return an error of SQL with its place."""
    if _ZONE in str(error):
        return usage_error(
            "SQL: a time with a time zone can't be printed; convert it, as in now()::TIMESTAMP",
            "SQL: время с часовым поясом вывести нельзя; преобразуйте его: now()::TIMESTAMP",
        )
    words = _words(error)
    if "file system operations are disabled" in words:
        words = words.partition(" - ")[0]
    where = _place(str(error), sql)
    en, ru = "", ""
    if where:
        en = f", line {where[0]}, column {where[1]}" if "\n" in sql else f", column {where[1]}"
        ru = f", строка {where[0]}, знак {where[1]}" if "\n" in sql else f", знак {where[1]}"
    if "syntax error" in words and (channel := _RESERVED.search(sql)):
        name = f'"{channel[0]}"'
        return usage_error(
            f"SQL{en}: {words}. {channel[0]} is a word of SQL, too: write the channel as {name}",
            f"SQL{ru}: {words}. {channel[0]} — это и слово SQL: пишите канал как {name}",
        )
    return usage_error(f"SQL{en}: {words}", f"SQL{ru}: {words}")


def _unreadable(place: str, error: duckdb.Error) -> FleetError:
    words = _words(error).rstrip(".")
    return FleetError(
        place,
        Text(
            f"a file of it can't be read: {words}. Remove a damaged file: `mikas fleet add` makes "
            "it anew from its recording",
            f"файл набора не читается: {words}. Повреждённый файл удалите: `mikas fleet add` "
            "создаст его заново из записи",
        ),
    )


def _words(error: duckdb.Error) -> str:
    words = _KIND.sub("", _PLACE.split(str(error))[0])
    return _IN_PYTHON.sub("", words).strip().replace("\n", " ")


def _place(text: str, sql: str) -> tuple[int, int] | None:
    """Return line and column of an error, from 1."""
    found = _PLACE.search(text)
    if found is None:
        return None
    number, shown, spaces = int(found[1]), found[2].split("\n")[0], found[3]
    lines = sql.split("\n")
    column = len(spaces) - len(f"LINE {number}: ")
    whole = lines[number - 1] if number <= len(lines) else ""
    if shown.startswith("..."):  # a long line: only a part of it is shown
        part = shown.strip(".")
        column += whole.find(part) - 3
    return (number, column + 1) if 0 <= column <= len(whole) else None
