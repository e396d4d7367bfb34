"""Recordings as files for other programs; each format has its module (docs/exports.md)."""

from mikas.recording.export.dialect import DIALECTS, EXCEL, PLAIN, Dialect
from mikas.recording.export.exporting import SUFFIXES, Result, export

__all__ = ["DIALECTS", "EXCEL", "PLAIN", "SUFFIXES", "Dialect", "Result", "export"]
