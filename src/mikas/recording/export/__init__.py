"""Recordings as files for other programs, a module a format (docs/reference/exports.md)."""

from mikas.recording.export.dialects import DIALECTS, EXCEL, PLAIN, Dialect
from mikas.recording.export.exporting import (
    SUFFIXES,
    TRACKS,
    Result,
    Writer,
    export,
    formats,
    with_position,
)

__all__ = [
    "DIALECTS",
    "EXCEL",
    "PLAIN",
    "SUFFIXES",
    "TRACKS",
    "Dialect",
    "Result",
    "Writer",
    "export",
    "formats",
    "with_position",
]
