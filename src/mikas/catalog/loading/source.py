"""One catalog file: its text, its tables, and the line of every key.

All errors of a file, from a missing file to an invalid key, are raised as a CatalogError with the
line. The standard parser names a line only for a syntax error; `lines_of` finds the line of a valid
key with an invalid value. It scans text that the parser has accepted, so it needs no grammar beyond
brackets, strings, dots and equals signs.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Context, Decimal
from pathlib import Path
from typing import Any, Final, TypeAlias

from mikas import toml
from mikas.errors import CatalogError, reason_of
from mikas.files import ABSENT
from mikas.i18n import Text

KeyPath: TypeAlias = tuple[str, ...]

_TOKEN = re.compile(
    r'''
      (?P<skip> [ \t]+ | \#[^\n]* )
    | (?P<string>
          """ (?: \\. | [^\\] )*? "{3,5}  |  \'\'\' .*? '{3,5}
        | " (?: \\. | [^"\\] )* "  |  ' [^']* ' )
    | (?P<mark> [\n\[\]{}=,.] )
    | (?P<word> [^\s\[\]{}=,."'#]+ )
    ''',
    re.VERBOSE | re.DOTALL,
)


MOST_FILES: Final = 200
"""The files of a folder of the user's own that are read: a wrong folder must not stop a program."""

_TOO_MANY: Final = Text(
    "has more than {most} .toml files; only the first are read",
    "больше {most} файлов .toml; прочитаны только первые",
)


def own_files(folder: Path | None) -> tuple[list[Path], tuple[CatalogError, ...]]:
    """Return the TOML files of the user's `folder`, sorted; and why some or all are not read."""
    if folder is None:
        return [], ()
    try:
        files = sorted(path for path in folder.iterdir() if path.suffix == ".toml")
    except ABSENT:
        return [], ()
    except OSError as error:
        reason = reason_of(error)
        problem = Text(f"can't be read: {reason.en}", f"не читается: {reason.ru}")
        return [], (CatalogError(str(folder), 0, problem).caused_by(error, folder),)
    if len(files) <= MOST_FILES:
        return files, ()
    too_many = CatalogError(str(folder), 0, _TOO_MANY.filled(most=MOST_FILES))
    return files[:MOST_FILES], (too_many,)


def lines_of(text: str) -> dict[KeyPath, int]:
    """Return the 1-based line of the first place of each table and key, by full path.

    `text` is valid TOML with bare newlines. Tables implied by a dotted key are listed too; keys of
    tables in an array have the array's path.
    """
    return _Scanner(text).lines


def headers_of(text: str) -> list[tuple[KeyPath, int]]:
    """Return the table and the 1-based line of each header, in the order of `text`."""
    return _Scanner(text).headers


class _Scanner:
    """The state: in a key, a header or between statements (`_in_key`), or in a value."""

    def __init__(self, text: str) -> None:
        self.lines: dict[KeyPath, int] = {}
        self.headers: list[tuple[KeyPath, int]] = []
        self._in_key = True
        self._key: list[str] = []
        self._table: KeyPath = ()  # the header above
        self._value: KeyPath = ()  # the path of the value being read
        self._open: list[tuple[str, KeyPath]] = []  # its brackets, and the path they belong to
        for token, is_name, line in _tokens(text):
            if self._in_key:
                self._key_token(token, is_name, line)
            else:
                self._value_token(token)

    def _key_token(self, token: str, is_name: bool, line: int) -> None:
        # A key and the sign behind it stand on one line.
        if is_name:
            self._key.append(_unquoted(token))
        elif token == "]" and self._key:  # the end of a header; the second of ]] adds nothing
            self._table = self._record((), line)
            self.headers.append((self._table, line))
        elif token == "=":
            self._value = self._record(self._open[-1][1] if self._open else self._table, line)
            self._in_key = False
        elif token == "}":  # an empty table
            self._value, self._in_key = self._open.pop()[1], False

    def _value_token(self, token: str) -> None:
        if token in {"[", "{"}:
            self._open.append((token, self._value))
            self._in_key = token == "{"
        elif token in {"]", "}"}:
            self._value = self._open.pop()[1]
        elif token == ",":
            self._in_key = self._open[-1][0] == "{"
        elif token == "\n":
            self._in_key = not self._open

    def _record(self, inside: KeyPath, line: int) -> KeyPath:
        path = (*inside, *self._key)
        for length in range(1, len(path) + 1):
            self.lines.setdefault(path[:length], line)
        self._key = []
        return path


def _tokens(text: str) -> Iterator[tuple[str, bool, int]]:
    """Yield each token, whether it can be a name (a word or a string), and its line."""
    line = 1
    for match in _TOKEN.finditer(text):
        if match.lastgroup != "skip":
            yield match.group(), match.lastgroup != "mark", line
        line += match.group().count("\n")


def _unquoted(key: str) -> str:
    if key[0] in "\"'":
        return str(tomllib.loads(f"key = {key}")["key"])
    return key


# Decimal numbers stay exact; one out of bounds becomes infinite and is refused later.
_DECIMALS = Context(prec=60, traps=[])


@dataclass(frozen=True, slots=True)
class CatalogFile:
    """A file's name, text and TOML tables. `order`: among several, of which the later wins."""

    name: str
    text: str
    tables: dict[str, Any]
    order: int = 0

    def wrong(self, path: KeyPath, problem: Text) -> CatalogError:
        """Return the error for the key or table at `path`, named before `problem`."""
        name = ".".join(path)
        return self.error(path, f"`{name}` {problem.en}", f"`{name}`: {problem.ru}")

    def error(self, path: KeyPath, en: str, ru: str) -> CatalogError:
        """Return the error at the line of `path`, in full."""
        lines = lines_of(self.text)
        known = (lines[path[:end]] for end in range(len(path), 0, -1) if path[:end] in lines)
        return CatalogError(self.name, next(known, 0), Text(en, ru))


def read_source(path: Path) -> CatalogFile:
    """Read a file. CatalogError: it can't be read, is too large, not UTF-8, or not TOML."""
    try:
        data = toml.read_bytes(path)
    except OSError as error:
        reason = reason_of(error)
        problem = Text(f"the file can't be read: {reason.en}", f"файл не читается: {reason.ru}")
        raise CatalogError(str(path), 0, problem).caused_by(error, path) from error
    return parse_source(str(path), data)


def parse_source(name: str, data: bytes, *, bounded: bool = True) -> CatalogFile:
    """Parse a file's bytes. CatalogError as for `read_source`. `bounded`: as `mikas.toml.parse`."""
    try:
        text = toml.text_of(data)
        tables = toml.parse(text, _decimal, bounded=bounded)
    except toml.TomlError as error:
        raise CatalogError(name, error.line, error.problem) from error
    return CatalogFile(name, text, tables)


def _decimal(number: str) -> Decimal:
    return _DECIMALS.create_decimal(number)
