"""Search a capture for what shows whether another tool has changed it: sections, ports and notes.

One pass over the file, a fraction of the time of its packets, which it does not read. A block may
lie anywhere, also after damage, but not inside another one that was found: each byte is read twice
at most. Changes for reading are made in a copy.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from contextlib import suppress
from typing import BinaryIO, Final, NamedTuple

from mikas.cancellation import check_cancelled
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.notes import TAG, Note, find_all, read_block
from mikas.recording.capture.scan import RawBlock, Scanner, read_whole
from mikas.recording.capture.temporary import temporary_capture

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
_MOST_INTERFACES: Final = 16  # a port has one, and one for each time below zero


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


class PacketTimes:
    """The times of a section's packets, without their data."""

    def __init__(self, scanner: Scanner) -> None:
        self._scanner = scanner
        self._interfaces: list[pcapng.Interface] = []

    def begin(self, section: RawBlock) -> None:
        """Take the next section. Interfaces that do not follow its head at once are not known."""
        self._interfaces = []
        offset = section.end
        while len(self._interfaces) < _MOST_INTERFACES:
            raw = self._scanner.block(offset, section.order)
            if raw is None or raw.kind != pcapng.INTERFACE:
                return
            offset = raw.end
            try:
                block = pcapng.parse(raw.kind, raw.body, raw.order)
            except pcapng.Malformed:
                return
            assert isinstance(block, pcapng.Interface)
            self._interfaces.append(block)

    def is_of_unit(self, packet: pcapng.EnhancedPacket) -> bool:
        """Return whether a packet is the unit's, and not an instrument's beside it."""
        if packet.interface >= len(self._interfaces):
            return True
        return self._interfaces[packet.interface].link_type == pcapng.LINKTYPE_USER0

    def of(self, packet: RawBlock | None) -> float | None:
        """Return a packet's time; None for another block, or an unknown interface."""
        if packet is None or packet.kind != pcapng.ENHANCED:
            return None
        head = self._scanner.head_of(packet, 12)
        if len(head) < 12:
            return None
        interface, high, low = struct.unpack(packet.order + "3I", head)
        if interface >= len(self._interfaces):
            return None
        time: float = self._interfaces[interface].time(high << 32 | low)
        return time


class Edit(NamedTuple):
    """`blocks` instead of the bytes of a file from `begin` to `end`."""

    begin: int
    end: int
    blocks: bytes


def changed(file: BinaryIO, changes: Iterable[Edit]) -> BinaryIO:
    """Return a capture with these changes, which rise: a temporary file, gone when it is closed."""

    def write(out: BinaryIO) -> None:
        end = 0
        for change in changes:
            _copy(file, end, change.begin, out)
            out.write(change.blocks)
            end = change.end
        _copy(file, end, file.seek(0, 2), out)

    return temporary_capture(write)


def _copy(file: BinaryIO, begin: int, end: int, out: BinaryIO) -> None:
    file.seek(begin)
    out.writelines(read_whole(file, min(_WINDOW, end - at)) for at in range(begin, end, _WINDOW))
