"""The exchanges of a capture file: the one place that chooses between arrays and the reference."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Protocol, TypeVar

from mikas.recording.capture.reader import CaptureReader, Packet, Problem, Source
from mikas.recording.exchanges.result import JUMP, Exchanges
from mikas.recording.exchanges.scalar import ScalarMatcher

_STRETCH = 1024  # packets

P_contra = TypeVar("P_contra", contravariant=True)
E_co = TypeVar("E_co", covariant=True)
P = TypeVar("P")
E = TypeVar("E")


class Matcher(Protocol[P_contra, E_co]):
    """One port of one recording."""

    def interrupt(self) -> None:
        """Note that a part of the file is missing here."""

    def feed(self, packets: P_contra, /) -> E_co:
        """Return the exchanges that these packets complete."""


def read_exchanges(path: str | os.PathLike[str]) -> Iterator[Exchanges | Problem]:
    """Yield the exchanges of a capture, a stretch of a port at a time, and problems in between.

    Raise as `CaptureReader` does.
    """
    try:
        import numpy  # noqa: F401, ICN001  (only whether it is there)
    except ImportError:
        return scalar_exchanges(path)
    from mikas.recording.exchanges.packet_reader import column_exchanges

    return column_exchanges(path)


def scalar_exchanges(path: str | os.PathLike[str]) -> Iterator[Exchanges | Problem]:
    """Yield the exchanges without numpy."""
    return matched(_stretches(CaptureReader(path)), lambda it: it[0].source, ScalarMatcher)


def matched(
    items: Iterable[P | Problem],
    source_of: Callable[[P], Source],
    matcher: Callable[[Source], Matcher[P, E]],
) -> Iterator[E | Problem]:
    """Yield the exchanges of stretches of packets; each port of a recording has a matcher."""
    lines: dict[Source, Matcher[P, E]] = {}
    for item in items:
        if isinstance(item, Problem):
            for line in lines.values():
                line.interrupt()
            yield item
            continue
        source = source_of(item)
        if source not in lines:
            if any(line.recording != source.recording for line in lines):
                lines.clear()
            lines[source] = matcher(source)
        yield lines[source].feed(item)


def _stretches(items: Iterable[Packet | Problem]) -> Iterator[Sequence[Packet] | Problem]:
    waiting: list[Packet] = []
    for item in items:
        if waiting and (len(waiting) == _STRETCH or not _continues(waiting[-1], item)):
            yield waiting
            waiting = []
        if isinstance(item, Problem):
            yield item
        else:
            waiting.append(item)
    if waiting:
        yield waiting


def _continues(last: Packet, item: Packet | Problem) -> bool:
    if isinstance(item, Problem):
        return False
    return item.source == last.source and item.time >= last.time - JUMP
