"""Search a capture for what shows whether another tool has changed it: sections, ports and notes.

One pass over the file, a fraction of the time of its packets, which it does not read. A block may
lie anywhere, also after damage, but not inside another one that was found: each byte is read twice
at most.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import suppress
from typing import BinaryIO, Final

from mikas.cancellation import check_cancelled
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.notes import TAG, Note, find_all, read_block
from mikas.recording.capture.scan import RawBlock, Scanner, read_whole

_WINDOW: Final = 1 << 16
_OVERLAP: Final = 64

# What the blocks have, and how many bytes of the block are before it: an interface's link type,
# with the zeros behind it, in either order of bytes.
_MARKS: Final = (
    (struct.pack("<I", pcapng.SECTION), (0,)),
    (struct.pack("<H", pcapng.LINKTYPE_USER0) + b"\0", (8, 9)),
    (TAG, (12,)),
)
_KINDS: Final = frozenset([pcapng.SECTION, pcapng.INTERFACE, pcapng.CUSTOM])


Marked = pcapng.Section | pcapng.Interface | Note


def marked(file: BinaryIO) -> Iterator[tuple[RawBlock, Marked]]:
    """Yield the sections, the ports and the notes of a seekable file, with their blocks."""
    scanner, end = Scanner(file), 0
    for offset in _places(file, scanner.size):
        if offset < end:
            continue
        extent = scanner.extent(offset, "<") or scanner.extent(offset, ">")
        if extent is None or extent.kind not in _KINDS:
            continue
        end = extent.end
        if (raw := scanner.block(offset, extent.order)) is None:  # the file has become shorter
            continue
        with suppress(pcapng.Malformed):
            match pcapng.parse(raw.kind, raw.body, raw.order):
                case pcapng.Section() | pcapng.Interface() as found:
                    yield raw, found
                case pcapng.Custom() as block if note := read_block(block):
                    yield raw, note


def _places(file: BinaryIO, size: int) -> Iterator[int]:
    for start in range(0, size, _WINDOW):
        check_cancelled()
        file.seek(start)
        window = read_whole(file, _WINDOW + _OVERLAP)
        found = {
            at - before for mark, distances in _MARKS
            for at in find_all(window, mark, 0) for before in distances
        }  # fmt: skip
        yield from sorted(start + at for at in found if 0 <= at < _WINDOW)
