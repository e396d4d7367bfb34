"""Which columns to take of a log that knows its own time."""

from __future__ import annotations

from collections.abc import Mapping

from mikas.errors import ForeignLogError
from mikas.i18n import Text


def taken_of(
    units: Mapping[str, str], columns: Mapping[str, str | None] | None, name: str
) -> list[tuple[str, str]]:
    """Return name and unit of each column to take, in the file's order: all, or the chosen ones.

    `units`: of all columns, by name. Raises `ForeignLogError` for one that is not there.
    """
    if columns is None:
        return list(units.items())
    for wanted in columns:
        if wanted not in units:
            raise ForeignLogError(name, no_column(wanted, list(units)))
    taken = []
    for title, own in units.items():
        if title in columns:
            unit = columns[title]
            taken.append((title, own if unit is None else unit))
    return taken


def listed(names: list[str] | tuple[str, ...]) -> str:
    """Return the first names, in quotation marks."""
    words = ", ".join(f"“{name[:40]}”" for name in names[:20])
    return words + (", …" if len(names) > 20 else "")


def no_column(wanted: str, names: list[str] | tuple[str, ...]) -> Text:
    """Return the problem of a column that is not there."""
    return Text(
        f"there is no column “{wanted[:40]}”; there are: {listed(names)}",
        f"столбца «{wanted[:40]}» нет; есть: {listed(names)}",
    )
