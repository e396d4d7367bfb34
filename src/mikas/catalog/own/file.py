"""The user's own catalog, `catalog.toml` beside the config file: read by every command, changed by
the dashboard.

    shipped ◄── catalog.toml ◄── --catalog FILE …        the later file overrides, key by key

A wrong own file is left out with its problem, so that no command is useless until it is mended: an
entry of it may be wrong only since another version of mikas. A wrong FILE is an error.

A change is made on the file as it is at that moment, checked by the loader together with the other
files, and saved only if it is good.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from mikas import toml
from mikas.catalog.loading.loader import load, load_text
from mikas.catalog.loading.source import parse_source
from mikas.catalog.lookup import Catalog
from mikas.errors import CatalogError, reason_of
from mikas.files import ABSENT
from mikas.i18n import Text
from mikas.saving import save

NAME: Final = "catalog.toml"
LARGEST: Final = 256 * 1024
"""Bytes of a file that is changed by the program; more is left to its author's editor."""

_HEADING: Final = (
    "# Definitions of your own: docs/reference/catalog.md has the keys. The dashboard changes\n"
    "# this file and keeps what you write here, comments too.\n"
)


@dataclass(frozen=True, slots=True)
class Loaded:
    """A catalog. `problem`: why the own file is not in it; None: it is, or there is none."""

    catalog: Catalog
    problem: CatalogError | None = None


def left_out(problem: CatalogError) -> Text:
    """Return the sentence about a file that was left out, with the reason."""
    return Text(
        "Your own catalog was left out: {reason}", "Ваш каталог не подключён: {reason}"
    ).filled(reason=problem.reason)


class OwnCatalog:
    """The file `path`, which need not exist, below `more` files. One change at a time."""

    def __init__(self, path: Path, more: Sequence[Path] = ()) -> None:
        self.path: Path = path
        self._more = tuple(more)

    def load(self) -> Loaded:
        """Return the catalog of all files. Raises `CatalogError` for one of `more`."""
        try:
            return Loaded(load(self.path, *self._more))
        except CatalogError as error:
            if error.file != str(self.path):
                raise
            is_there = not isinstance(error.__cause__, ABSENT)
            return Loaded(load(*self._more), error if is_there else None)

    def entries(self) -> dict[tuple[str, str], Mapping[str, Any]]:
        """Return the entries of the file as (family, name in capitals); none of a wrong file."""
        try:
            tables = parse_source(str(self.path), self._read().encode()).tables
        except CatalogError:
            return {}
        return {
            (family, name.upper()): keys
            for family, names in tables.items()
            if isinstance(names, dict)
            for name, keys in names.items()
            if isinstance(keys, dict)
        }

    def change(
        self, edit: Callable[[str], str], accept: Callable[[Catalog], object] = lambda _: None
    ) -> Catalog:
        """Change the file's text by `edit`, and return the catalog of all files then.

        Raises `CatalogError` for a file that can't be read, written, or loaded after the change,
        and what `accept(catalog)` raises; then the old one is still there. An `edit` without an
        effect writes nothing.
        """
        before = self._read()
        after = edit(before or _HEADING)
        if not before and after == _HEADING:
            return load(*self._more)
        catalog = load_text(str(self.path), after, *self._more)
        accept(catalog)
        if after != before:
            self._write(after)
        return catalog

    def _read(self) -> str:
        try:
            data = toml.read_bytes(self.path)
            if len(data) > LARGEST:
                raise self._failed(_TOO_LARGE)
            return toml.text_of(data)
        except ABSENT:
            return ""
        except OSError as error:
            raise self._failed(reason_of(error)).caused_by(error, self.path) from error
        except toml.TomlError as error:
            raise CatalogError(str(self.path), error.line, error.problem) from error

    def _write(self, text: str) -> None:
        try:
            path = self.path.resolve()  # the user may keep the file elsewhere, by a link
            path.parent.mkdir(parents=True, exist_ok=True)
            if os.linesep == "\n" and path.exists() and b"\r\n" in toml.read_bytes(path):
                text = text.replace("\n", "\r\n")  # as it was
            save(path, text)
        except OSError as error:
            raise self._failed(reason_of(error)).caused_by(error, self.path) from error

    def _failed(self, problem: Text) -> CatalogError:
        return CatalogError(str(self.path), 0, problem)


_TOO_LARGE: Final = Text(
    f"the file is larger than {LARGEST // 1024} KB; change it in a text editor",
    f"файл больше {LARGEST // 1024} КБ; измените его в текстовом редакторе",
)
