"""What MegaLogViewer's two formats share: the two lines at the beginning, marks between the rows.

TunerStudio writes exactly two lines, and some readers of its files rely on that; so both texts of
every channel are in the first one, after the program and the facts of the recording.

A mark (`MARK 000 - words`) is as TunerStudio sets it into a log; MegaLogViewer draws a line there.
It has no time of its own: it is before the first row that is not older. Where times run back
(another session in the same file) it is at the first place that fits.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from datetime import UTC
from typing import NamedTuple

import numpy as np

from mikas.recording.export.sheet import Column, Sheet, program, without

_DAYS = ("Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun")
_MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")


def heading(sheet: Sheet) -> tuple[str, str]:
    """Return both lines, without quotation marks around or in them."""
    facts = [f"{title}: {text}" for title, text in sheet.about.items()]
    facts += [f"{c.name} = {c.text.en} / {c.text.ru}" for c in sheet.channels]
    first = f"{program()}: {'; '.join(facts)}"
    return " ".join(first.replace('"', "'").split()), f"Capture Date: {_date(sheet)}"


def _date(sheet: Sheet) -> str:
    """Return the date as TunerStudio has it, in English on any computer."""
    if sheet.started is None:
        return "unknown"
    at = sheet.started.astimezone(UTC)
    return f"{_DAYS[at.weekday()]} {_MONTHS[at.month - 1]} {at:%d %H:%M:%S} UTC {at.year}"


class Mark(NamedTuple):
    """`text` as in the file; `time` in seconds, as the rows'."""

    text: str
    time: float


class Piece(NamedTuple):
    """Rows between two marks; never empty."""

    times: Column
    columns: list[Column]


def marked(sheet: Sheet) -> Iterator[Piece | Mark]:
    """Yield the rows with the marks between them, in the sheet's language."""
    waiting = deque(
        Mark(f"MARK {number:03d} - {without(moment.text.to(sheet.language))}", moment.time)
        for number, moment in enumerate(sheet.moments)
    )
    for times, columns in sheet.stretches:
        done = 0
        while waiting:
            later = np.flatnonzero(times[done:] >= waiting[0].time)
            if not later.size:
                break
            at = done + int(later[0])
            if at > done:
                yield Piece(times[done:at], [column[done:at] for column in columns])
            yield waiting.popleft()
            done = at
        if done < len(times):
            yield Piece(times[done:], [column[done:] for column in columns])
    yield from waiting
