"""Keeping what was seen: captures of the wire, and what is made from them."""

from mikas.recording.capture import CaptureReader, CaptureWriter

__all__ = ["CaptureReader", "CaptureWriter"]
