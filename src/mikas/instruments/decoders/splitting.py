"""Bytes into lines, in bounded memory. A carriage return and a line feed each end a line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final, NamedTuple

_END: Final = re.compile(rb"[\r\n]")


class SplitLine(NamedTuple):
    """A line without its end, or the begin of one that is too long. `end`: bytes with its end."""

    data: bytes
    end: int
    is_whole: bool


class LineSplitter:
    """Yields the lines that bytes complete; empty ones are left out.

    `longest`: bytes of a line. `skips_first`: nothing else shows that a line lacks its begin, so
    the first one after the begin and after each `drop` is left out: it may be the rest of another.
    """

    def __init__(self, longest: int, *, skips_first: bool = False) -> None:
        self._longest = longest
        self._skips_first = skips_first
        self._line = bytearray()
        self._skipping = skips_first
        self._count = 0

    def drop(self) -> None:
        """Forget the unfinished line."""
        self._skipping = self._skips_first
        self._line.clear()

    def feed(self, data: bytes) -> Iterator[SplitLine]:
        """Take the next bytes; to be exhausted."""
        begin, start = self._count, 0
        self._count += len(data)
        for match in _END.finditer(data):
            yield from self._piece(data[start : match.start()], begin + start, ended=True)
            start = match.end()
        yield from self._piece(data[start:], begin + start, ended=False)

    def _piece(self, piece: bytes, begin: int, *, ended: bool) -> Iterator[SplitLine]:
        end = begin + len(piece) + ended
        if self._skipping:
            self._skipping = not ended
            return
        room = self._longest - len(self._line)
        if len(piece) > room:
            data = bytes(self._line + piece[:room])
            self._line.clear()
            self._skipping = not ended
            yield SplitLine(data, begin + room + 1, is_whole=False)
            return
        self._line += piece
        if ended and self._line:
            data = bytes(self._line)
            self._line.clear()
            yield SplitLine(data, end, is_whole=True)
