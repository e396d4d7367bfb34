"""What the protocol's clauses, commands, parameters and errata rest on (§6): `evidence.toml`.

    evidence().basis_of("D11").source ──► "silent"       what the source, and others, say of it
    evidence().sightings_of("D11")    ──► (Sighting, …)  what units that were met have shown

A parameter's and a fault's own `source` and `confidence` stand with them in the catalog;
`mikas.catalog.grounds` puts both together.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cache, cached_property
from pathlib import Path
from typing import Final

from mikas.catalog.conversion import NO_TEXT
from mikas.catalog.loading.build import optional
from mikas.catalog.loading.entries import Entry
from mikas.catalog.loading.fields import (
    ANY,
    TEXT,
    Schema,
    choice,
    read_table,
    string,
    strings,
    unknown_key,
)
from mikas.catalog.loading.source import CatalogFile, parse_source
from mikas.i18n import Text

__all__ = ["Agreement", "Basis", "EvidenceTable", "Sighting", "evidence", "read_evidence"]

FILE: Final = "evidence.toml"


class Agreement(StrEnum):
    """How what a unit did compares with a clause."""

    AGREES = "agrees"
    """It did what the clause says."""
    DIFFERS = "differs"
    """It did something else."""
    SHOWS = "shows"
    """The clause leaves it open; this is what the unit did."""


@dataclass(frozen=True, slots=True)
class Sighting:
    """What one unit that was met has shown of a clause, a parameter or an erratum."""

    of: tuple[str, ...]
    """The names of what it concerns: `D11`, `61`, `UACC`, `E3`."""
    unit: str
    """Which unit, and when: a model and a date, nothing of its owner's."""
    agreement: Agreement
    """How it compares with the clause."""
    text: Text
    """What the unit did."""


@dataclass(frozen=True, slots=True)
class Basis:
    """What several clauses, commands, parameters or errata rest on."""

    of: tuple[str, ...]
    """Their names: `§2.1`, `D3`, `61`, `TWAT`, `E3`."""
    source: Text
    """What the protocol's source says."""
    siblings: Text = NO_TEXT
    """What sibling units and other texts say; empty: nothing."""


@dataclass(frozen=True)
class EvidenceTable:
    """The content of an evidence file."""

    bases: tuple[Basis, ...]
    """In the order of the protocol's page."""
    titles: Mapping[str, Text]
    """What clauses and decisions are about, by name."""
    sources: Mapping[str, Text]
    """The public pages that faults' texts are from, by key: S1."""
    sightings: tuple[Sighting, ...] = ()
    """In the order in which units were met."""

    @cached_property
    def _by_name(self) -> dict[str, Basis]:
        return {name: basis for basis in self.bases for name in basis.of}

    def basis_of(self, name: str) -> Basis | None:
        """Return what the thing of that name rests on; None: no clause of the protocol."""
        return self._by_name.get(name)

    def sightings_of(self, *names: str) -> tuple[Sighting, ...]:
        """Return what units have shown of these."""
        return tuple(each for each in self.sightings if not set(names).isdisjoint(each.of))


@cache
def evidence() -> EvidenceTable:
    """Return the evidence of this version, always the same object."""
    return read_evidence(FILE, (Path(__file__).parent / FILE).read_bytes())


_SCHEMAS: Final[Mapping[str, Schema]] = {
    "source": {ANY: TEXT},
    "title": {ANY: TEXT},
    "basis": {"of": strings, "source": TEXT, "siblings": TEXT},
    "sighting": {
        "of": strings,
        "unit": string,
        "agreement": choice(Agreement, *Agreement),
        "text": TEXT,
    },
}


def read_evidence(name: str, data: bytes) -> EvidenceTable:
    """Read an evidence file. CatalogError: it is no TOML, or a key or a value is wrong."""
    file = parse_source(name, data, bounded=False)
    for key in file.tables:
        if key not in _SCHEMAS:
            raise unknown_key(file, (key,), _SCHEMAS)
    sources, titles = (_texts(file, key) for key in ("source", "title"))
    bases = tuple(map(_basis, _entries(file, "basis")))
    sightings = tuple(map(_sighting, _entries(file, "sighting")))
    return EvidenceTable(bases, titles, sources, sightings)


def _texts(file: CatalogFile, key: str) -> dict[str, Text]:
    entry = _entry(file, key, file.tables.get(key, {}))
    return {name: entry.text(name) for name in entry.values}


def _entries(file: CatalogFile, key: str) -> Iterator[Entry]:
    tables = file.tables.get(key, [])
    if not isinstance(tables, list):
        raise file.wrong((key,), Text(f"is a list: [[{key}]]", f"это список: [[{key}]]"))
    for table in tables:
        yield _entry(file, key, table)


def _entry(file: CatalogFile, key: str, table: object) -> Entry:
    path = (key,)
    entry = Entry(file, path, (file, path))
    entry.override((), entry.values, read_table(file, path, table, _SCHEMAS[key]))
    return entry


def _basis(entry: Entry) -> Basis:
    entry.require("of")
    return Basis(entry.values["of"], entry.text("source"), optional(entry, "siblings"))


def _sighting(entry: Entry) -> Sighting:
    for key in ("of", "unit", "agreement"):
        entry.require(key)
    values = entry.values
    return Sighting(values["of"], values["unit"], values["agreement"], entry.text("text"))
