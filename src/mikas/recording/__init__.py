"""Recordings: captures of the wire, and the tables, texts and files that are made from them."""

from mikas.recording.annotations.events import note_of
from mikas.recording.capture.coalescer import Coalescer
from mikas.recording.capture.notes import Kind, Note
from mikas.recording.capture.reader import CaptureReader
from mikas.recording.capture.writer import CaptureWriter

__all__ = [
    "CaptureReader",
    "CaptureWriter",
    "Coalescer",
    "Kind",
    "Note",
    "note_of",
]
