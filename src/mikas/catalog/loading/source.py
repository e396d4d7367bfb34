"""One catalog file: its text, its tables, and where in it something is wrong.

Reading the file is all the I/O there is. Every fault of a file, from a missing file to a wrong
key, leaves here as a CatalogError with the line.
"""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from decimal import Context, Decimal
from pathlib import Path
from typing import Any, TypeAlias

from mikas.errors import CatalogError, reason_of
from mikas.i18n import Text

KeyPath: TypeAlias = tuple[str, ...]

# Decimal numbers stay exact; one that is out of all bounds becomes infinite and is refused later.
_DECIMALS = Context(prec=60, traps=[])


@dataclass(frozen=True, slots=True)
class Source:
    """A file's name and text, and its tables as TOML has them. `order`: the later file wins."""

    name: str
    text: str
    tables: dict[str, Any]
    order: int

    def wrong(self, path: KeyPath, problem: Text) -> CatalogError:
        """The error to raise for the key or table at `path`."""
        from mikas.catalog.loading.toml_lines import lines_of

        lines = lines_of(self.text)
        known = (lines[path[:end]] for end in range(len(path), 0, -1) if path[:end] in lines)
        return CatalogError(self.name, next(known, 0), problem)


def read_source(path: Path, order: int = 0) -> Source:
    """Read a file. CatalogError: it can't be read, is not UTF-8, or not TOML."""
    try:
        data = path.read_bytes()
    except OSError as error:
        reason = reason_of(error)
        problem = Text(f"the file can't be read: {reason.en}", f"файл не читается: {reason.ru}")
        raise CatalogError(str(path), 0, problem) from error
    return parse_source(str(path), data, order)


def parse_source(name: str, data: bytes, order: int = 0) -> Source:
    """The same for bytes that are at hand."""
    try:
        text = data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        problem = Text(
            "the file is not UTF-8; save it in this encoding",
            "файл не в кодировке UTF-8; сохраните его в ней",
        )
        raise CatalogError(name, line, problem) from error
    try:
        tables = tomllib.loads(text, parse_float=_decimal)
    except (ValueError, RecursionError) as error:
        place = re.search(r"at line (\d+)", str(error))
        line = int(place[1]) if place else text.count("\n") + 1 if "at end" in str(error) else 0
        problem = Text(f"this is not TOML: {error}", "здесь ошибка записи TOML")
        raise CatalogError(name, line, problem) from error
    return Source(name, text, tables, order)


def _decimal(number: str) -> Decimal:
    return _DECIMALS.create_decimal(number)
