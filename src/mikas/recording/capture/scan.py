"""Walks the blocks of a pcapng file, over damage too, in bounded memory.

A block counts as whole if its two lengths agree and it lies inside the file. Where that fails, the
walk looks for the next place where a block of a known kind is whole, at any byte, and gives what
lies between as a `Gap`. So a flipped bit costs a block, not the rest of the recording, and two
files joined end to end read on behind the seam even if the first one was cut short.

A file that has lost its first bytes is read on from its first whole block: as little-endian, which
is what is written here, until a section says something else.
"""

from __future__ import annotations

import re
import struct
from typing import TYPE_CHECKING, BinaryIO, Final, NamedTuple

from mikas.recording.capture import blocks as pcapng

if TYPE_CHECKING:
    from collections.abc import Iterator

LARGEST: Final = 1 << 24  # a longer block of a known kind is taken for damage, as other tools do
_SMALLEST = 12
_TELLING: Final = 3  # blocks one behind another that no other kind of file has by accident
_WINDOW: Final = 1 << 16
_SECTION_BYTES: Final = struct.pack("<I", pcapng.SECTION)
_STARTS: Final = {
    order: re.compile(
        b"(?=%b)" % b"|".join(re.escape(struct.pack(order + "I", kind)) for kind in pcapng.KNOWN)
    )
    for order in ("<", ">")
}


_OURS: Final[pcapng.Order] = "<"


class RawBlock(NamedTuple):
    """A whole block; `body` is empty for a kind that is not known."""

    kind: int
    body: bytes
    order: pcapng.Order
    offset: int
    end: int


class Gap(NamedTuple):
    """Bytes that are no block. `cut`: the file simply ends inside one."""

    offset: int
    end: int
    cut: bool


def scan(
    file: BinaryIO, offset: int = 0, order: pcapng.Order | None = None
) -> Iterator[RawBlock | Gap]:
    """Every block of `file`, which must be seekable, up to where it ends now.

    `offset`: where to begin, in a section of that byte `order`.
    """
    size = file.seek(0, 2)
    begun = order is not None  # else nothing but its kind shows that a block begins here
    order = order or _OURS
    while offset < size:
        block = _block_at(file, offset, size, order)
        if block is None or not (begun or block.kind in pcapng.KNOWN):
            start = offset
            block = _next_block(file, start + 1, size, order)
            yield Gap(
                start,
                block.offset if block else size,
                cut=block is None and _runs_over_the_end(file, start, size, order),
            )
            if block is None:
                return
        begun, order, offset = True, block.order, block.end
        yield block


def is_section_start(head: bytes) -> bool:
    """Whether `head`, the first bytes of a file, can begin a pcapng file, be it cut short."""
    if len(head) < _SMALLEST:
        return _SECTION_BYTES.startswith(head[:4])
    return head.startswith(_SECTION_BYTES) and pcapng.byte_order(head[8:12]) is not None


def goes_on_as_one(file: BinaryIO, within: int = LARGEST) -> bool:
    """Whether a file that does not begin as a pcapng file is one that has lost its first bytes: a
    section begins further on, or some blocks follow each other. Looks no further than `within`.
    """
    size = min(file.seek(0, 2), within)
    block = _next_block(file, 0, size, _OURS)
    while block is not None and block.kind != pcapng.SECTION:
        following: RawBlock | None = block
        for _ in range(_TELLING - 1):
            following = following and _block_at(file, following.end, size, following.order)
        if following is not None:
            return True
        block = _next_block(file, block.offset + 1, size, _OURS)
    return block is not None


def is_headless(file: BinaryIO) -> bool:
    """Whether the first whole block of the file is none that begins a section."""
    first = next((item for item in scan(file) if isinstance(item, RawBlock)), None)
    return first is not None and first.kind != pcapng.SECTION


def _block_at(
    file: BinaryIO, offset: int, size: int, order: pcapng.Order | None
) -> RawBlock | None:
    file.seek(offset)
    head = file.read(_SMALLEST)
    if head.startswith(_SECTION_BYTES):
        order = pcapng.byte_order(head[8:12])
    if order is None or len(head) < _SMALLEST:
        return None
    kind, total = struct.unpack_from(order + "II", head)
    end = offset + total
    if total < _SMALLEST or total % 4 or end > size:
        return None
    known = kind in pcapng.KNOWN
    if known and total > LARGEST:
        return None
    file.seek(end - 4)
    if file.read(4) != head[4:8]:
        return None
    if not known:
        return RawBlock(kind, b"", order, offset, end)
    file.seek(offset + 8)
    body = file.read(total - _SMALLEST)
    return RawBlock(kind, body, order, offset, end) if len(body) == total - _SMALLEST else None


def _next_block(
    file: BinaryIO, start: int, size: int, order: pcapng.Order | None
) -> RawBlock | None:
    starts = _STARTS[order or "<"]
    while size - start >= _SMALLEST:
        file.seek(start)
        window = file.read(_WINDOW)
        for match in starts.finditer(window):
            block = _block_at(file, start + match.start(), size, order)
            if block is not None:
                return block
        if len(window) < _SMALLEST:
            return None
        start += len(window) - 3
    return None


def _runs_over_the_end(file: BinaryIO, offset: int, size: int, order: pcapng.Order | None) -> bool:
    if size - offset < _SMALLEST:
        return True
    file.seek(offset)
    head = file.read(_SMALLEST)
    if head.startswith(_SECTION_BYTES):
        order = pcapng.byte_order(head[8:12])
    if order is None:
        return False
    total = int(struct.unpack_from(order + "I", head, 4)[0])
    return total % 4 == 0 and offset + total > size
