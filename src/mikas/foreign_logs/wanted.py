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


def listed(names: list[str] | tuple[str, ...]) -> Text:
    """Return the first names, in quotation marks."""
    more = ", …" if len(names) > 20 else ""
    first = [name[:40] for name in names[:20]]
    return Text(
        ", ".join(f"“{name}”" for name in first) + more,
        ", ".join(f"«{name}»" for name in first) + more,
    )


def no_column(wanted: str, names: list[str] | tuple[str, ...]) -> Text:
    """Return the problem of a column that is not there."""
    there = listed(names)
    return Text(
        f"there is no column “{wanted[:40]}”; there are: {there.en}",
        f"столбца «{wanted[:40]}» нет; есть: {there.ru}",
    )
