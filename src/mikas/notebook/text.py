"""An overview as plain text, for a console and for `print`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from mikas.cleaning import clean_line
from mikas.notebook.wording import Wording

_WIDEST: Final = 44  # characters of a channel's text


def text_of(wording: Wording) -> str:
    """Return the overview, one fact or list entry a line."""
    return "\n".join(clean_line(line).rstrip() for line in _lines(wording))


def _lines(wording: Wording) -> Iterator[str]:
    yield wording.title
    width = max((len(title) for title, _ in wording.facts), default=0)
    for title, text in wording.facts:
        yield f"  {title:<{width}}  {text}"
    for each in wording.lists:
        yield each.title
        yield from (f"  {line}" for line in each.lines)
        if each.more:
            yield f"  {each.more}"
    if not wording.rows:
        return
    table = [wording.headings, *(row.cells for row in wording.rows)]
    cells = [[cell[:_WIDEST] for cell in row] for row in table]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for row in cells:
        name, text, unit, *numbers = (
            f"{cell:<{width}}" if at < 3 else f"{cell:>{width}}"
            for at, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        yield "  ".join((name, text, unit, *numbers))
