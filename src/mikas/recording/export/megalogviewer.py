"""MegaLogViewer's text log (.msl) as TunerStudio writes it, and the parts that .mlg shares with it.

Tab separated: two quoted lines, the fields' names, their units, the data; the first field is `Time`
in seconds with three decimals, values have all their digits. A missing value is `NaN`: some readers
take an empty field for a zero, and lose it at a line's end. Some readers rely on exactly two quoted
lines, so mnemonic and both texts of every channel are in the first one, after the program and the
facts of the recording.

A field has the name that TunerStudio gives it (RPM, CLT, TPS …: `catalog/names.toml`), by which the
viewer's own views find it, unless another channel of the log has that name.

A mark, `MARK 000 - words` between two rows, is a marker, a note, a gap or an alarm; MegaLogViewer
draws a line there. A mark has no time of its own: it precedes the first row that is not older.
Where times run back (another session in the same file) it is at the first place that fits.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mikas.catalog.synonyms import names_of, normal
from mikas.cleaning import spreadsheet_text
from mikas.recording.export.csv import formatted, lines
from mikas.recording.export.sheet import Column, Sheet, program, without
from mikas.recording.table.channels import Channel


class LogMark(NamedTuple):
    """`text` as in the file; `time` in seconds, as the rows'.

    `brief`: the text for little room; empty: there is none.
    """

    text: str
    time: float
    brief: str = ""


class Piece(NamedTuple):
    """Rows between two marks; never empty."""

    times: Column
    columns: list[Column]


def write(path: Path, sheet: Sheet) -> None:
    """Write the whole sheet as a text log."""
    units = (channel.unit for channel in sheet.channels)
    fields = (("Time", "s"), *zip(field_names(sheet.channels), units, strict=True))
    with path.open("wb") as file:
        file.write(heading(sheet))
        for line in zip(*fields, strict=True):
            file.write(lines([[spreadsheet_text(without(cell, '"'))] for cell in line], "\t"))
        for piece in marked(sheet):
            if isinstance(piece, LogMark):
                file.write(f"{piece.text}\n".encode())
                continue
            times = [f"{time:z.3f}" for time in piece.times.tolist()]
            columns = (formatted(values, missing="NaN") for values in piece.columns)
            file.write(lines([times, *columns], "\t"))


def heading(sheet: Sheet) -> bytes:
    """Return both lines in quotation marks, with none inside."""
    facts = [f"{title}: {text}" for title, text in sheet.about.items()]
    for name, c in zip(field_names(sheet.channels), sheet.channels, strict=True):
        names = c.name if name == c.name else f"{name} = {c.name}"
        facts.append(f"{names} = {c.text.en} / {c.text.ru}")
    first = without(f"{program()}: {'; '.join(facts)}".replace('"', "'"))
    return f'"{first}"\n"Capture Date: {_date(sheet)}"\n'.encode()


def field_names(channels: Iterable[Channel]) -> list[str]:
    """Return the fields' names."""
    own = {normal(channel.name) for channel in channels}
    logs = ((channel.name, names_of(channel.name).log) for channel in channels)
    return [log if log and normal(log) not in own else name for name, log in logs]


def _date(sheet: Sheet) -> str:
    """Return the date in TunerStudio's form, in English on any computer."""
    if sheet.started is None:
        return "unknown"
    weekday, month, day, clock, year = sheet.started.ctime().split()
    return f"{weekday} {month} {day:0>2} {clock} UTC {year}"


def marked(sheet: Sheet) -> Iterator[Piece | LogMark]:
    """Yield the rows with the marks between them, in the sheet's language."""
    waiting = deque(
        LogMark(
            f"MARK {number:03d} - {without(moment.text.to(sheet.language))}",
            moment.time,
            f"MARK {number:03d} - {without(moment.brief)}" if moment.brief else "",
        )
        for number, moment in enumerate(sheet.moments)
    )
    for times, columns in sheet.batches():
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
