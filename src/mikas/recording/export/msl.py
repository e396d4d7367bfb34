"""MegaLogViewer's text log: tab separated, as TunerStudio writes it.

Two quoted lines, the fields' names, their units, then the data; the first field is `Time`, in
seconds. A missing value is `NaN`: some readers take nothing between two tabs for a zero, and lose
it at a line's end. A line `MARK 000 - …` between the rows is a marker, a note, a gap or an alarm.
"""

from __future__ import annotations

from pathlib import Path

from mikas.i18n import Text
from mikas.recording.export.megalogviewer import Mark, heading, marked
from mikas.recording.export.sheet import Sheet, lines, spelled, without
from mikas.recording.table.channels import Channel

_TIME = Channel("Time", "s", Text("Time", "Время"), decimals=3)


def write(path: Path, sheet: Sheet) -> None:
    """Write the whole sheet."""
    fields = (_TIME, *sheet.channels)
    with path.open("wb") as file:
        file.write("".join(f'"{line}"\n' for line in heading(sheet)).encode())
        file.write(lines([[without(field.name, '"')] for field in fields], "\t"))
        file.write(lines([[without(field.unit, '"')] for field in fields], "\t"))
        for piece in marked(sheet):
            if isinstance(piece, Mark):
                file.write(f"{piece.text}\n".encode())
                continue
            cells = [
                spelled(field, values, missing="NaN")
                for field, values in zip(fields, (piece.times, *piece.columns), strict=True)
            ]
            file.write(lines(cells, "\t"))
