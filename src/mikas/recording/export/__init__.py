"""Recordings as files for other programs, a module a format (docs/reference/exports.md)."""

from mikas.recording.export.exporting import (
    DIALECTS,
    EXCEL,
    PLAIN,
    SUFFIXES,
    Dialect,
    Result,
    export,
)

__all__ = ["DIALECTS", "EXCEL", "PLAIN", "SUFFIXES", "Dialect", "Result", "export"]
