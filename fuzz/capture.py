"""Reading a damaged capture: a `CaptureError` for a file of another kind, else no error.

Input: the file. The scan must tile it, packets and problems must lie in it in order, and notes be
found with an offset of their own.
"""

from __future__ import annotations

from contextlib import suppress
from io import BytesIO
from itertools import pairwise
from math import isfinite
from pathlib import Path
from tempfile import mkdtemp
from typing import Final

from mikas.errors import CaptureError
from mikas.recording.capture.reader import CaptureReader, Packet
from mikas.recording.capture.scan import scan

WORDS: Final = (
    *("\x0a\x0d\x0d\x0a", "\x4d\x3c\x2b\x1a", "\x1a\x2b\x3c\x4d", "\xad\x0b\0\0", "\0\0\x0b\xad"),
    *("\xd9\x7e\0\0mikas/1\n", "\0\0\x7e\xd9mikas/1\n", "\x01\0\0\0", "\x06\0\0\0", "\x03\0\0\0"),
)
_PATH: Final = Path(mkdtemp(prefix="mikas-fuzz-")) / "it.pcapng"


def check(data: bytes) -> None:
    position = 0
    for item in scan(BytesIO(data)):
        assert item.offset == position < item.end
        position = item.end
    assert position == len(data)
    _PATH.write_bytes(data)
    with suppress(CaptureError):
        _read(CaptureReader(_PATH), len(data))


def _read(reader: CaptureReader, size: int) -> None:
    items = list(reader)
    assert all(before.offset <= after.offset for before, after in pairwise(items))
    for item in items:
        assert 0 <= item.offset < size
        if isinstance(item, Packet):
            assert isfinite(item.time)
            assert len(item.data) <= size
            assert item.source.byte_time > 0
        else:
            assert item.text.en
    notes = list(reader.notes())
    assert all(before.offset < after.offset < size for before, after in pairwise(notes))
