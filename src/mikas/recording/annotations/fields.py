"""The fields of a note from a file: each a value of its type and within its bounds, else None.

`capture/notes.py` has cleaned the texts and the numbers of a note. A longer text than a recording
of this program has is cut.
"""

from __future__ import annotations

from typing import Final

from mikas.cleaning import clean_line, is_in_calendar
from mikas.client import Passport
from mikas.commands.unit import PASSPORT_LENGTH
from mikas.i18n import Text
from mikas.recording.capture.reader import FASTEST

LONGEST_LINE: Final = 1000  # characters: of a marker, a reason, a port
LONGEST_COMMENT: Final = 10_000
LONGEST_TEXT: Final = 100_000  # of a note at a moment
_PROGRAM_PIECES: Final = 3  # of a passport; the others are the data's
_PIECES: Final = 8


def line_of(value: object) -> str | None:
    """Return a text on one line, at most `LONGEST_LINE` characters."""
    return clean_line(value, LONGEST_LINE) if isinstance(value, str) else None


def text_of(value: object, limit: int) -> str | None:
    """Return a text of several lines, at most `limit` characters."""
    return value[:limit] if isinstance(value, str) else None


def both_of(value: object) -> Text | None:
    """Return a line in both languages, `{"en", "ru"}`."""
    if not isinstance(value, dict):
        return None
    en, ru = line_of(value.get("en")), line_of(value.get("ru"))
    return None if en is None or ru is None else Text(en, ru)


def number_of(value: object) -> float | None:
    """Return a number."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return float(value)


def time_of(value: object) -> float | None:
    """Return a time of the link's clock, in seconds; one outside the calendar is None."""
    time = number_of(value)
    return time if time is not None and is_in_calendar(abs(time)) else None


def baud_of(value: object) -> int | None:
    """Return a rate of a serial line."""
    if isinstance(value, bool) or not isinstance(value, int):
        return None
    return value if 0 < value <= FASTEST else None


def codes_of(value: object) -> tuple[int, ...] | None:
    """Return a list of fault codes, each at most once."""
    if not isinstance(value, list) or len(value) > 0x100:
        return None
    codes = [code for code in value if isinstance(code, int) and not isinstance(code, bool)]
    is_whole = len(codes) == len(value) and all(0 <= code <= 0xFF for code in codes)
    return tuple(codes) if is_whole else None


def passport_of(value: object) -> Passport | None:
    """Return the pieces of 51–58; a unit gives at most 16 characters for each."""
    if not isinstance(value, list | tuple):
        return None
    pieces = tuple(
        clean_line(piece, PASSPORT_LENGTH) if isinstance(piece, str) else None
        for piece in value[:_PIECES]
    )
    return Passport(pieces[:_PROGRAM_PIECES], pieces[_PROGRAM_PIECES:])
