"""A place in a document, and what is wrong there."""

from __future__ import annotations

from pathlib import PurePosixPath
from typing import NamedTuple


class Finding(NamedTuple):
    """One line of the check's output."""

    file: PurePosixPath
    line: int
    text: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.text}"
