"""CSV as RomRaider's logger writes it, which spreadsheets read as well; text cells for both logs.

One header line, `Time (msec),TWAT Coolant temperature (°C),…`; a column's unit in parentheses at
its end; milliseconds since the start, as a whole number; values with all their digits; a missing
value is an empty cell. UTF-8.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mikas.catalog.conversion import EXACT
from mikas.cleaning import spreadsheet_text
from mikas.recording.export.sheet import Sheet, without
from mikas.recording.table.channels import Channel


def write(path: Path, sheet: Sheet) -> None:
    """Write the whole sheet in its dialect."""
    dialect = sheet.dialect
    with path.open("wb") as file:
        if dialect.mark:
            file.write(b"\xef\xbb\xbf")
        header = ["Time (msec)", *(_title(channel, sheet) for channel in sheet.channels)]
        file.write(lines([[cell] for cell in header], dialect.separator))
        for times, columns in sheet.batches():
            milliseconds = map(str, np.rint(times * 1000).astype(np.int64).tolist())
            cells = (formatted(each, missing="", decimal=dialect.decimal) for each in columns)
            file.write(lines([list(milliseconds), *cells], dialect.separator))


def _title(channel: Channel, sheet: Sheet) -> str:
    unit = channel.unit_in(sheet.language)
    unit = f"({unit})" if unit else ""
    title = f"{channel.name} {channel.text.to(sheet.language)} {unit}"
    return spreadsheet_text(without(title, sheet.dialect.separator, '"'))


def formatted(values: NDArray[np.float64], *, missing: str, decimal: str = ".") -> list[str]:
    """Return `values` as the shortest numbers that read back as the same floats.

    Rounded numbers would not lead back to the raw datum: 0.008 ms is one step of INJ. Never “-0”,
    never an exponent; `missing` for NaN and infinity. A parameter of one byte has 256 different
    values, so each different value is formatted once: about 2 µs a row of 24 columns, not 12 µs.
    """
    different, places = np.unique(values, return_inverse=True)
    texts = np.empty(len(different), object)
    texts[:] = [
        shortest(value).replace(".", decimal) if isfinite(value) else missing
        for value in different.tolist()
    ]
    column: list[str] = texts[places].tolist()
    return column


def shortest(value: float) -> str:
    """Return a finite value as the shortest number that reads back as the same, no exponent."""
    if value.is_integer() and abs(value) < EXACT:
        return str(int(value))
    text = repr(value)
    return np.format_float_positional(value, trim="-") if "e" in text else text


def lines(columns: Sequence[Sequence[str]], separator: str) -> bytes:
    """Return the rows of `columns`, each ended by a line feed."""
    rows = map(separator.join, zip(*columns, strict=True))
    return ("\n".join(rows) + "\n").encode()
