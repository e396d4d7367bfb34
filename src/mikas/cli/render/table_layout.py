"""Layout of the live table: fewer columns on a narrow terminal, two tables on a low one.

Rows that still do not fit are named in the last line: no value disappears silently.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mikas.cli.language import tr
from mikas.cli.render.terminal import cell_text

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

UNLIMITED = 1 << 20  # lines of a table that is printed once and may scroll
_GAP = 2  # between columns
_BETWEEN = 3  # between tables
_HEAD = 3  # lines without a parameter: the state, the headings, Ctrl-C


@dataclass(frozen=True, slots=True)
class Head:
    """The lines around the rows: the state, the alarms, the latest notice."""

    state: str
    style: str
    alarms: str = ""
    notice: str = ""


@dataclass(frozen=True, slots=True)
class Row:
    """One channel as texts; `style` is the value's."""

    name: str
    value: str
    unit: str
    reference: str
    lowest: str
    highest: str
    meaning: str
    curve: str
    style: str = ""


@dataclass(frozen=True, slots=True)
class _Column:
    """`narrowest`: left out if there is less room; 0: as wide as its cells. `right`: alignment."""

    title: str
    cell: Callable[[Row], str]
    narrowest: int = 0
    right: bool = False
    min_length: int = 0  # keeps the table from jumping with every digit
    spare: bool = False  # left out if it would be empty

    def words(self, row: Row) -> str:
        """Return the cell's text, escaped, on one line."""
        return cell_text(self.cell(row))


def _columns() -> list[_Column]:
    """Return all columns, the most important first; the first three are never left out."""
    return [
        _Column(tr("name", "имя"), lambda row: row.name),
        _Column(tr("value", "значение"), lambda row: row.value, right=True, min_length=6),
        _Column(tr("unit", "ед."), lambda row: row.unit),
        _Column(tr("warm idle", "на ХХ"), lambda row: row.reference, spare=True),
        _Column(tr("meaning", "параметр"), lambda row: row.meaning, narrowest=20),
        _Column(tr("min", "мин"), lambda row: row.lowest, right=True, min_length=6),
        _Column(tr("max", "макс"), lambda row: row.highest, right=True, min_length=6),
        _Column(tr("trend", "график"), lambda row: row.curve, min_length=20),
    ]


_ORDER = (0, 1, 2, 5, 6, 7, 3, 4)  # from left to right
_NEEDED = 3
_VALUE = 1  # the column with the row's style


def draw(head: Head, rows: Sequence[Row], width: int, height: int) -> RenderableType:
    """Return `head`, then `rows`, in `width` by `height` characters."""
    from rich.console import Group
    from rich.table import Table

    room = max(1, height - _HEAD - bool(head.alarms))
    tables = _tables(rows, width, room)
    shown_rows, left_out = rows[: tables * room], rows[tables * room :]
    each = -(-len(shown_rows) // tables) if shown_rows else 0
    grid = Table.grid(padding=(0, _BETWEEN, 0, 0))
    parts = [shown_rows[start : start + each] for start in range(0, len(shown_rows), each or 1)]
    inner = (width + _BETWEEN) // tables - _BETWEEN
    if parts:
        grid.add_row(*(_table(part, rows, inner) for part in parts))
    names = " ".join(row.name for row in left_out)
    end = tr("Ctrl-C ends it", "Выход: Ctrl-C")
    if names:
        end = tr(f"No room for {names}", f"Не поместились: {names}")
    elif head.notice:
        end = f"{head.notice} {end}"
    above = [_line(head.state, head.style)]
    if head.alarms:
        above.append(_line(head.alarms, "bold red"))
    return Group(*above, grid) if height == UNLIMITED else Group(*above, grid, _line(end, "dim"))


def _line(text: str, style: str) -> RenderableType:
    from rich.text import Text as RichText

    return RichText(cell_text(text), style=style, no_wrap=True, overflow="ellipsis")


def _tables(rows: Sequence[Row], width: int, room: int) -> int:
    """Return the number of tables side by side: as few as show all rows, at most what fits."""
    least = sum(_width(column, rows) + _GAP for column in _columns()[:_NEEDED]) - _GAP
    most = max(1, (width + _BETWEEN) // (least + _BETWEEN))
    return min(most, max(1, -(-len(rows) // room)))


def _width(column: _Column, rows: Sequence[Row]) -> int:
    longest = max((len(column.words(row)) for row in rows), default=0)
    return max(longest, len(column.title), column.min_length)


def _table(part: Sequence[Row], rows: Sequence[Row], width: int) -> Table:
    """Return a table of `part`, with columns as wide as all `rows` need."""
    from rich.table import Table
    from rich.text import Text as RichText

    columns, free = _columns(), width
    chosen: dict[int, int] = {}
    for index, column in enumerate(columns):
        wanted = _width(column, rows)
        needed = min(wanted, column.narrowest or wanted) + (_GAP if chosen else 0)
        empty = column.spare and not any(column.words(row) for row in rows)
        if index >= _NEEDED and (needed > free or empty):
            continue
        chosen[index] = needed - (_GAP if chosen else 0)
        free -= needed
    for index, given in list(chosen.items()):  # the rest of the width
        wider = min(_width(columns[index], rows) - given, free)
        chosen[index] = given + wider
        free -= wider
    table = Table(box=None, pad_edge=False, padding=(0, _GAP, 0, 0), header_style="bold")
    for index in _ORDER:
        if index in chosen:
            column = columns[index]
            table.add_column(
                column.title,
                justify="right" if column.right else "left",
                width=chosen[index],
                no_wrap=True,
                overflow="ellipsis",
            )
    for row in part:
        table.add_row(
            *(
                RichText(columns[i].words(row), style=row.style if i == _VALUE else "")
                for i in _ORDER
                if i in chosen
            )
        )
    return table
