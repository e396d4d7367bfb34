"""A dataset in a database that can only read it: a view for each table.

    database ──► views drives, samples … ──► the files that the ledger counts, and no other file

duckdb reads a folder by itself. A URL it reads through fsspec, so that no extension of duckdb is
downloaded. After the views are made the configuration is locked: no other file, no network, no
extension, no change of a setting. The database itself is in memory, and is dropped.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, wait
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext, suppress
from datetime import UTC, datetime
from io import BytesIO
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeVar

import duckdb

from mikas.errors import FleetError, UsageError, usage_error
from mikas.files import allow_open
from mikas.fleet.ledger import Ledger, open_ledger
from mikas.fleet.places import is_utf_8, shown
from mikas.fleet.stores import DiskStore, Store, UrlStore, store
from mikas.fleet.tables import PARTITIONS, TABLES
from mikas.i18n import Text
from mikas.recording.parquet import quoted

if TYPE_CHECKING:
    from fsspec import AbstractFileSystem

T = TypeVar("T")

_PROTOCOL: Final = "dataset"
_MEMORY: Final = "1GB"
_WAIT: Final = 0.2  # s
_MISREAD: Final = re.compile(r"[*?\[\]{}=]")  # of a folder: as a pattern, or as another car or day
_EXPLAIN: Final = re.compile(r"EXPLAIN\s+(?:ANALYZE\s+)?(?:\([^)]*\)\s*)?", re.IGNORECASE)
_IN_PYTHON: Final = re.compile(r"Traceback \(most recent.*\b\w+Error: ", re.DOTALL)
_FILE: Final = re.compile(rf"File '[^']+\.parquet'|{_IN_PYTHON.pattern}", re.DOTALL)  # unreadable
_ZONE: Final = "'pytz'"  # which Python needs for a time with a zone
_SPARE: Final = 200  # open files
_AT_ONCE: Final = 10_000  # rows


class Database:
    """The views of a dataset, read-only. Not for two threads at a time."""

    def __init__(self, dataset: str) -> None:
        files = store(dataset)
        self._place = shown(files.place)
        while True:
            self.ledger: Ledger = open_ledger(files)
            allow_open(_SPARE + sum(len(it.files) for it in self.ledger.entries.values()))
            self._connection = duckdb.connect(
                config={
                    "autoload_known_extensions": "false",
                    "autoinstall_known_extensions": "false",
                    "memory_limit": _MEMORY,
                }
            )
            try:
                self._run(lambda: self._prepare(files))
            except duckdb.Error as error:
                self.close()
                if open_ledger(files).entries.keys() == self.ledger.entries.keys():
                    raise _unreadable(self._place, error) from error
            except BaseException:
                self.close()
                raise
            else:
                return

    def close(self) -> None:
        """Drop the database."""
        with suppress(duckdb.Error):
            self._connection.unregister_filesystem(_PROTOCOL)
        self._connection.close()

    def ask(self, sql: str) -> QueryRows:
        """Return the answer to one SELECT, DESCRIBE, SUMMARIZE or EXPLAIN. Raises `UsageError`;
        `FleetError` for a file of the dataset that can't be read.
        """
        if not is_utf_8(sql):
            raise usage_error("SQL: the text is not UTF-8", "SQL: текст не в UTF-8")
        with self._errors_of(sql):
            is_question = self._run(lambda: self._is_question(sql))
        if not is_question:
            raise usage_error(
                "a dataset is only read: one SELECT, DESCRIBE, SUMMARIZE or EXPLAIN at a time",
                "набор можно только читать: один запрос SELECT, DESCRIBE, SUMMARIZE или EXPLAIN",
            )
        with self._errors_of(sql):
            self._run(lambda: self._connection.execute(sql))
            names = [column[0] for column in self._connection.description or ()]
        return QueryRows(names, self._answers(sql))

    def _answers(self, sql: str) -> Iterator[tuple[Any, ...]]:
        rows: list[tuple[Any, ...]] = [()]
        while rows:
            with self._errors_of(sql):
                rows = self._run(lambda: self._connection.fetchmany(_AT_ONCE))
            yield from rows

    def rows(self, sql: str, *values: object) -> list[tuple[Any, ...]]:
        """Return all rows of a question of the program's own. Raises `FleetError`."""
        try:
            rows: list[tuple[Any, ...]] = self._run(
                lambda: self._connection.execute(sql, list(values)).fetchall()
            )
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
            if isinstance(error, duckdb.IOException) or (_FILE.search(text) and _ZONE not in text):
                raise _unreadable(self._place, error) from error
            raise _wrong(sql, error) from error

    def _is_question(self, sql: str) -> bool:
        """Return whether it is one statement that only reads: EXPLAIN ANALYZE executes another."""
        statements = self._connection.extract_statements(sql)
        if len(statements) != 1:
            return False
        (statement,) = statements
        if statement.type == duckdb.StatementType.EXPLAIN:
            inner, count = _EXPLAIN.subn("", statement.query.strip(), count=1)
            (statement,) = self._connection.extract_statements(inner) if count else statements
        return bool(statement.type == duckdb.StatementType.SELECT)

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
        by_url = not isinstance(files, DiskStore) or bool(_MISREAD.search(str(files.root)))
        if by_url:
            self._connection.register_filesystem(_file_system(files))
        root = f"{_PROTOCOL}://" if by_url else f"{files.root}/"  # type: ignore[attr-defined]  # a folder
        run("SET enable_progress_bar = false")
        run("SET TimeZone = 'UTC'")  # else `utc > now()` compares with the local time
        run("SET python_enable_replacements = false")
        run(f"SET allowed_directories = [{quoted(root)}]")
        run("SET enable_external_access = false")
        named: dict[str, list[str]] = {table: [] for table in TABLES}
        for entry in self.ledger.entries.values():
            for name in entry.files:
                named[name.partition("/")[0]].append(f"{root}{name}")
        types = ", ".join(f"{quoted(name)}: {kind}" for name, kind in PARTITIONS.items())
        for table, names in named.items():
            if names:
                listed = ", ".join(map(quoted, sorted(names)))
                run(
                    f"CREATE VIEW {table} AS SELECT car, day, * EXCLUDE (car, day) FROM "
                    f"read_parquet([{listed}], union_by_name = true, hive_partitioning = true, "
                    f"hive_types = {{{types}}})"
                )
            else:
                columns = {**PARTITIONS, **TABLES[table]}
                nulls = ", ".join(f"NULL::{kind} AS {name}" for name, kind in columns.items())
                run(f"CREATE VIEW {table} AS SELECT {nulls} WHERE false")
        run("SET lock_configuration = true")


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


def _file_system(files: Store) -> AbstractFileSystem:
    """Return a file system with the dataset's files alone, for reading."""
    from fsspec import AbstractFileSystem
    from fsspec.implementations.local import LocalFileSystem

    at_a_time: AbstractContextManager[Any] = nullcontext()
    if isinstance(files, UrlStore):
        system: Any = files.system
        root = files.root
        if not files.is_object_store:
            at_a_time = threading.Lock()  # one connection, as of FTP, and duckdb has many threads
    else:
        system, root = LocalFileSystem(), str(files.root)  # type: ignore[attr-defined]  # a folder

    class DatasetFileSystem(AbstractFileSystem):  # type: ignore[misc]  # fsspec has no types
        """The dataset as duckdb sees it, `dataset://samples/…`."""

        protocol = _PROTOCOL
        cachable = False

        def _at(self, path: str) -> str:
            name = str(self._strip_protocol(path))
            if ".." in name.split("/"):
                raise FileNotFoundError(name)
            return f"{root}/{name}"

        def info(self, path: str, **_: object) -> dict[str, Any]:
            with at_a_time:
                return {**system.info(self._at(path)), "name": path}

        def glob(self, path: str, **_: object) -> list[str]:
            return [str(self._strip_protocol(path))]

        def modified(self, _: str) -> datetime:
            return datetime(2000, 1, 1, tzinfo=UTC)  # a file is never changed

        def _open(self, path: str, mode: str = "rb", **_: object) -> object:
            if mode != "rb":
                raise PermissionError(path)
            if isinstance(at_a_time, nullcontext):
                return system.open(self._at(path), "rb")
            with at_a_time:
                return BytesIO(system.cat_file(self._at(path)))

    return DatasetFileSystem()
