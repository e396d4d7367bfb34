"""A capture's packets as arrays: the result of `CaptureReader`, a window of the file at a time.

Nearly every block of a capture is an Enhanced Packet (pcapng). Consecutive ones are a run, and a
run's fields are read as columns. A packet with anything unusual (a comment, a cut, no direction), a
block of another type, and damage go through `capture.scan` and `capture.reader`: the same packets
and the same problems result. Memory is bounded by the window.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from mikas.cancellation import check_cancelled
from mikas.link.base import Direction
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.dating import corrections_in
from mikas.recording.capture.notes import Note
from mikas.recording.capture.opening import opened_capture
from mikas.recording.capture.reader import (
    FLAGS,
    Blocks,
    Packet,
    Problem,
    Source,
)
from mikas.recording.capture.scan import LARGEST, RawBlock, Scanner, read_whole
from mikas.recording.exchanges.arrays import Bytes, Floats, Index, Mask
from mikas.recording.exchanges.columns.pieces import joined
from mikas.recording.exchanges.result import JUMP, LONGEST_PAUSE

WINDOW: Final = 1 << 20
_LEAST: Final = 1 << 11  # bytes; a shorter window costs more than its packets one by one
_EXACT: Final = 1 << 53  # integers up to here are exact as 64-bit floats
_HEAD: Final = 28  # bytes of an Enhanced Packet before its data
_PLAIN: Final = _HEAD + 16  # with the flags option, the end of options and the second length
_NONE: Final = np.empty(0, np.int64)
_FLAGS_OPTION: Final = {"<": 0x0004_0002, ">": 0x0002_0004}  # code 2, length 4, as one word


@dataclass(frozen=True, slots=True)
class Packets:
    """Packets of one port in the order of the file. `offsets`: of their blocks in the file; `at`,
    `lengths`: of their bytes in `buffer`.
    """

    source: Source
    times: Floats
    sent: Mask
    offsets: Index
    buffer: Bytes
    at: Index
    lengths: Index

    def data(self, chosen: Index) -> Bytes:
        """Return the joined bytes of these packets."""
        return joined(self.buffer, self.at[chosen], self.lengths[chosen])


class Window:
    """A piece of the file, and the places that look like an Enhanced Packet."""

    def __init__(self, file: BinaryIO, offset: int, size: int, order: pcapng.Order) -> None:
        file.seek(offset)
        self.offset = offset
        self.order = order
        self.buffer: Bytes = np.frombuffer(read_whole(file, size), np.uint8)
        self.words = self.buffer[: self.buffer.size & -4].view(order + "u4")
        found = (self.words[:-1] == pcapng.ENHANCED).nonzero()[0]
        totals = self.words[found + 1].astype(np.int64)
        behind = found + totals // 4
        fits = (
            (totals >= _HEAD + 4)
            & (totals % 4 == 0)
            & (totals <= LARGEST)
            & (behind <= self.words.size)
        )
        found, totals, behind = found[fits], totals[fits], behind[fits]
        whole = self.words[behind - 1] == totals
        self.found: Index = found[whole]
        self._behind: Index = behind[whole]
        self._ends = (self._behind[:-1] != self.found[1:]).nonzero()[0] + 1

    def run(self, offset: int) -> tuple[Index, int]:
        """Return the consecutive blocks from `offset` on, and where they end in the file."""
        word, odd = divmod(offset - self.offset, 4)
        first = int(self.found.searchsorted(word))
        if odd or first == self.found.size or self.found[first] != word:
            return self.found[:0], offset
        next_end = int(self._ends.searchsorted(first, "right"))
        last = int(self._ends[next_end]) if next_end < self._ends.size else self.found.size
        return self.found[first:last], self.offset + 4 * int(self._behind[last - 1])

    def covers(self, offset: int, order: pcapng.Order) -> bool:
        """Return whether a block at `offset` lies in this window."""
        inside = self.offset <= offset < self.offset + self.buffer.size - 12
        return inside and (offset - self.offset) % 4 == 0 and order == self.order

    def may_be_cut(self, offset: int) -> bool:
        """Return whether a packet at `offset` may be whole in another window."""
        word = (offset - self.offset) // 4
        return offset > self.offset and bool(self.words[word] == pcapng.ENHANCED)


class PacketColumns:
    """The fields of a run of Enhanced Packets. `unusual`: those that need `Blocks.read`."""

    def __init__(self, window: Window, found: Index, blocks: Blocks) -> None:
        self._window = window
        self._found = found
        words = window.words
        length, interface, high, low, taken, original = (
            words[at:].take(found) for at in range(1, 7)
        )
        captured = taken.astype(np.int64)
        data_words = (captured + 3) // 4
        flags_at = found + _HEAD // 4 + data_words
        plain = length == _PLAIN + data_words * 4
        plain &= (interface < len(blocks.interfaces)) & (taken >= original)
        flags_at[~plain] = 0
        flags = words.take(flags_at + 1, mode="clip") & 3
        plain &= words.take(flags_at) == _FLAGS_OPTION[window.order]
        plain &= words.take(flags_at + 2, mode="clip") == 0
        self._sent: Mask = flags == FLAGS[Direction.SENT]
        plain &= self._sent | (flags == FLAGS[Direction.RECEIVED])
        self._at: Index = 4 * found + _HEAD
        self._lengths: Index = captured
        self._times: Floats = np.zeros(found.size)
        self._sources: list[Source] = []
        self._source: Index = np.full(found.size, -1)
        alike = bool((interface == interface[0]).all())  # nearly always, and quick to check
        for number in np.unique(interface[:1] if alike else interface).tolist():
            chosen = (plain & (interface == number)).nonzero()[0]
            if not chosen.size:
                continue
            described, source = blocks.interfaces[number]
            if described.link_type != pcapng.LINKTYPE_USER0:
                continue
            clock = blocks.clocks[number]
            times = seconds(described, high[chosen], low[chosen]) + blocks.correction
            possible = clock.is_settled & (times >= clock.earliest) & (times <= clock.latest)
            plain[chosen[~possible]] = False
            chosen = chosen[possible]
            self._times[chosen] = times[possible]
            self._source[chosen] = self._number(source)
        self.unusual: Index = (~plain).nonzero()[0]

    def _number(self, source: Source) -> int:
        if source not in self._sources:
            self._sources.append(source)
        return self._sources.index(source)

    def block(self, index: int) -> RawBlock:
        """Return one block as it is in the file."""
        window, start = self._window, 4 * int(self._found[index])
        end = start + int(window.words[start // 4 + 1])
        body = window.buffer[start + 8 : end - 4].tobytes()
        place = window.offset + start, window.offset + end
        return RawBlock(pcapng.ENHANCED, body, window.order, *place)

    def put(self, index: int, packet: Packet) -> None:
        """Set the fields of an unusual block."""
        self._times[index] = packet.time
        self._sent[index] = packet.direction is Direction.SENT
        self._lengths[index] = len(packet.data)
        self._source[index] = self._number(packet.source)

    def packets(self, start: int, stop: int) -> Iterator[Packets]:
        """Yield the packets of the blocks from `start` to before `stop`; a new piece where the port
        changes, the clock was set back, or a long pause ends.
        """
        known = (self._source[start:stop] >= 0).nonzero()[0] + start
        steps = np.diff(self._times[known])
        edges = (np.diff(self._source[known]) != 0) | (steps < -JUMP) | (steps > LONGEST_PAUSE)
        edges = edges.nonzero()[0] + 1
        for chosen in np.split(known, edges):
            if chosen.size:
                yield Packets(
                    source=self._sources[self._source[chosen[0]]],
                    times=self._times[chosen],
                    sent=self._sent[chosen],
                    offsets=self._window.offset + 4 * self._found[chosen],
                    buffer=self._window.buffer,
                    at=self._at[chosen],
                    lengths=self._lengths[chosen],
                )


def seconds(
    interface: pcapng.Interface, high: NDArray[np.uint32], low: NDArray[np.uint32]
) -> Floats:
    """Return `Interface.time` of many ticks, with the same rounding."""
    per_second = interface.ticks_per_second
    zero = interface.tsoffset * per_second
    small = bool((high < _EXACT >> 33).all()) and abs(zero) < _EXACT >> 1
    if small and per_second <= _EXACT:
        ticks = (high.astype(np.int64) << 32 | low) + zero
        return ticks / float(per_second)
    both = zip(high.tolist(), low.tolist(), strict=True)
    return np.array([interface.time(upper << 32 | lower) for upper, lower in both])


def read(path: str | os.PathLike[str], window: int = WINDOW) -> Iterator[Packets | Problem | Note]:
    """Yield packets, problems and notes in the file's order. Raise as `CaptureReader` does."""
    with opened_capture(path) as file:
        yield from _Walk(file, window).items()


class _Walk:
    """Walks from block to block, by runs where possible."""

    def __init__(self, file: BinaryIO, window: int) -> None:
        self._file = file
        self._size = window
        self._scanner = Scanner(file)
        self._blocks = Blocks(corrections_in(file))
        self._window: Window | None = None

    def items(self) -> Iterator[Packets | Problem | Note]:
        offset = 0
        order: pcapng.Order | None = None
        while offset < self._scanner.size:
            check_cancelled()
            if order is not None and self._blocks.interfaces and self._blocks.is_settled:
                window, found, end = self._run_at(offset, order)
                if window is not None and found.size:
                    yield from self._run(window, found)
                    offset = end
                    continue
            item = self._scanner.item(offset, order)
            if item is None:
                return
            yield from map(_alone, self._blocks.read(item))
            offset = item.end
            if isinstance(item, RawBlock):
                order = item.order

    def _run_at(self, offset: int, order: pcapng.Order) -> tuple[Window | None, Index, int]:
        """Return the window at `offset`, its packets from there on, and where they end."""
        window = self._window
        is_new = window is None or not window.covers(offset, order)
        if is_new:
            window = self._next_window(offset, order)
        if window is None:
            return None, _NONE, offset
        found, end = window.run(offset)
        if not is_new and not found.size and window.may_be_cut(offset):
            window = self._next_window(offset, order)
            if window is not None:
                found, end = window.run(offset)
        return window, found, end

    def _next_window(self, offset: int, order: pcapng.Order) -> Window | None:
        """Return a window from `offset` on; None so soon after the last one that it does not pay.

        Damage can call for a new window at each packet, but all of them together have no more than
        four times the bytes of the file.
        """
        size = self._size
        if self._window is not None:
            size = min(size, 4 * (offset - self._window.offset))
            if size < min(_LEAST, self._size):
                return None
        size = min(size, self._scanner.size - offset)
        self._window = Window(self._file, offset, size, order)
        return self._window

    def _run(self, window: Window, found: Index) -> Iterator[Packets | Problem]:
        columns = PacketColumns(window, found, self._blocks)
        problems: list[tuple[int, Problem]] = []
        for index in columns.unusual.tolist():
            for item in self._blocks.read(columns.block(index)):
                if isinstance(item, Packet):
                    columns.put(index, item)
                elif isinstance(item, Problem):
                    problems.append((index, item))
        start = 0
        for index, problem in problems:
            yield from columns.packets(start, index)
            yield problem
            start = index  # a packet may follow its own problem
        yield from columns.packets(start, found.size)


def _alone(item: Packet | Problem | Note) -> Packets | Problem | Note:
    if not isinstance(item, Packet):
        return item
    return Packets(
        source=item.source,
        times=np.array([item.time]),
        sent=np.array([item.direction is Direction.SENT]),
        offsets=np.array([item.offset]),
        buffer=np.frombuffer(item.data, np.uint8),
        at=np.zeros(1, np.int64),
        lengths=np.array([len(item.data)]),
    )
