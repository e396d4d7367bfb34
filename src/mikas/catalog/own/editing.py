"""Change one entry of a catalog file's text; everything else stays as its author wrote it.

    with_keys(text, "parameter", "TWAT", {"limits": {"danger_high": 115}, "reference": None})
    without(text, "derived", "LOAD")

New keys follow the last key of their table; a new table follows the last table of its entry, or
ends the file. tomlkit replaces an existing key in its place and keeps the comment on its line. A
removed table leaves the comments below its last key: they may belong to the next one.

The result is compared with the change made on the parsed tables: a text that means anything else
is not returned (`CatalogError`), as tomlkit does not master all that TOML allows.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from typing import Any, Final, TypeAlias

import tomlkit
from tomlkit.exceptions import TOMLKitError

from mikas import toml
from mikas.catalog.loading.source import CatalogFile, KeyPath, headers_of
from mikas.errors import CatalogError
from mikas.i18n import Text

Tables: TypeAlias = "dict[str, Any]"

_TEXT: Final = "text"
"""The key whose table of two languages is a value: it is replaced as a whole."""

_UNFIT: Final = (ValueError, LookupError, TypeError, AttributeError, TOMLKitError)
"""What tomlkit raises for a form that it does not master; `TomlError` for its result."""

_BY_HAND: Final = Text(
    "this entry is written in a way that the program can't change; change it in a text editor",
    "эта запись сделана так, что программа её не изменит; измените её в текстовом редакторе",
)


def with_keys(text: str, family: str, name: str, keys: Mapping[str, Any], *, file: str = "") -> str:
    """Return `text` with these keys of an entry; None removes a key, a mapping goes into a table.

    `name`: in any case. A table or an entry that loses its last key is removed. Raises
    `CatalogError` naming `file` if the text is no TOML, or the entry can't be changed.
    """
    document = _Document(text, file)
    entry = document.entry(family, name)
    for path, value in _leaves(entry, keys):
        document.change(path, value)
    for path in (*((*entry, key) for key in document.at(entry) or ()), entry):
        if document.at(path) == {}:
            document.change(path, None)
    return document.text


def without(text: str, family: str, name: str, *, file: str = "") -> str:
    """Return `text` without the entry; the same text if it has none. Raises as `with_keys`."""
    document = _Document(text, file)
    document.change(document.entry(family, name), None)
    return document.text


class _Document:
    """A file's text, changed at one place after the other; its tables change with it."""

    def __init__(self, text: str, file: str) -> None:
        self.text, self._file = text, file
        try:
            self._tables = toml.parse(text)
        except toml.TomlError as error:
            raise CatalogError(file, error.line, error.problem) from error

    def entry(self, family: str, name: str) -> KeyPath:
        """Return the path of an entry, with its name as the file has it."""
        known = self._tables.get(family, {})
        return family, next((key for key in known if key.upper() == name.upper()), name)

    def at(self, path: KeyPath) -> Any:  # noqa: ANN401  (any TOML)
        """Return the value at `path`; None: there is none."""
        found: Any = self._tables
        for key in path:
            found = found.get(key) if isinstance(found, dict) else None
        return found

    def change(self, path: KeyPath, value: object) -> None:
        """Put `value` at `path`; None: remove the present one."""
        present = self.at(path)
        if present == value and type(present) is type(value):
            return
        wanted = deepcopy(self._tables)
        _put(wanted, path, value)
        for way in (_by_headers, _by_tomlkit):
            try:
                after = way(self.text, path, value, present=present is not None)
                if after is None:
                    continue
                tables = toml.parse(after)
                if _meant(tables) == _meant(wanted):
                    self.text, self._tables = after, tables
                    return
            except _UNFIT:
                continue
        raise CatalogFile(self._file, self.text, self._tables).error(path, *_BY_HAND)


def _leaves(path: KeyPath, keys: Mapping[str, Any]) -> Iterator[tuple[KeyPath, Any]]:
    for key, value in keys.items():
        if isinstance(value, Mapping) and key != _TEXT:
            yield from _leaves((*path, key), value)
        else:
            yield (*path, key), value


def _meant(tables: Tables) -> Tables:
    """Return the tables without the empty ones, which mean nothing."""
    kept = {
        key: _meant(value) if isinstance(value, dict) else value for key, value in tables.items()
    }
    return {key: value for key, value in kept.items() if value != {}}


def _put(tables: Tables, path: KeyPath, value: object) -> None:
    *parents, last = path
    for key in parents:
        tables = tables.setdefault(key, {})
    if value is None:
        tables.pop(last, None)
    else:
        tables[last] = value


def _by_headers(text: str, path: KeyPath, value: object, *, present: bool) -> str | None:
    """Make the change by whole lines; None: it takes a change inside a line."""
    headers = headers_of(text)
    if value is None:
        own = [at for at, (table, _) in enumerate(headers) if table[: len(path)] == path]
        return _without_sections(text, headers, own) if own else None
    if present:
        return None
    lines, line = text.splitlines(keepends=True), f"{_key(path[-1])} = {_value(value)}\n"
    if lines and not lines[-1].endswith("\n"):
        lines[-1] += "\n"
    *_, table = (path[:end] for end in range(1, len(path)))
    for at, (found, _) in enumerate(headers):
        if found == table:
            lines.insert(_content_end(lines, headers, at), line)
            return "".join(lines)
    header = f"[{'.'.join(map(_key, table))}]\n"
    near = [at for at, (found, _) in enumerate(headers) if found[:2] == path[:2]]
    if near:
        at = _content_end(lines, headers, near[-1])
        return "".join([*lines[:at], "\n", header, line, *lines[at:]])
    return "".join([*lines, *(["\n"] if lines else []), header, line])


def _without_sections(
    text: str, headers: Sequence[tuple[KeyPath, int]], removed: Sequence[int]
) -> str:
    lines = text.splitlines(keepends=True)
    for at in reversed(removed):
        begin, end = headers[at][1] - 1, _content_end(lines, headers, at)
        if begin and end < len(lines) and not lines[begin - 1].strip() and not lines[end].strip():
            end += 1  # one of two empty lines
        del lines[begin:end]
    return "".join(lines)


def _content_end(lines: Sequence[str], headers: Sequence[tuple[KeyPath, int]], at: int) -> int:
    """Return the number of lines up to the last key of a section: without what follows it."""
    end = headers[at + 1][1] - 1 if at + 1 < len(headers) else len(lines)
    while end > headers[at][1] and lines[end - 1].lstrip()[:1] in ("", "#"):
        end -= 1
    return end


def _by_tomlkit(text: str, path: KeyPath, value: object, **_: bool) -> str:
    document: Any = tomlkit.parse(text)
    table = document
    for key in path[:-1]:
        table = table.setdefault(key, tomlkit.inline_table())
    if value is None:
        del table[path[-1]]
    else:
        table[path[-1]] = _item(value)
    return tomlkit.dumps(document)


def _item(value: object) -> Any:  # noqa: ANN401  (tomlkit's)
    if isinstance(value, Mapping):
        table = tomlkit.inline_table()
        table.update(value)
        return table
    return tomlkit.item(value)


def _value(value: object) -> str:
    return str(_item(value).as_string())


def _key(key: str) -> str:
    return tomlkit.key(key).as_string()
