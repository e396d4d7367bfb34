"""How a log of text is laid out: what was recognised, and what the user says of it.

    settings = TextSettings(delimiter=";")        # what the user knows; the rest is recognised
    layout = layout_of(text, "drive.csv", settings)

Titles stand in the last row of words before the first row of values; a row of words between both
has the units. A title's last brackets are its unit (`Time (msec)`) where they hold one short word.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import isnan
from typing import Final

from mikas.errors import ForeignLogError
from mikas.foreign_logs.table import unique
from mikas.foreign_logs.text import (
    DECIMALS,
    Numbers,
    check_delimiter,
    decimal_of,
    delimiter_of,
    sample_of,
)
from mikas.foreign_logs.times import CLOCK, DATES, form_of, unit_spelt
from mikas.i18n import Text

_UNIT: Final = re.compile(r"(.*\S)\s*[(\[]\s*([^()\[\]\s]{1,12})\s*[)\]]")
_TIMES: Final = ("time", "время", "timestamp", "date", "дата", "datetime", "zeit")
_LONGEST_NAME: Final = 200


@dataclass(frozen=True, slots=True)
class TextSettings:
    """What the user says of a log of text; None: recognise it."""

    encoding: str | None = None
    """utf-8, windows-1251, utf-16 or windows-1252."""
    delimiter: str | None = None
    """One character; a blank stands for several."""
    decimal: str | None = None
    """The decimal sign, `.` or `,`."""
    names_line: int | None = None
    """The line of the titles, from 1; 0: there is none."""
    units_line: int | None = None
    """The line of the units, from 1; 0: there is none."""


@dataclass(frozen=True, slots=True)
class TextLayout:
    """How a log of text is laid out."""

    encoding: str
    """As in `TextSettings`."""
    delimiter: str
    """Between two cells."""
    decimal: str
    """The decimal sign."""
    names_line: int
    """The line of the titles; 0: none."""
    units_line: int
    """The line of the units; 0: none, or they stand in the titles."""
    names: tuple[str, ...]
    """Of all columns, all different."""
    units: tuple[str, ...]
    """Of all columns; empty: none."""
    time: int | None
    """The column of the time, if only one can be; None: the user has to say."""
    time_unit: str | None
    """Its unit, if the file says it; None: the user has to say."""
    rows: tuple[tuple[str, ...], ...] = field(repr=False, default=())
    """The first rows of values, as in the file."""

    @property
    def begins_after(self) -> int:
        """The line after which the values begin."""
        return max(self.names_line, self.units_line)


def layout_of(
    text: str, name: str, encoding: str, settings: TextSettings, *, plain_time: str | None = None
) -> TextLayout:
    """Return how the text is laid out. Raises `ForeignLogError`.

    `plain_time`: the unit of a column `Time` whose unit the file does not say.
    """
    delimiter = settings.delimiter or delimiter_of(text, name)
    check_delimiter(delimiter, name)
    sample = sample_of(text, delimiter, name)
    if not sample:
        raise ForeignLogError(name, Text("the file has no rows", "в файле нет строк"))
    decimal = settings.decimal or decimal_of(sample, delimiter)
    if decimal not in DECIMALS or decimal == delimiter:
        raise ForeignLogError(name, _DECIMAL)
    number = Numbers(decimal)
    first = _first_values(sample, number)
    names_line, units_line = _headings(sample[:first], sample[first:], settings)
    by_line = dict(sample)
    values = [cells for line, cells in sample[first:] if line > max(names_line, units_line)]
    titles = _cells(by_line, names_line, name)
    units = _cells(by_line, units_line, name)
    if not values:
        raise ForeignLogError(name, _NO_VALUES)
    widths = [len(cells) for cells in values]
    width = max(set(widths), key=widths.count)
    width = max(width, len(titles))
    while width and not _is_used(width - 1, titles, values):
        width -= 1
    names, found = _split(_filled(titles, width), _filled(units, width), in_titles=not units_line)
    time, time_unit = _time_of(names, found, values, plain_time)
    return TextLayout(
        encoding, delimiter, decimal, names_line, units_line, tuple(unique(names)), tuple(found),
        time, time_unit, tuple(tuple(_filled(cells, width)) for cells in values),
    )  # fmt: skip


def _is_value(cell: str, number: Numbers) -> bool:
    value = number(cell)
    return (value is not None and not isnan(value)) or form_of([cell]) is not None


def _first_values(sample: Sequence[tuple[int, list[str]]], number: Numbers) -> int:
    """Return the place of the first row of values: half of its cells are numbers or times, and it
    is as wide as the rows usually are.

    Rows right before it that have nothing but values are of them, too: a program may leave out the
    empty cells at the end of a row.
    """
    widths = [len(cells) for _, cells in sample]
    tail = widths[len(widths) // 2 :]
    usual = max(set(tail), key=tail.count)
    first = len(sample)
    for at, (_, cells) in enumerate(sample):
        filled = [cell for cell in cells if cell]
        values = sum(_is_value(cell, number) for cell in filled)
        if len(cells) == usual and filled and 2 * values >= len(filled):
            first = at
            break
    while 0 < first < len(sample) and _is_all_values(sample[first - 1][1], number):
        first -= 1
    return first


def _is_all_values(cells: Sequence[str], number: Numbers) -> bool:
    return all(_is_value(cell, number) for cell in cells if cell)


def _headings(
    above: Sequence[tuple[int, list[str]]],
    below: Sequence[tuple[int, list[str]]],
    settings: TextSettings,
) -> tuple[int, int]:
    """Return the lines of the titles and of the units."""
    width = len(below[0][1]) if below else 0
    near = [(line, cells) for line, cells in above if len(cells) >= max(1, width - 1)][-2:]
    names, units = 0, 0
    if len(near) == 2 and len(near[0][1]) > 1:
        names, units = near[0][0], near[1][0]
    elif near:
        names = near[-1][0]
    if settings.names_line is not None:
        names = settings.names_line
        units = units if units > names else 0
    if settings.units_line is not None:
        units = settings.units_line
    return names, units


def _cells(by_line: dict[int, list[str]], line: int, name: str) -> list[str]:
    if line == 0:
        return []
    if line not in by_line:
        raise ForeignLogError(
            name,
            Text(
                "there are no titles or units in this line: give another one, or 0 for none",
                "в этой строке нет названий или единиц: укажите другую, или 0, если их нет",
            ),
            line=max(1, line),
        )
    return [" ".join(cell.split())[:_LONGEST_NAME] for cell in by_line[line]]


def _filled(cells: Sequence[str], width: int) -> list[str]:
    return [*cells[:width], *[""] * (width - len(cells))]


def _is_used(at: int, titles: Sequence[str], values: Sequence[Sequence[str]]) -> bool:
    return any(at < len(cells) and cells[at] for cells in (titles, *values))


def _split(titles: list[str], units: list[str], *, in_titles: bool) -> tuple[list[str], list[str]]:
    """Return names and units; titles that differ only in their brackets stay as they are."""
    if not in_titles:
        return titles, units
    pairs = [found.groups() if (found := _UNIT.fullmatch(it)) else (it, "") for it in titles]
    counts = Counter(name for name, _ in pairs)
    alone = [counts[name] == 1 for name, _ in pairs]
    names = [pair[0] if one else it for pair, one, it in zip(pairs, alone, titles, strict=True)]
    return names, [pair[1] if one else "" for pair, one in zip(pairs, alone, strict=True)]


def _time_of(
    names: Sequence[str],
    units: Sequence[str],
    rows: Sequence[Sequence[str]],
    plain_time: str | None,
) -> tuple[int | None, str | None]:
    """Return the column and the unit of the time, where the file itself leaves no choice."""
    called = [at for at, name in enumerate(names) if name.casefold() in _TIMES]
    if len(called) != 1:
        return None, None
    (at,) = called
    unit = unit_spelt(units[at])
    form = form_of(row[at] for row in rows if at < len(row))
    if unit is None and form in (CLOCK, *DATES):
        unit = form
    return at, unit or (plain_time if not units[at] else None)


_NO_VALUES: Final = Text(
    "no row of numbers was found: give another delimiter, decimal sign or encoding, or the line of "
    "the titles",
    "не найдено ни одной строки с числами: укажите другой разделитель, десятичный знак или "
    "кодировку, либо строку названий",
)
_DECIMAL: Final = Text(
    "the decimal sign is a point or a comma, and not the delimiter",
    "десятичный знак — точка или запятая, и не тот же, что разделитель",
)
