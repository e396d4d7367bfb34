"""Logs of other programs as tables: CSV, MegaLogViewer's .msl and .mlg, MDF4.

Bytes in, a table out, with the file's own names and units. Nothing is guessed: what the file leaves
open (which column is the time, what it counts) the user says, by arguments or in a dialog made of
`preview_log`. A wrong file is a `ForeignLogError` with its line or byte.
"""

from mikas.foreign_logs.choice import LogChoice, LogPreview, PreviewColumn
from mikas.foreign_logs.layout import TextLayout, TextSettings
from mikas.foreign_logs.opening import format_of, open_log, preview_log, read_log
from mikas.foreign_logs.table import (
    MOST_BYTES,
    ForeignColumn,
    ForeignLog,
    ForeignMark,
    ForeignProblem,
)
from mikas.foreign_logs.text import ENCODINGS
from mikas.foreign_logs.times import TIME_UNITS

__all__ = [
    "ENCODINGS",
    "MOST_BYTES",
    "TIME_UNITS",
    "ForeignColumn",
    "ForeignLog",
    "ForeignMark",
    "ForeignProblem",
    "LogChoice",
    "LogPreview",
    "PreviewColumn",
    "TextLayout",
    "TextSettings",
    "format_of",
    "open_log",
    "preview_log",
    "read_log",
]
