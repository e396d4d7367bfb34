"""One amendment: what a unit has shown of some clauses, and the changed keys of the catalog."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from mikas.catalog.evidence import Agreement
from mikas.i18n import Text
from mikas.json_values import picked

__all__ = ["Amendment", "CatalogChange"]


@dataclass(frozen=True, slots=True)
class CatalogChange:
    """New values of keys of one entry in a shipped file."""

    file: str
    """The file's name: `parameters.toml`."""
    family: str
    """The entry's family: `parameter`."""
    name: str
    """The entry's name: `UACC`."""
    keys: Mapping[str, Any]
    """The values by key, as TOML has them; a table in a table for one of its keys."""


@dataclass(frozen=True, slots=True)
class Amendment:
    """What one answer of a survey says of some clauses."""

    of: tuple[str, ...]
    """What it concerns, by the names of `mikas.catalog.evidence`: `D11`, `61`, `RCOK`."""
    agreement: Agreement
    """How the unit compares with the clause."""
    text: Text
    """What the unit has shown."""
    changes: tuple[CatalogChange, ...] = ()
    """What it would change in the catalog, beside the evidence."""

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON values."""
        return picked(self, "of", "agreement", "text", "changes")
