"""The ports of a recording: each has a matcher of its own, which gets its packets by stretches."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Protocol, TypeVar

from mikas.recording.capture.notes import Note
from mikas.recording.capture.reader import Problem, Source
from mikas.recording.exchanges.matching import Matching
from mikas.recording.exchanges.result import Exchanges

if TYPE_CHECKING:
    from mikas.recording.exchanges.columns.packets import Packets
    from mikas.recording.exchanges.runs import PacketRun

P = TypeVar("P", bound="Packets | PacketRun")
P_contra = TypeVar("P_contra", contravariant=True)


class Matcher(Protocol[P_contra]):
    """One port of one recording."""

    matching: Matching

    def go_on(self, stream: bytes, /) -> None:
        """Go on with the responses to a stream whose request is missing."""

    def feed(self, packets: P_contra, /) -> Exchanges:
        """Return the exchanges that these packets complete."""


def matched(
    items: Iterable[P | Problem | Note], matcher: Callable[[Source], Matcher[P]]
) -> Iterator[Exchanges | Problem | Note]:
    """Yield the exchanges of stretches of packets; each port of a recording has a matcher."""
    ports: dict[Source, Matcher[P]] = {}
    stream: bytes | None = None  # of the next packets
    for item in items:
        if isinstance(item, Note):
            yield item
            continue
        if isinstance(item, Problem):
            for port in ports.values():
                port.matching.interrupt()
            stream = item.stream
            yield item
            continue
        source = item.source
        if source not in ports:
            if any(other.recording != source.recording for other in ports):
                ports.clear()
            ports[source] = matcher(source)
        if stream is not None:
            ports[source].go_on(stream)
            stream = None
        yield ports[source].feed(item)
