"""Entries merged from several files: a later file adds and overrides, key by key.

An entry knows the file of each key, so that a mistake is reported at its place.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from mikas.catalog.loading.fields import (
    ANY,
    FAMILIES,
    TEXT,
    Reader,
    Schema,
    Unfit,
    constant,
    string,
)
from mikas.catalog.loading.source import CatalogFile, KeyPath
from mikas.errors import CatalogError
from mikas.i18n import Text
from mikas.options import nearest

Entries: TypeAlias = "dict[str, dict[Any, Entry]]"
"""By family, then by name (upper case) or number, in the order of the files' tables."""


@dataclass(slots=True)
class Entry:
    """One table of one or several files. `values` nests like the tables.

    `source`, `table`: the last file with this entry; `first`: the first one; `places`: the file of
    each key.
    """

    source: CatalogFile
    table: KeyPath
    first: tuple[CatalogFile, KeyPath]
    values: dict[str, Any] = field(default_factory=dict)
    places: dict[KeyPath, tuple[CatalogFile, KeyPath]] = field(default_factory=dict)

    def wrong(self, key: KeyPath, problem: Text) -> CatalogError:
        """Return the error for a key, or for the table if the key is missing."""
        source, path = self.places.get(key, (self.source, self.table))
        return source.wrong(path, _about(path, problem))

    def wrong_name(self, problem: Text) -> CatalogError:
        """Return the error for the entry's name, at its first place."""
        source, path = self.first
        return source.wrong(path, _about(path, problem))

    def order(self, key: KeyPath) -> int:
        """Return the number of the key's file, greater for a later one; -1 for a missing key."""
        return self.places[key][0].order if key in self.places else -1

    def require(self, key: str) -> None:
        """Raise CatalogError for a missing key."""
        if key not in self.values:
            raise self.wrong((), Text(f"has no `{key}`", f"нет `{key}`"))

    def text(self, *path: str) -> Text:
        """Return the required text at `path` in both languages."""
        found = self.values
        for depth, key in enumerate((*path, "en", "ru")):
            if key not in found:
                raise self.wrong(path[:depth], Text(f"has no `{key}`", f"нет `{key}`"))
            found = found if depth >= len(path) else found[key]
        return Text(**found)


def merged(sources: Iterable[CatalogFile]) -> Entries:
    """Merge the entries of all files. CatalogError: an unknown key, a wrong type, a duplicate."""
    entries: Entries = {family: {} for family in FAMILIES}
    for source in sources:
        for family, tables in source.tables.items():
            if family == "version":
                _read(source, (family,), string, tables)
            elif family in FAMILIES:
                _add_tables(entries[family], source, family, tables)
            else:
                raise source.wrong((family,), _unknown(family, (*FAMILIES, "version")))
    return entries


def _add_tables(known: dict[Any, Entry], source: CatalogFile, family: str, tables: object) -> None:
    names = set()
    for key, table in _table(source, (family,), tables).items():
        path = (family, key)
        name = _read(source, path, FAMILIES[family].key, key)
        if name in names:
            raise source.wrong(path, _about(path, Text("is there twice", "есть дважды")))
        names.add(name)
        entry = known.setdefault(name, Entry(source, path, (source, path)))
        entry.source, entry.table = source, path
        _lay_over(entry, (), entry.values, table, FAMILIES[family].schema)


def _lay_over(
    entry: Entry, inside: KeyPath, values: dict[str, Any], table: object, schema: Schema
) -> None:
    """Check the keys of a table and its nested tables, and put them into `values`."""
    source, path = entry.source, (*entry.table, *inside)
    if schema is TEXT and isinstance(table, str):
        table = {"en": table, "ru": table}
    for key, value in _table(source, path, table).items():
        rule = schema.get(key) or schema.get(ANY)
        if rule is None:
            raise source.wrong((*path, key), _unknown(key, schema))
        if ANY in schema:
            _read(source, (*path, key), constant, key)
        entry.places[(*inside, key)] = (source, (*path, key))
        if callable(rule):
            values[key] = _read(source, (*path, key), rule, value)
        else:
            _lay_over(entry, (*inside, key), values.setdefault(key, {}), value, rule)


def _read(source: CatalogFile, path: KeyPath, reader: Reader, value: object) -> object:
    try:
        return reader(value)
    except Unfit as unfit:
        raise source.wrong(path, _about(path, unfit.problem)) from None


def _table(source: CatalogFile, path: KeyPath, value: object) -> dict[str, Any]:
    if isinstance(value, dict):
        return value
    header = f"[{path[0]}.NAME]" if len(path) == 1 else f"[{'.'.join(path)}]"
    problem = Text(f"must be a table, as {header}", f"нужна таблица, например {header}")
    raise source.wrong(path, _about(path, problem))


def _about(path: KeyPath, problem: Text) -> Text:
    name = ".".join(path)
    return Text(f"`{name}` {problem.en}", f"`{name}`: {problem.ru}")


def _unknown(key: str, known: Iterable[str]) -> Text:
    names = list(known)
    if close := nearest(key, names):
        return Text(
            f"unknown key `{key}`; the nearest is `{close[0]}`",
            f"неизвестный ключ `{key}`; ближайший — `{close[0]}`",
        )
    listed = ", ".join(names)
    return Text(
        f"unknown key `{key}`; known are {listed}", f"неизвестный ключ `{key}`; есть: {listed}"
    )
