"""What was changed in which unit, one line of JSON each, appended and never rewritten."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from mikas.errors import JournalError, reason_of


class Journal:
    """A file of changes. Each is written twice: before it is made, and with its outcome after.

    So a change whose outcome nobody saw (a pulled plug, a killed process) still stands there.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    def write(self, entry: dict[str, Any]) -> None:
        """Appends `entry`. Raises `JournalError`; before a change that means: it is not made."""
        line = json.dumps(entry, ensure_ascii=False) + "\n"
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            # A port's name may hold what is no Unicode; \udc80 is how JSON writes that.
            with self.path.open("a", encoding="utf-8", errors="backslashreplace") as file:
                file.write(line)
        except OSError as error:
            raise JournalError(file=str(self.path), problem=reason_of(error)) from error


def default_path() -> Path:
    """In the user's state folder."""
    from platformdirs import user_state_path

    return user_state_path("mikas", appauthor=False) / "journal.jsonl"
