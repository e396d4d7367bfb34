"""A capture's packets as arrays: the result of `CaptureReader`, a stretch of the file at a time.

Nearly every block of a capture is an Enhanced Packet. Their type is looked for in a whole window of
the file at once; those that follow each other without a gap are a run, and a run's fields are read
as columns. A packet that has anything unusual about it (a comment, a cut, no direction), and every
block of another kind, goes through `capture.scan` and `capture.reader`, and so does damage: the
same packets come out, and the same problems in the same places.

Memory is bounded by the window.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np

from mikas.errors import CaptureError
from mikas.link.tee import Direction
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.reader import Blocks, CaptureReader, Packet, Problem, reason_of
from mikas.recording.capture.scan import RawBlock, scan
from mikas.recording.exchanges.arrays import Index
from mikas.recording.exchanges.columnar import ColumnarMatcher, ExchangeColumns
from mikas.recording.exchanges.packets import PacketColumns, Packets, Window
from mikas.recording.exchanges.reading import matched

WINDOW: Final = 1 << 20


def read(path: str | os.PathLike[str], window: int = WINDOW) -> Iterator[Packets | Problem]:
    """Yield packets and problems in the order of the file. Raise as `CaptureReader` does."""
    checked = CaptureReader(path)
    try:
        with checked.path.open("rb") as file:
            yield from _Walk(file, window).items()
    except OSError as error:
        raise CaptureError(str(Path(path)), reason_of(error)) from error


def column_exchanges(
    path: str | os.PathLike[str], window: int = WINDOW
) -> Iterator[ExchangeColumns | Problem]:
    """Yield the exchanges of a capture as arrays. Raise as `CaptureReader` does."""
    return matched(read(path, window), lambda packets: packets.source, ColumnarMatcher)


class _Walk:
    """Walks from block to block, by runs where possible."""

    def __init__(self, file: BinaryIO, window: int) -> None:
        self._file = file
        self._size = window
        self._blocks = Blocks()

    def items(self) -> Iterator[Packets | Problem]:
        offset = 0
        order: pcapng.Order | None = None
        window: Window | None = None
        while True:
            if order is not None and self._blocks.interfaces:
                if window is None or not window.covers(offset, order):
                    window = Window(self._file, offset, self._size, order)
                found, end = window.run(offset)
                if not found.size and window.may_be_cut(offset):
                    window = Window(self._file, offset, self._size, order)
                    found, end = window.run(offset)
                if found.size:
                    yield from self._run(window, found)
                    offset = end
                    continue
            item = next(scan(self._file, offset, order), None)
            if item is None:
                return
            yield from map(_alone, self._blocks.read(item))
            offset = item.end
            if isinstance(item, RawBlock):
                order = item.order

    def _run(self, window: Window, found: Index) -> Iterator[Packets | Problem]:
        columns = PacketColumns(window, found, self._blocks)
        problems: list[tuple[int, Problem]] = []
        for index in columns.unusual.tolist():
            for item in self._blocks.read(columns.block(index)):
                if isinstance(item, Packet):
                    columns.put(index, item)
                else:
                    problems.append((index, item))
        start = 0
        for index, problem in problems:
            yield from columns.packets(start, index)
            yield problem
            start = index  # a packet may follow its own problem
        yield from columns.packets(start, found.size)


def _alone(item: Packet | Problem) -> Packets | Problem:
    if isinstance(item, Problem):
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
