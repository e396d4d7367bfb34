"""The shipped catalog, overridden by a user's files.

A file has tables named `[parameter.TWAT]`, `[derived.FUEL_USED]`, `[instrument.LAMBDA]`,
`[fault.13]`, `[model.0x09]`, `[erratum.E1]` and `[unit.rpm]`; an existing entry is overridden key
by key, so two lines can change one text. Adding a parameter takes five lines:

    [parameter.BOOST]
    code = 0x33
    size = 1
    unit = "kPa"
    text = { en = "Boost pressure", ru = "Давление наддува" }

docs/reference/catalog.md describes all keys. A file with any mistake is refused with the line
(CatalogError).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from os import PathLike
from pathlib import Path
from zlib import crc32

from mikas.catalog.loading.build import catalog_of
from mikas.catalog.loading.entries import merged
from mikas.catalog.loading.source import CatalogFile, parse_source, read_source
from mikas.catalog.lookup import Catalog

_SHIPPED = (
    "units.toml",
    "errata.toml",
    "parameters.toml",
    "derived.toml",
    "instruments.toml",
    "faults.toml",
    "models.toml",
)


def load(*user_files: str | PathLike[str]) -> Catalog:
    """Return the shipped catalog, overridden by these files in order.

    CatalogError: a file can't be read or is wrong.
    """
    if not user_files:
        return shipped()
    return combined([*_shipped_sources(), *(read_source(Path(file)) for file in user_files)])


def load_text(name: str, text: str, *more: Path) -> Catalog:
    """As `load`, of a file `name` that has not been written yet, and of `more` files over it."""
    own = parse_source(name, text.encode())
    return combined([*_shipped_sources(), own, *map(read_source, more)])


def load_changed(texts: Mapping[str, str]) -> Catalog:
    """Return the shipped catalog with `texts` in the place of its own files of these names.

    CatalogError: such a catalog would be wrong.
    """
    return combined(
        [
            parse_source(each.name, texts[each.name].encode()) if each.name in texts else each
            for each in _shipped_sources()
        ]
    )


@cache
def shipped() -> Catalog:
    """Return the catalog of this version, always the same object."""
    return combined(_shipped_sources())


@cache
def _shipped_sources() -> tuple[CatalogFile, ...]:
    folder = Path(__file__).parents[1]  # the package `mikas.catalog`
    return tuple(
        parse_source(name, (folder / name).read_bytes(), bounded=False) for name in _SHIPPED
    )


def combined(sources: Sequence[CatalogFile]) -> Catalog:
    """Return the catalog of `sources`, a later one over an earlier. Raises `CatalogError`."""
    return catalog_of(merged(sources), _version(sources))


def _version(sources: Sequence[CatalogFile]) -> str:
    """Return `1+3f2a90c1`: the last `version` of the files and a CRC-32 of all texts in order.

    The checksum detects accidental differences, not forgery.
    """
    texts = "\0".join(source.text for source in sources)
    named = [source.tables["version"] for source in sources if "version" in source.tables]
    return f"{named[-1]}+{crc32(texts.encode()):08x}"
