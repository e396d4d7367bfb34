"""Notes as blocks of a capture: written, read, and found in a file.

A note is a Custom Block of pcapng, of the copyable kind (0x0BAD): other tools read on behind it
(new ones list it, without a time and not as a packet), and editcap keeps it. The project has no
Private Enterprise Number of its own: it uses 32473, which RFC 5612 reserves for documentation.
Others may do so as well, hence the tag in front of the payload; behind it stands one JSON object in
ASCII, `{"kind", "time", "data"}`, filled up with zeros.

Reading looks for notes alone, so it takes a fraction of the time that all packets would take, and
damage anywhere else in the file is no hindrance. A note that can't be read is passed over; one of a
kind that is not known here is kept.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import BinaryIO, Final

from mikas.recording import pcapng
from mikas.recording.notes import Kind, Note
from mikas.recording.scan import LARGEST, RawBlock, is_headless, scan

ENTERPRISE: Final = 32473  # RFC 5612: for documentation; nobody's own
TAG: Final = b"mikas/1\n"

_WINDOW: Final = 1 << 20
_OVERLAP: Final = 64  # more than what is looked for is long
_SECTION_START: Final = b"\x0a\x0d\x0d\x0a"  # the same in both byte orders
_BEFORE_TAG: Final = 12  # bytes of a note's block
_SECTION_OR_NOTE: Final = re.compile(
    rb"\x0A\x0D\x0D\x0A.{4}(?:\x4D\x3C\x2B\x1A|\x1A\x2B\x3C\x4D)"
    rb"|(?:\xAD\x0B\0\0.{4}\xD9\x7E\0\0|\0\0\x0B\xAD.{4}\0\0\x7E\xD9)" + re.escape(TAG),
    re.DOTALL,
)


def block_of(note: Note) -> pcapng.Custom:
    """The block that holds `note`. Raises `ValueError` for what JSON can't hold, or a huge one."""
    content = {"kind": str(note.kind), "time": note.time, "data": dict(note.data)}
    data = TAG + json.dumps(content, allow_nan=False, separators=(",", ":")).encode()
    if len(data) > LARGEST // 2:
        raise ValueError("the note is too long")
    return pcapng.Custom(ENTERPRISE, data)


def read_block(block: pcapng.Custom) -> Note | None:
    """The note in `block`; None if it holds none."""
    if block.enterprise != ENTERPRISE or not block.data.startswith(TAG):
        return None
    try:
        content = json.loads(block.data[len(TAG) :].rstrip(b"\0"), parse_constant=_refuse)
        kind, time, data = content["kind"], float(content["time"]), dict(content["data"])
        if not isinstance(kind, str):
            return None
        return Note(Kind(kind) if kind in _KINDS else kind, time, data)
    except (ValueError, TypeError, KeyError, OverflowError, RecursionError):
        return None


_KINDS: Final = frozenset(Kind)


def _refuse(constant: str) -> None:
    """NaN and its like are no JSON."""
    raise ValueError(constant)


def find(file: BinaryIO) -> Iterator[Note]:
    """The notes of a capture that is open for reading and seekable, in the order of the file."""
    recording, known = 0 if is_headless(file) else -1, True
    for offset, is_section in _places(file):
        block = _block_at(file, offset)
        if isinstance(block, pcapng.Section) and is_section:
            recording += 1
            known = block.version[0] == 1
        elif isinstance(block, pcapng.Custom) and known:
            note = read_block(block)
            if note is not None:
                yield Note(note.kind, note.time, note.data, max(0, recording), offset)


def _places(file: BinaryIO) -> Iterator[tuple[int, bool]]:
    """Where sections and notes may begin, and which of the two."""
    start = 0
    while True:
        file.seek(start)
        window = file.read(_WINDOW)
        last = len(window) < _WINDOW
        stop = len(window) if last else len(window) - _OVERLAP
        # Two plain searches, twenty times as fast as the expression, which then judges.
        found = {*_all(window, _SECTION_START, 0), *_all(window, TAG, _BEFORE_TAG)}
        for at in sorted(found):
            match = _SECTION_OR_NOTE.match(window, at)
            if match and at < stop:
                yield start + at, match[0].startswith(b"\x0a\x0d")
        if last:
            return
        start += stop


def _all(window: bytes, what: bytes, behind: int) -> Iterator[int]:
    """Where blocks may begin, `what` being so far behind their beginning."""
    at = window.find(what)
    while at >= 0:
        if at >= behind:
            yield at - behind
        at = window.find(what, at + 1)


def _block_at(file: BinaryIO, offset: int) -> pcapng.Block | None:
    file.seek(offset)
    order: pcapng.Order = ">" if file.read(1) == b"\0" else "<"
    item = next(scan(file, offset, order), None)
    if not isinstance(item, RawBlock):
        return None
    try:
        return pcapng.parse(item.kind, item.body, item.order)
    except pcapng.Malformed:
        return None
