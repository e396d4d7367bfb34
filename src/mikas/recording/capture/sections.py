"""Single sections of an open capture: ports, spans and packets, without reading the others."""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from typing import BinaryIO, Final

from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.dating import dated_index
from mikas.recording.capture.notes import FileIndex
from mikas.recording.capture.reader import Blocks, Packet
from mikas.recording.capture.scan import scan

_TAIL: Final = 1 << 14
_WIDEN: Final = 8


class Sections:
    """The sections of a file, with its index; `edges` are their begins and the file's end.

    Nothing of a section is looked for beyond its end, so all of them cost no more than the file.
    """

    def __init__(self, file: BinaryIO) -> None:
        self.file = file
        self.index: FileIndex = dated_index(file)
        self.edges: list[int] = [*self.index.sections, self.index.size]
        self._heads: dict[int, tuple[Blocks, Packet | None]] = {}  # of the latest section

    def head(self, section: int) -> tuple[Blocks, Packet | None]:
        """Return a section's ports and its first packet."""
        if section not in self._heads:
            blocks = Blocks({0: self.index.corrections.get(section, 0.0)})
            packets = self._packets(blocks, section, self.edges[section], None)
            first = next(packets, None)
            next(packets, None)  # the second one settles the clock
            self._heads = {section: (blocks, first)}
        return self._heads[section]

    def span(self, section: int) -> tuple[float, float] | None:
        """Return the times of a section's first and last packet; None without one."""
        stop = self.edges[section + 1]
        _, first = self.head(section)
        if first is None:
            return None
        tail, begin, size = [first.time], stop, _TAIL
        while len(tail) == 1 and begin > first.offset:
            begin = max(first.offset, stop - size)
            tail += (packet.time for packet in self.packets(section, begin, stop - begin))
            size *= _WIDEN  # a long comment may follow the last packet
        return first.time, max(tail)

    def packets(self, section: int, begin: int, length: int) -> Iterator[Packet]:
        """Yield a section's packets in `length` bytes from the offset `begin`."""
        order = self.index.orders[section]
        return self._packets(copy(self.head(section)[0]), section, begin, order, length)

    def _packets(
        self,
        blocks: Blocks,
        section: int,
        begin: int,
        order: pcapng.Order | None,
        length: int | None = None,
    ) -> Iterator[Packet]:
        edge = self.edges[section + 1]
        stop = edge if length is None else min(edge, begin + length)
        for item in scan(self.file, begin, order, stop):
            yield from (each for each in blocks.read(item) if isinstance(each, Packet))
