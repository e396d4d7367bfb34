"""Scan the blocks of a pcapng file, across damage, in bounded memory and linear time.

A block is whole if its two lengths agree and it lies inside the file. Where that fails, the scan
looks for the next whole block of a known kind, at any byte, and yields the bytes between as
`Unreadable`. So a flipped bit costs one block, and of two files joined end to end the second is
read even if the first one was cut short.

A file that has lost its first bytes is read from its first whole block, as little-endian (which
this program writes) until a section has another byte order.

Anybody may have made the file, so nothing in it decides how often a byte is read: a search goes on
where the last one stopped, and a place that only looks like a block costs its two lengths.
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
_OURS: Final[pcapng.Order] = "<"


_PLAIN: Final = pcapng.KNOWN - {pcapng.SECTION}  # those that do not change the byte order
_STRUCTS: Final = {
    order: (struct.Struct(order + "II"), struct.Struct(order + "I")) for order in pcapng.ORDERS
}


def _start(order: pcapng.Order) -> re.Pattern[bytes]:
    """Return what a block of a known kind begins with: its kind, and a length that may be one."""
    kinds = (struct.pack(order + "I", kind) for kind in _PLAIN)
    fours = b"[%b]" % b"".join(re.escape(bytes([byte])) for byte in range(0, 256, 4))
    lengths = {
        "<": fours + rb"..(?:\0|(?<=\0\0\0)\x01)",
        ">": rb"(?:\0|\x01(?=\0\0\0)).." + fours,
    }
    others = b"(?:%b)%b" % (b"|".join(map(re.escape, kinds)), lengths[order])
    return re.compile(b"(?=%b|%b)" % (re.escape(_SECTION_BYTES), others), re.DOTALL)


_STARTS: Final = {order: _start(order) for order in pcapng.ORDERS}


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


class Scanner:
    """The blocks of `file`, which is seekable, up to its present end, or to the offset `stop`.

    An unbuffered file is best: other ones read more than they are asked for. A window of bytes
    stays in memory from call to call, so offsets that rise cost the least.
    """

    def __init__(self, file: BinaryIO, stop: int | None = None) -> None:
        end = file.seek(0, 2)
        self.size: int = end if stop is None else min(end, stop)
        self._file = file
        self._window = b""
        self._begin = 0  # of the window in the file

    def item(self, offset: int, order: pcapng.Order | None) -> RawBlock | Unreadable | None:
        """Return the block or the bytes at `offset`; None at the end.

        `order`: that of the section. None: `offset` may lie anywhere, so only a known kind shows
        that a block begins there.
        """
        if offset >= self.size:
            return None
        self._load(offset)
        is_inside = order is not None
        order = order or _OURS
        block = self._in_window(offset, order) or self.block(offset, order)
        if block is not None and (is_inside or block.kind in pcapng.KNOWN):
            return block
        found = next(self._extents(offset + 1, order), None)
        end = self.size if found is None else found.offset
        cut = found is None and self._runs_over_the_end(offset, order)
        return Unreadable(offset, end, cut)

    def block(self, offset: int, order: pcapng.Order | None) -> RawBlock | None:
        """Return the whole block at `offset`; None if there is none."""
        found = self.extent(offset, order)
        if found is None or found.kind not in pcapng.KNOWN:
            return found
        length = found.end - offset - _SMALLEST
        body = self._bytes(offset + 8, length)  # shorter if the file has become so
        whole = len(body) == length
        return RawBlock(found.kind, body, found.order, offset, found.end) if whole else None

    def extent(self, offset: int, order: pcapng.Order | None) -> RawBlock | None:
        """Return the whole block at `offset`, its body unread."""
        head = self._head(offset, order)
        if head is None:
            return None
        order, kind, total = head
        end = offset + total
        if total < _SMALLEST or total % 4 or end > self.size:
            return None
        if total > LARGEST and kind in pcapng.KNOWN:
            return None
        if self._bytes(end - 4, 4) != struct.pack(order + "I", total):
            return None
        return RawBlock(kind, b"", order, offset, end)

    def extent_before(self, end: int, order: pcapng.Order) -> RawBlock | None:
        """Return the whole block that ends at `end`, its body unread; None if there is none."""
        if end < _SMALLEST or end > self.size:
            return None
        (total,) = struct.unpack(order + "I", self._bytes(end - 4, 4))
        found = self.extent(end - total, order) if total <= end else None
        return found if found is not None and found.end == end else None

    def head_of(self, block: RawBlock, count: int) -> bytes:
        """Return so many bytes of a block's body; less if it has less."""
        return self._bytes(block.offset + 8, min(count, block.end - block.offset - _SMALLEST))

    def _in_window(self, offset: int, order: pcapng.Order) -> RawBlock | None:
        """Return what `block` returns, in half the time, for nearly every block of a recording."""
        window, begin = self._window, offset - self._begin
        if begin + _SMALLEST > len(window):
            return None
        heads, lengths = _STRUCTS[order]
        kind, total = heads.unpack_from(window, begin)
        end = begin + total
        if kind not in _PLAIN or total < _SMALLEST or total % 4 or end > len(window):
            return None
        if lengths.unpack_from(window, end - 4)[0] != total:
            return None
        body = window[begin + 8 : end - 4]
        return RawBlock(kind, body, order, offset, offset + total)

    def goes_on_as_one(self) -> bool:
        """Return whether this is a pcapng file without its first bytes: a section begins somewhere,
        or some blocks follow each other.
        """
        for first in self._extents(0, _OURS):
            if first.kind == pcapng.SECTION:
                return True
            following: RawBlock | None = first
            for _ in range(_TELLING - 1):
                following = following and self.extent(following.end, following.order)
            if following is not None:
                return True
        return False

    def _extents(self, start: int, order: pcapng.Order) -> Iterator[RawBlock]:
        """Yield every whole block of a known kind from `start` on, unread; they may overlap."""
        starts = _STARTS[order]
        while self.size - start >= _SMALLEST:
            check_cancelled()
            self._load(start)
            if len(self._window) < _SMALLEST:  # the file has become shorter
                return
            skipped = start - self._begin
            for match in starts.finditer(self._window, skipped):
                found = self.extent(self._begin + match.start(), order)
                if found is not None:
                    yield found
            start = self._begin + len(self._window) - _SMALLEST + 1

    def _head(
        self, offset: int, order: pcapng.Order | None
    ) -> tuple[pcapng.Order, int, int] | None:
        """Return byte order, kind and length of the block at `offset`; None if there is none."""
        head = self._bytes(offset, _SMALLEST)
        if head.startswith(_SECTION_BYTES):
            order = pcapng.BYTE_ORDERS.get(head[8:12])
        if order is None or len(head) < _SMALLEST:
            return None
        kind, total = struct.unpack_from(order + "II", head)
        return order, kind, total

    def _runs_over_the_end(self, offset: int, order: pcapng.Order | None) -> bool:
        if self.size - offset < _SMALLEST:
            return True
        head = self._head(offset, order)
        return head is not None and head[2] % 4 == 0 and offset + head[2] > self.size

    def _load(self, offset: int) -> None:
        """Have at least a block's head from `offset` on in the window."""
        within = offset - self._begin
        if within < 0 or within + _SMALLEST > len(self._window):
            self._window = self._read(offset, min(_WINDOW, self.size - offset))
            self._begin = offset

    def _bytes(self, offset: int, count: int) -> bytes:
        """Return so many bytes, less at the file's end."""
        within = offset - self._begin
        if 0 <= within <= len(self._window) - count:
            return self._window[within : within + count]
        return self._read(offset, min(count, self.size - offset))

    def _read(self, offset: int, count: int) -> bytes:
        self._file.seek(offset)
        return read_whole(self._file, count)


def read_whole(file: BinaryIO, count: int) -> bytes:
    """Return `count` bytes, less only at the file's end: an unbuffered file may return less."""
    data = file.read(count)
    while 0 < len(data) < count and (more := file.read(count - len(data))):
        data += more
    return data


def scan(
    file: BinaryIO, offset: int = 0, order: pcapng.Order | None = None, stop: int | None = None
) -> Iterator[RawBlock | Unreadable]:
    """Yield every block of `file`, which must be seekable, up to its present end, or to `stop`.

    `offset`: where to begin, in a section of that byte `order`.
    """
    scanner = Scanner(file, stop)
    while (item := scanner.item(offset, order)) is not None:
        check_cancelled()
        offset = item.end
        if isinstance(item, RawBlock):
            order = item.order
        yield item


def is_section_start(head: bytes) -> bool:
    """Return whether `head`, a file's first bytes, can begin a pcapng file, also a cut one."""
    if len(head) < _SMALLEST:
        return _SECTION_BYTES.startswith(head[:4])
    return head.startswith(_SECTION_BYTES) and pcapng.BYTE_ORDERS.get(head[8:12]) is not None
