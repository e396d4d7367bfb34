"""Keeping what was seen: captures of the wire, and what is made from them."""

from mikas.recording.annotations.events import note_of, write_session_header
from mikas.recording.capture import CaptureReader, CaptureWriter
from mikas.recording.coalescing import Coalescer
from mikas.recording.notes import Kind, Note

__all__ = [
    "CaptureReader",
    "CaptureWriter",
    "Coalescer",
    "Kind",
    "Note",
    "note_of",
    "write_session_header",
]
