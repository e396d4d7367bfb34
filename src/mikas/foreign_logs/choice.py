"""The user's choice of a log's columns, and the preview that it is made from.

preview = preview_log(data, "drive.csv")      # columns, settings found, first rows
log = read_log(data, "drive.csv", LogChoice(time="t", time_unit="ms", columns={"RPM": "rpm"}))
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from mikas.foreign_logs.layout import TextLayout, TextSettings


@dataclass(frozen=True, slots=True)
class PreviewColumn:
    """A column of a log, before it is read."""

    name: str
    """As in the file."""
    unit: str
    """As in the file; empty: none."""
    samples: tuple[str, ...]
    """Its first cells, as in the file."""


@dataclass(frozen=True, slots=True)
class LogPreview:
    """What a log has, before it is read."""

    format: str
    """csv, msl, mlg or mdf."""
    columns: tuple[PreviewColumn, ...]
    """All columns; those of a log of text contain the time."""
    layout: TextLayout | None = None
    """How a log of text is laid out; None: it is none, and has a time of its own."""


@dataclass(frozen=True, slots=True)
class LogChoice:
    """What the user wants of a log."""

    text: TextSettings = field(default=TextSettings())
    """What is said of a log of text."""
    time: str | None = None
    """The column of the time; None: the one that the file itself leaves no doubt of."""
    time_unit: str | None = None
    """One of `TIME_UNITS`; None: the one that the file says."""
    columns: Mapping[str, str | None] | None = None
    """The columns to take, each with its unit (None: the file's); None: all that hold numbers."""
