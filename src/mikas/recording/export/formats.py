"""The export formats by suffix, with the libraries that they need, and the two dialects of CSV."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from mikas.errors import ExportError, MissingExtra
from mikas.i18n import Text


@dataclass(frozen=True, slots=True)
class Dialect:
    """`mark`: begin the file with a byte order mark, by which Excel recognises UTF-8."""

    separator: str = ","
    decimal: str = "."
    mark: bool = False


# For RomRaider's readers of logs, LibreOffice, pandas and an English Excel. These readers expect
# the word `Time` at the file's start, where a mark would be.
PLAIN = Dialect()

# For Excel where the comma is the decimal sign (Russia, most of Europe), opened by a double click.
EXCEL = Dialect(separator=";", decimal=",", mark=True)

DIALECTS = {"plain": PLAIN, "excel": EXCEL}


class Format(NamedTuple):
    """A format's name, its module here, and the library that the extra `mikas[extra]` installs."""

    name: str
    module: str
    extra: str = ""
    library: str = ""


_FORMATS = {
    ".csv": Format("CSV", "csv"),
    ".mf4": Format("MDF4", "mdf", "mdf", "asammdf"),
    ".parquet": Format("Parquet", "parquet", "parquet", "duckdb"),
    ".msl": Format("MegaLogViewer", "megalogviewer"),
    ".mlg": Format("MegaLogViewer", "mlg"),
}

SUFFIXES = tuple(_FORMATS)


def format_of(out: Path) -> Format:
    """Return the format of the suffix. Raises `ExportError` for an unknown suffix."""
    if found := _FORMATS.get(out.suffix.lower()):
        return found
    known = " ".join(SUFFIXES)
    problem = Text(
        f"the suffix must be one of {known}: it selects the format",
        f"формат определяется расширением: {known}",
    )
    raise ExportError(str(out), problem)


def require_library(wanted: Format) -> None:
    """Raise `MissingExtra` if the format's library is not installed."""
    if wanted.library:
        try:
            import_module(wanted.library)
        except ImportError as error:
            raise MissingExtra(feature=wanted.name, extra=wanted.extra) from error
