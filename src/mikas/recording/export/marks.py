"""Marks between the rows, as TunerStudio sets them into a log: `MARK 000 - what it says`.

MegaLogViewer draws a line there, with the words. A mark has no time of its own: it stands before
the first row that is not older. Where times run back, another session in the same file, it stands
at the first place that fits.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from mikas.recording.export.cells import without
from mikas.recording.export.sheet import Column, Sheet


class Mark(NamedTuple):
    """`text` as it stands in the file; `time` in seconds, as the rows'."""

    text: str
    time: float


class Piece(NamedTuple):
    """Rows between two marks; never empty."""

    times: Column
    columns: list[Column]


def marked(sheet: Sheet) -> Iterator[Piece | Mark]:
    """The rows with the marks between them, in the sheet's language."""
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
