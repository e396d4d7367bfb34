"""Entries merged from several files: a later file adds and overrides, key by key.

An entry knows the file of each key, so that a mistake is reported at its place.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

from mikas.catalog.loading import fields
from mikas.catalog.loading.source import CatalogFile, KeyPath
from mikas.errors import CatalogError
from mikas.i18n import Text

MOST_ENTRIES = 2000  # of a family, in one file; a unit has 256 codes

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
        return source.wrong(path, problem)

    def wrong_name(self, problem: Text) -> CatalogError:
        """Return the error for the entry's name, at its first place."""
        source, path = self.first
        return source.wrong(path, problem)

    def order(self, key: KeyPath) -> int:
        """Return the number of the key's file, greater for a later one; -1 for a missing key."""
        return self.places[key][0].order if key in self.places else -1

    def override(self, inside: KeyPath, values: dict[str, Any], by: dict[str, Any]) -> None:
        """Put the keys of its last table, and of the tables in that, over `values`."""
        for key, value in by.items():
            path = (*inside, key)
            self.places[path] = (self.source, (*self.table, *path))
            if isinstance(value, dict):
                self.override(path, values.setdefault(key, {}), value)
            else:
                values[key] = value

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
    entries: Entries = {family: {} for family in fields.FAMILIES}
    for order, each in enumerate(sources):
        source = replace(each, order=order)
        for family, tables in source.tables.items():
            if family == "version":
                fields.read_value(source, (family,), fields.string, tables)
            elif family in fields.FAMILIES:
                _add_tables(entries[family], source, family, tables)
            else:
                raise fields.unknown_key(source, (family,), (*fields.FAMILIES, "version"))
    return entries


def _add_tables(known: dict[Any, Entry], source: CatalogFile, family: str, tables: object) -> None:
    names, kind = set(), fields.FAMILIES[family]
    for key, table in fields.as_table(source, (family,), tables, f"{family}.NAME").items():
        path = (family, key)
        name = fields.read_value(source, path, kind.key, key)
        if name in names:
            raise source.wrong(path, Text("is there twice", "есть дважды"))
        names.add(name)
        if len(names) > MOST_ENTRIES:
            raise source.wrong(
                path,
                Text(
                    f"is more than the {MOST_ENTRIES} entries that a file may have of a kind",
                    f"уже больше {MOST_ENTRIES}: столько записей одного вида может быть в файле",
                ),
            )
        entry = known.setdefault(name, Entry(source, path, (source, path)))
        entry.source, entry.table = source, path
        entry.override((), entry.values, fields.read_table(source, path, table, kind.schema))
