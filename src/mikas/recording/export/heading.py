"""The two lines that MegaLogViewer's files begin with: what made the file, and when.

TunerStudio writes exactly two, and some readers of its files count on that; so both texts of every
channel stand in the first one, after the program and what is known of the recording.
"""

from __future__ import annotations

from datetime import UTC
from importlib.metadata import version

from mikas.recording.export.sheet import Sheet

_DAYS = ("Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun")
_MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")


def program() -> str:
    """Who made the file, with its version."""
    return f"mikas {version('mikas')}"


def heading(sheet: Sheet) -> tuple[str, str]:
    """Both lines, without their quotation marks and free of any."""
    facts = [f"{title}: {text}" for title, text in sheet.about.items()]
    facts += [f"{c.name} = {c.text.en} / {c.text.ru}" for c in sheet.channels]
    first = f"{program()}: {'; '.join(facts)}"
    return " ".join(first.replace('"', "'").split()), f"Capture Date: {_date(sheet)}"


def _date(sheet: Sheet) -> str:
    """As TunerStudio has it, in English whatever the computer's language."""
    if sheet.started is None:
        return "unknown"
    at = sheet.started.astimezone(UTC)
    return f"{_DAYS[at.weekday()]} {_MONTHS[at.month - 1]} {at:%d %H:%M:%S} UTC {at.year}"
