"""The dialects of CSV."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Dialect:
    """A form of CSV."""

    separator: str = ","
    """Between two cells."""
    decimal: str = "."
    """The decimal sign."""
    mark: bool = False
    """Begin the file with a byte order mark, by which Excel recognises UTF-8."""


# For RomRaider's readers of logs, LibreOffice, pandas and an English Excel. These readers expect
# the word `Time` at the file's start, where a mark would be.
PLAIN = Dialect()

# For Excel where the comma is the decimal sign (Russia, most of Europe), opened by a double click.
EXCEL = Dialect(separator=";", decimal=",", mark=True)

DIALECTS = {"plain": PLAIN, "excel": EXCEL}
