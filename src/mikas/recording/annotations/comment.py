"""A person's comment on a whole recording, kept in its file: the last one counts.

A comment is a note of its own kind at the end of the file. Nothing that was recorded is changed,
and a copy of the file has the comment, too.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Final

from mikas.errors import CaptureError, reason_of
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.notes import Note, block_of
from mikas.recording.capture.reader import CaptureReader

KIND: Final = "about"
LONGEST: Final = 10_000


def comment_note(time: float, text: str) -> Note:
    """Return the note of a comment that replaces the one before."""
    return Note(KIND, time, {"text": text[:LONGEST]})


def comment_of(notes: Iterable[Note]) -> str:
    """Return the last comment; empty if there is none."""
    comment = ""
    for note in notes:
        if note.kind == KIND and isinstance(note.data.get("text"), str):
            comment = note.data["text"]
    return comment


def write_comment(path: Path, text: str, time: float) -> None:
    """Add a comment to a recording that is not being written; whole, or not at all.

    Raises `CaptureError` if it is no capture, or can't be written.
    """
    CaptureReader(path)  # raises, if it is no capture
    try:
        with path.open("r+b", buffering=0) as file:
            order = pcapng.byte_order(file.read(12)[8:]) or "<"
            end = file.seek(0, os.SEEK_END)
            rest = memoryview(pcapng.encode(block_of(comment_note(time, text)), order))
            try:
                while rest:
                    rest = rest[file.write(rest) :]
            except OSError:
                with suppress(OSError):
                    file.truncate(end)
                raise
    except OSError as error:
        raise CaptureError(str(path), reason_of(error)) from error
