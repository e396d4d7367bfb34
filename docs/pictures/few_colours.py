"""A screenshot as a PNG of few colours: less than half its size, and no less legible."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

from PIL import Image

COLOURS = 128


def write(shot: bytes, out: Path) -> None:
    """Write the screenshot, a PNG, to `out`."""
    few = Image.open(BytesIO(shot)).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    few.save(out, optimize=True)
