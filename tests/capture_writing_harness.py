"""Files with several recordings or with joined packets, for the tests of reading them."""

from __future__ import annotations

from contextlib import contextmanager

from mikas.recording.capture.coalescer import Coalescer
from mikas.recording.capture.writer import CaptureWriter


@contextmanager
def appending(path, **settings):
    """A writer, whose recording follows those in the file at its end."""
    piece = path.with_name(f"{path.name}.next")
    try:
        with CaptureWriter(piece, **settings) as writer:
            yield writer
    finally:
        with path.open("ab") as file:
            file.write(piece.read_bytes())
        piece.unlink()


@contextmanager
def coalescing(sink, **settings):
    """A `Coalescer` of which nothing waits at the end."""
    coalescer = Coalescer(sink, **settings)
    yield coalescer
    coalescer.flush()
