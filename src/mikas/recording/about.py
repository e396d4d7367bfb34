"""A person's words about a whole recording, kept in its file: the last ones count.

They are a note of their own kind behind what is there. Nothing that was recorded is changed, and a
file that goes to somebody else takes its words along.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Final

from mikas.errors import CaptureError, reason_of
from mikas.recording import pcapng
from mikas.recording.note_blocks import block_of
from mikas.recording.notes import Note
from mikas.recording.reader import CaptureReader

KIND: Final = "about"
LONGEST: Final = 10_000


def about_note(time: float, text: str) -> Note:
    """The words of now on."""
    return Note(KIND, time, {"text": text[:LONGEST]})


def about_of(notes: Iterable[Note]) -> str:
    """The words that count; empty if there are none."""
    said = ""
    for note in notes:
        if note.kind == KIND and isinstance(note.data.get("text"), str):
            said = note.data["text"]
    return said


def write_about(path: Path, text: str, time: float) -> None:
    """Puts the words into a recording that nobody writes to any more; whole, or not at all.

    Raises `CaptureError` if it is no capture, or can't be written.
    """
    CaptureReader(path)  # that it is one
    try:
        with path.open("r+b", buffering=0) as file:
            order = pcapng.byte_order(file.read(12)[8:]) or "<"
            end = file.seek(0, os.SEEK_END)
            rest = memoryview(pcapng.encode(block_of(about_note(time, text)), order))
            try:
                while rest:
                    rest = rest[file.write(rest) :]
            except OSError:
                with suppress(OSError):
                    file.truncate(end)
                raise
    except OSError as error:
        raise CaptureError(str(path), reason_of(error)) from error
