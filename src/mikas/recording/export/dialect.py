"""The two dialects of CSV: none is read by every program."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Dialect:
    """`mark`: the file begins with a byte order mark, so that Excel reads it as UTF-8."""

    separator: str = ","
    decimal: str = "."
    mark: bool = False


# RomRaider's own logs, their readers, LibreOffice, pandas, an English Excel. A mark would hide the
# word `Time` that such readers look for at the file's start.
PLAIN = Dialect()

# Excel where the comma is the decimal sign (Russia, most of Europe), opened with a double click.
EXCEL = Dialect(separator=";", decimal=",", mark=True)

DIALECTS = {"plain": PLAIN, "excel": EXCEL}
