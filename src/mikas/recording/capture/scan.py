"""Scan the blocks of a pcapng file, across damage, in bounded memory.

A block is whole if its two lengths agree and it lies inside the file. Where that fails, the scan
looks for the next whole block of a known kind, at any byte, and yields the bytes between as
`Unreadable`. So a flipped bit costs one block, and of two files joined end to end the second is
read even if the first one was cut short.

A file that has lost its first bytes is read from its first whole block, as little-endian (which
this program writes) until a section has another byte order.
"""

from __future__ import annotations

import re
import struct
from typing import TYPE_CHECKING, BinaryIO, Final, NamedTuple

from mikas.cancellation import check_cancelled
from mikas.recording.capture import blocks as pcapng

if TYPE_CHECKING:
    from collections.abc import Iterator

LARGEST: Final = 1 << 24  # a longer block of a known kind counts as damage, as in other tools
_SMALLEST = 12
_TELLING: Final = 3  # consecutive blocks that no other kind of file has by accident
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
    """A whole block; `body` is empty for an unknown kind."""

    kind: int
    body: bytes
    order: pcapng.Order
    offset: int
    end: int


class Unreadable(NamedTuple):
    """Bytes that are no block. `cut`: the file ends inside a block."""

    offset: int
    end: int
    cut: bool


def scan(
    file: BinaryIO, offset: int = 0, order: pcapng.Order | None = None
) -> Iterator[RawBlock | Unreadable]:
    """Yield every block of `file`, which must be seekable, up to its present end.

    `offset`: where to begin, in a section of that byte `order`.
    """
    size = file.seek(0, 2)
    is_inside = order is not None  # else only a known kind shows that a block begins here
    order = order or _OURS
    while offset < size:
        check_cancelled()
        block = _block_at(file, offset, size, order)
        if block is None or not (is_inside or block.kind in pcapng.KNOWN):
            start = offset
            block = _next_block(file, start + 1, size, order)
            yield Unreadable(
                start,
                block.offset if block else size,
                cut=block is None and _runs_over_the_end(file, start, size, order),
            )
            if block is None:
                return
        is_inside, order, offset = True, block.order, block.end
        yield block


def is_section_start(head: bytes) -> bool:
    """Return whether `head`, a file's first bytes, can begin a pcapng file, also a cut one."""
    if len(head) < _SMALLEST:
        return _SECTION_BYTES.startswith(head[:4])
    return head.startswith(_SECTION_BYTES) and pcapng.byte_order(head[8:12]) is not None


def goes_on_as_one(file: BinaryIO, within: int = LARGEST) -> bool:
    """Return whether the file is a pcapng file without its first bytes.

    It is if, `within` so many bytes, a section begins or some blocks follow each other.
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
    """Return whether the first whole block of the file begins no section."""
    first = next((item for item in scan(file) if isinstance(item, RawBlock)), None)
    return first is not None and first.kind != pcapng.SECTION


def _head(
    file: BinaryIO, offset: int, order: pcapng.Order | None
) -> tuple[pcapng.Order, int, int] | None:
    """Return byte order, kind and length of the block at `offset`; None if there is none."""
    file.seek(offset)
    head = file.read(_SMALLEST)
    if head.startswith(_SECTION_BYTES):
        order = pcapng.byte_order(head[8:12])
    if order is None or len(head) < _SMALLEST:
        return None
    kind, total = struct.unpack_from(order + "II", head)
    return order, kind, total


def _block_at(
    file: BinaryIO, offset: int, size: int, order: pcapng.Order | None
) -> RawBlock | None:
    head = _head(file, offset, order)
    if head is None:
        return None
    order, kind, total = head
    end = offset + total
    if total < _SMALLEST or total % 4 or end > size:
        return None
    known = kind in pcapng.KNOWN
    if known and total > LARGEST:
        return None
    file.seek(end - 4)
    if file.read(4) != struct.pack(order + "I", total):
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
        check_cancelled()
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
    head = _head(file, offset, order)
    return head is not None and head[2] % 4 == 0 and offset + head[2] > size
