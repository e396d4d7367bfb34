"""The patch of the catalog's TOML files: a unified diff, as `git apply` takes it.

The changed files are loaded before the patch is given: one that would leave a wrong catalog behind
is an error.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from difflib import unified_diff
from pathlib import Path
from typing import Final

import tomlkit

import mikas.catalog
from mikas.amendments.amendment import Amendment
from mikas.catalog.evidence import FILE, evidence, read_evidence
from mikas.catalog.loading.loader import load_changed
from mikas.catalog.own.editing import with_keys

__all__ = ["changed_files", "patch"]

FOLDER: Final = "src/mikas/catalog"
"""The folder of the files in the repository."""
_AROUND: Final = 3  # lines


def patch(amendments: Iterable[Amendment], unit: str) -> str:
    """Return the diff that makes these amendments; empty: the catalog has them all.

    `unit`: as sightings name it. Raises `CatalogError` if the catalog would be wrong then.
    """
    return "".join(
        line
        for name, text in changed_files(amendments, unit).items()
        for line in _diff(name, _shipped(name), text)
    )


def changed_files(amendments: Iterable[Amendment], unit: str) -> dict[str, str]:
    """Return the changed files, by their names, as texts. Raises as `patch`."""
    amendments = tuple(amendments)
    texts: dict[str, str] = {}
    for change in (change for each in amendments for change in each.changes):
        text = texts.get(change.file) or _shipped(change.file)
        texts[change.file] = with_keys(
            text, change.family, change.name, change.keys, file=change.file
        )
    texts[FILE] = _shipped(FILE) + "".join(_sightings(amendments, unit))
    load_changed(texts)
    read_evidence(FILE, texts[FILE].encode())
    return {name: text for name, text in sorted(texts.items()) if text != _shipped(name)}


def _sightings(amendments: Iterable[Amendment], unit: str) -> Iterator[str]:
    """Yield the entry of each amendment but those that the file has of this unit."""
    known = {(each.of, each.text) for each in evidence().sightings if each.unit == unit}
    for each in amendments:
        if (each.of, each.text) in known:
            continue
        of = ", ".join(map(_quoted, each.of))
        yield (
            f"\n[[sighting]]\nof = [{of}]\nunit = {_quoted(unit)}\n"
            f"agreement = {_quoted(each.agreement)}\n"
            f"text = {{ en = {_quoted(each.text.en)}, ru = {_quoted(each.text.ru)} }}\n"
        )


def _quoted(text: str) -> str:
    return tomlkit.item(str(text)).as_string()


def _shipped(name: str) -> str:
    return (Path(mikas.catalog.__file__).parent / name).read_text("utf-8")


def _diff(name: str, before: str, after: str) -> Iterator[str]:
    old, new = (text.splitlines(keepends=True) for text in (before, after))
    return unified_diff(old, new, f"a/{FOLDER}/{name}", f"b/{FOLDER}/{name}", n=_AROUND)
