"""Packets in runs, without numpy: what `capture.reader` yields one by one, several times faster.

Nearly all blocks of a recording are packets of one port that differ in time and bytes only. Of
these a loop takes time, direction and bytes; every other block goes through `Blocks.read`.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import BinaryIO, Final

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
from mikas.recording.capture.scan import RawBlock, Scanner, read_whole
from mikas.recording.exchanges.result import JUMP, LONGEST_PAUSE

WINDOW: Final = 1 << 20
_HEAD: Final = 28  # bytes of an Enhanced Packet before its data
_TAIL: Final = 16  # the flags option, the end of options, the second length
_HEADS: Final = {order: struct.Struct(order + "7I") for order in pcapng.ORDERS}
_TAILS: Final = {
    order: {
        struct.pack(order + "HHII", 2, 4, flags, 0): direction is Direction.SENT
        for direction, flags in FLAGS.items()
    }
    for order in pcapng.ORDERS
}
_MOST_PACKETS: Final = 16384  # packets


@dataclass(slots=True)
class PacketRun:
    """Packets of one port in the order of the file: times, bytes, and 1 for each sent one."""

    source: Source
    times: list[float] = field(default_factory=list)
    data: list[bytes] = field(default_factory=list)
    sent: bytearray = field(default_factory=bytearray)


def read(path: str | os.PathLike[str]) -> Iterator[PacketRun | Problem | Note]:
    """Yield packets, problems and notes in the file's order. Raise as `CaptureReader` does."""
    with opened_capture(path) as file:
        yield from stretches(walk(file))


def walk(
    file: BinaryIO,
    offset: int = 0,
    order: pcapng.Order | None = None,
    stop: int | None = None,
    blocks: Blocks | None = None,
) -> Iterator[PacketRun | Problem | Note]:
    """Yield runs, each one packet or more, problems and notes, of a part of an open file."""
    scanner, blocks = Scanner(file, stop), blocks or Blocks(corrections_in(file))
    window, begin = b"", 0
    while offset < scanner.size:
        check_cancelled()
        if order is not None and blocks.is_settled:
            if not 0 <= offset - begin < len(window) - _HEAD - _TAIL:
                file.seek(offset)
                window, begin = read_whole(file, min(WINDOW, scanner.size - offset)), offset
            run, end = _plain(window, offset - begin, order, blocks)
            if run is not None:
                yield run
                offset = begin + end
                continue
        item = scanner.item(offset, order)
        if item is None:
            return
        for each in blocks.read(item):
            yield _alone(each) if isinstance(each, Packet) else each
        offset = item.end
        if isinstance(item, RawBlock):
            order = item.order


def _plain(
    window: bytes, at: int, order: pcapng.Order, blocks: Blocks
) -> tuple[PacketRun | None, int]:
    """Return the plain packets of one port from `at` on, None if there are none, and their end."""
    head, tails = _HEADS[order].unpack_from, _TAILS[order]
    if at + _HEAD + _TAIL > len(window):
        return None, at
    port = head(window, at)[2]
    if port >= len(blocks.interfaces) or not blocks.clocks[port].is_settled:
        return None, at
    interface, source = blocks.interfaces[port]
    if interface.link_type != pcapng.LINKTYPE_USER0:
        return None, at
    run, clock = PacketRun(source), blocks.clocks[port]
    earliest, latest, per_second = clock.earliest, clock.latest, interface.ticks_per_second
    zero, correction = interface.tsoffset * per_second, blocks.correction
    add_time, add_data, add_sent = run.times.append, run.data.append, run.sent.append
    last = len(window) - _HEAD - _TAIL
    while at <= last:
        kind, total, number, high, low, captured, original = head(window, at)
        end = at + total
        is_whole = total == _HEAD + _TAIL + (captured + 3 & -4) and end <= len(window)
        if kind != pcapng.ENHANCED or number != port or captured < original or not is_whole:
            break
        is_sent = tails.get(window[end - _TAIL : end - 4])
        time = (zero + (high << 32 | low)) / per_second + correction
        if is_sent is None or window[end - 4 : end] != window[at + 4 : at + 8]:
            break
        if not earliest <= time <= latest:
            break
        add_time(time)
        add_data(window[at + _HEAD : at + _HEAD + captured])
        add_sent(is_sent)
        at = end
    return (run if run.times else None), at


def _alone(packet: Packet) -> PacketRun:
    is_sent = packet.direction is Direction.SENT
    return PacketRun(packet.source, [packet.time], [packet.data], bytearray([is_sent]))


def stretches(
    runs: Iterator[PacketRun | Problem | Note],
) -> Iterator[PacketRun | Problem | Note]:
    """Yield longer runs: they end before a problem, another port, a clock that was set back, and a
    long pause.
    """
    held: PacketRun | None = None
    for run in runs:
        if isinstance(run, Note):
            yield run
            continue
        if held is not None and (isinstance(run, Problem) or not _continues(held, run)):
            yield held
            held = None
        if isinstance(run, Problem):
            yield run
            continue
        steps = enumerate(pairwise(run.times), 1)
        edges = [at for at, (one, other) in steps if not -JUMP <= other - one <= LONGEST_PAUSE]
        for start, stop in pairwise([0, *edges, len(run.times)]):
            if start and held is not None:
                yield held
                held = None
            part = slice(start, stop)
            if held is None:
                held = PacketRun(run.source, run.times[part], run.data[part], run.sent[part])
            else:
                held.times += run.times[part]
                held.data += run.data[part]
                held.sent += run.sent[part]
    if held is not None:
        yield held


def _continues(held: PacketRun, run: PacketRun) -> bool:
    near = -JUMP <= run.times[0] - held.times[-1] <= LONGEST_PAUSE
    return near and run.source == held.source and len(held.times) < _MOST_PACKETS
