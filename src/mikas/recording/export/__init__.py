"""Recordings as files for other programs, a module a format (docs/exports.md)."""

from mikas.recording.export.exporting import Result, export
from mikas.recording.export.formats import DIALECTS, EXCEL, PLAIN, SUFFIXES, Dialect

__all__ = ["DIALECTS", "EXCEL", "PLAIN", "SUFFIXES", "Dialect", "Result", "export"]
