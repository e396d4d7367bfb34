"""CSV as RomRaider's logger writes it, which spreadsheets read as well.

One header line, `Time (msec),TWAT Coolant temperature (°C),…`; a column's unit in parentheses at
its end; milliseconds since the start, as a whole number; a missing value is an empty cell. UTF-8.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mikas.recording.export.sheet import Sheet, lines, spelled, without
from mikas.recording.table.channels import Channel


def write(path: Path, sheet: Sheet) -> None:
    """Write the whole sheet, as its dialect has it."""
    dialect = sheet.dialect
    with path.open("wb") as file:
        if dialect.mark:
            file.write(b"\xef\xbb\xbf")
        header = ["Time (msec)", *(_title(channel, sheet) for channel in sheet.channels)]
        file.write(lines([[cell] for cell in header], dialect.separator))
        for times, columns in sheet.stretches:
            cells = [list(map(str, np.rint(times * 1000).astype(np.int64).tolist()))]
            for channel, values in zip(sheet.channels, columns, strict=True):
                cells.append(spelled(channel, values, missing="", decimal=dialect.decimal))
            file.write(lines(cells, dialect.separator))


def _title(channel: Channel, sheet: Sheet) -> str:
    unit = f"({channel.unit})" if channel.unit else ""
    title = f"{channel.name} {channel.text.to(sheet.language)} {unit}"
    return without(title, sheet.dialect.separator, '"')
