"""Logs of text: CSV of any kind, and MegaLogViewer's .msl, which has marks between its rows."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isnan, nan
from typing import Final

from mikas.errors import ForeignLogError
from mikas.foreign_logs.choice import LogChoice, LogPreview, PreviewColumn
from mikas.foreign_logs.layout import TextLayout, TextSettings, layout_of
from mikas.foreign_logs.table import (
    ForeignLog,
    ForeignMark,
    ForeignProblem,
    TableBuilder,
    date_of,
)
from mikas.foreign_logs.text import Numbers, cells_of, decoded
from mikas.foreign_logs.times import DATES, TIME_UNITS, reader_of
from mikas.foreign_logs.wanted import listed, no_column, taken_of
from mikas.i18n import Text

CSV: Final = "csv"
MSL: Final = "msl"
_SAMPLES: Final = 3
_MARK: Final = re.compile(r"MARK\b\s*(?:\d+\s*)?(?:-\s*)?(.*)", re.DOTALL)
_MOST_MARKS: Final = 10_000


def preview(data: bytes, name: str, kind: str, settings: TextSettings) -> LogPreview:
    """Return what the log has. Raises `ForeignLogError`."""
    _, layout = _laid_out(data, name, kind, settings)
    columns = tuple(
        PreviewColumn(title, unit, tuple(row[at] for row in layout.rows[:_SAMPLES]))
        for at, (title, unit) in enumerate(zip(layout.names, layout.units, strict=True))
    )
    return LogPreview(kind, columns, layout)


def read(data: bytes, name: str, kind: str, choice: LogChoice) -> ForeignLog:
    """Return the table. Raises `ForeignLogError`."""
    text, layout = _laid_out(data, name, kind, choice.text)
    time, unit = _time(layout, choice, name)
    taken = _taken(layout, time, choice.columns, name)
    numbers = Numbers(layout.decimal)
    table = TableBuilder(name, [(layout.names[at], unit_of) for at, unit_of in taken])
    columns = [_Cells(at) for at, _ in taken]
    time_of = reader_of(unit, numbers)
    marks: list[str] = []
    found: list[ForeignMark] = []
    width = len(layout.names)
    for line, cells in cells_of(text, layout.delimiter, name):
        if line <= layout.begins_after:
            continue
        if kind == MSL and (mark := _mark_in(cells)) is not None:
            if len(marks) + len(found) < _MOST_MARKS:
                marks.append(mark)
            continue
        if len(cells) > width and any(cells[width:]):
            raise ForeignLogError(name, _wider(len(cells), width), line=line)
        time_cell = cells[time] if time < len(cells) else ""
        seconds = time_of(time_cell)
        before = len(table.times)
        table.add(seconds, [column.read(cells, line, numbers) for column in columns], line)
        if marks and len(table.times) > before:
            found += [ForeignMark(seconds, words) for words in marks]
            marks.clear()
    table.check()
    found += [ForeignMark(table.times[-1], words) for words in marks]
    problems = table.skipped()
    kept = []
    for column, cells_read in zip(table.columns(), columns, strict=True):
        wordy = cells_read.problem(column.name)
        if wordy is not None:
            problems.append(wordy)
        if choice.columns is not None or wordy is None or not all(map(isnan, column.values)):
            kept.append(column)
    started = date_of(table.times[0]) if unit in DATES else None
    return ForeignLog(name, kind, table.times, tuple(kept), started, tuple(found), tuple(problems))


def _laid_out(data: bytes, name: str, kind: str, settings: TextSettings) -> tuple[str, TextLayout]:
    text, encoding = decoded(data, name, settings.encoding)
    if kind == MSL and settings.delimiter is None:
        settings = TextSettings(
            settings.encoding, "\t", settings.decimal, settings.names_line, settings.units_line
        )
    plain = "s" if kind == MSL else None  # TunerStudio's logs count seconds
    return text, layout_of(text, name, encoding, settings, plain_time=plain)


def _time(layout: TextLayout, choice: LogChoice, name: str) -> tuple[int, str]:
    """Return the column of the time and its unit. Raises `ForeignLogError` where it is open."""
    time = layout.time
    if choice.time is not None:
        if choice.time not in layout.names:
            raise ForeignLogError(name, no_column(choice.time, layout.names))
        time = layout.names.index(choice.time)
    if time is None:
        raise ForeignLogError(name, _which_time(layout.names))
    unit = choice.time_unit or (layout.time_unit if time == layout.time else None)
    if unit is None or unit not in TIME_UNITS:
        raise ForeignLogError(name, _which_unit(layout.names[time], unit))
    return time, unit


def _taken(
    layout: TextLayout, time: int, columns: Mapping[str, str | None] | None, name: str
) -> list[tuple[int, str]]:
    """Return the place and the unit of each column to take, in the file's order."""
    places = {title: at for at, title in enumerate(layout.names)}
    units = dict(zip(layout.names, layout.units, strict=True))
    if columns is None:
        del units[layout.names[time]]
    return [(places[title], unit) for title, unit in taken_of(units, columns, name)]


@dataclass(slots=True)
class _Cells:
    """Reads one column's cells; those that are no numbers are counted."""

    at: int
    bad: int = 0
    line: int = 0
    cell: str = ""

    def read(self, cells: Sequence[str], line: int, numbers: Numbers) -> float:
        if self.at >= len(cells):
            return nan
        value = numbers(cells[self.at])
        if value is not None:
            return value
        if not self.bad:
            self.line, self.cell = line, cells[self.at][:40]
        self.bad += 1
        return nan

    def problem(self, name: str) -> ForeignProblem | None:
        if not self.bad:
            return None
        text = Text(
            f"{name}: cells that are no number, left empty: {self.bad}; the first in line "
            f"{self.line}: “{self.cell}”",
            f"{name}: ячейки не с числом, оставлены пустыми: {self.bad}; первая — строка "
            f"{self.line}: «{self.cell}»",
        )
        return ForeignProblem(text, self.line)


def _mark_in(cells: Sequence[str]) -> str | None:
    if not cells[0].startswith("MARK") or any(cells[1:]):
        return None
    found = _MARK.fullmatch(cells[0])
    return found.group(1).strip() if found else None


def _which_time(names: tuple[str, ...]) -> Text:
    there = listed(names)
    return Text(
        f"say which column is the time: {there.en}",
        f"укажите, какой столбец — время: {there.ru}",
    )


def _which_unit(name: str, unit: str | None) -> Text:
    known = ", ".join(TIME_UNITS)
    if unit is not None:
        return Text(
            f"there is no unit of time “{unit[:40]}”; there are: {known}",
            f"единицы времени «{unit[:40]}» нет; есть: {known}",
        )
    return Text(
        f"say in what the column “{name[:40]}” counts the time: {known}",
        f"укажите, в чём столбец «{name[:40]}» считает время: {known}",
    )


def _wider(cells: int, width: int) -> Text:
    return Text(
        f"{cells} cells here, but {width} columns: the delimiter or the line of the titles is "
        "another one, or the line is damaged",
        f"здесь ячеек {cells}, а столбцов {width}: разделитель или строка названий другие, либо "
        "строка повреждена",
    )
