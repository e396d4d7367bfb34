"""The user's own definitions of instruments: a TOML file each, in the folder of the state."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import tomlkit

from mikas import toml
from mikas.catalog import Catalog
from mikas.dashboard.errors import NotFound
from mikas.errors import MikasError, naming_file, usage_error
from mikas.i18n import Text
from mikas.instruments import (
    InstrumentDefinition,
    definition_named,
    definition_names,
    definition_of_text,
)
from mikas.saving import save

_NAME: Final = re.compile(r"[a-z0-9][a-z0-9-]{0,39}")
_MOST: Final = 100
_GIVEN: Final = ("text", "unit", "range")
"""The keys of a channel that are given with each definition."""


@dataclass(frozen=True, slots=True)
class OwnDefinitions:
    """The definitions in `folder`. One thread at a time may change them."""

    folder: Path

    def all(self, catalog: Catalog) -> tuple[dict[str, InstrumentDefinition], list[Text]]:
        """Return the definitions by name, and why others can't be used."""
        found: dict[str, InstrumentDefinition] = {}
        problems: list[Text] = []
        for path in sorted(self.folder.glob("*.toml"))[:_MOST]:
            try:
                found[path.stem] = definition_named(str(path), catalog)
            except MikasError as error:
                problems.append(error.text)
        return found, problems

    def named(self, name: str, catalog: Catalog) -> InstrumentDefinition:
        """Return the own or shipped definition. Raises as `definition_named`."""
        path = self.folder / f"{name}.toml"
        if _NAME.fullmatch(name) and path.is_file():
            return definition_named(str(path), catalog)
        return definition_named(name, catalog)

    def write(
        self, name: str, keys: Mapping[str, object], channels: Sequence[str], catalog: Catalog
    ) -> InstrumentDefinition:
        """Write a definition of lines of text. `channels`: those that its patterns must name.

        What else its file has stays: limits, a gauge's scale, the source.

        Raises `CatalogError` for a wrong one, `UsageError` for a name that is taken.
        """
        if name in definition_names() or not _NAME.fullmatch(name):
            raise usage_error(
                f"“{name}” is taken or no name; small Latin letters, digits and hyphens: my-meter",
                f"Имя «{name}» занято или не подходит; нужны строчные латинские буквы, цифры "
                "и дефисы: my-meter",
            )
        path = self.folder / f"{name}.toml"
        text = tomlkit.dumps(_merged(_tables(path), {"decoder": "line", **keys}))
        made = definition_of_text(name, text, catalog)
        given = {channel.name for channel in made.channels}
        if unused := [channel for channel in channels if channel not in given]:
            raise usage_error(
                f"No pattern has {{{unused[0]}}}",
                f"Ни в одном образце нет {{{unused[0]}}}",
            )
        with naming_file(path):
            self.folder.mkdir(parents=True, exist_ok=True)
            save(path, text)
        return made

    def remove(self, name: str) -> None:
        """Delete a definition. Raises `NotFound`."""
        path = self.folder / f"{name}.toml"
        if not _NAME.fullmatch(name) or not path.is_file():
            raise NotFound(name=name)
        with naming_file(path):
            path.unlink()


def _tables(path: Path) -> dict[str, Any]:
    """Return what a file has; nothing of a wrong one, or of none."""
    with suppress(OSError, toml.TomlError):
        return toml.parse(toml.text_of(toml.read_bytes(path)))
    return {}


def _merged(before: Mapping[str, Any], keys: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables `before` with these keys, and those of each channel that are given."""
    known = before.get("instrument")
    channels: dict[str, Any] = dict(known) if isinstance(known, dict) else {}
    for name, given in keys.get("instrument", {}).items():
        own = channels.get(name)
        kept = own.items() if isinstance(own, dict) else ()
        channels[name] = {key: each for key, each in kept if key not in _GIVEN} | given
    merged = {**before, **keys}
    merged.pop("instrument", None)
    return merged | ({"instrument": channels} if channels else {})
