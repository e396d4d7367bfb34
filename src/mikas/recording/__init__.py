"""Keeping what was seen: captures of the wire, and what is made from them."""

from mikas.recording.capture import CaptureReader, CaptureWriter
from mikas.recording.coalescing import Coalescer
from mikas.recording.notes import Kind, Note, write_session_header

__all__ = [
    "CaptureReader",
    "CaptureWriter",
    "Coalescer",
    "Kind",
    "Note",
    "write_session_header",
]
