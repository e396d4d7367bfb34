"""The exchanges of a capture frame by frame: what the columns and the turns have to come to."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from mikas.catalog import shipped
from mikas.recording.capture.reader import CaptureReader, Packet, Problem, Source
from mikas.recording.exchanges.fitting import Fitting
from mikas.recording.exchanges.result import JUMP, LONGEST_PAUSE, Exchanges
from mikas.recording.exchanges.scalar import PortDecoder
from mikas.recording.exchanges.turns import FoundExchanges

MOST_PACKETS = 1024
FITTING = Fitting(shipped().size_of)


class ScalarMatcher:
    """The exchanges of one port of one recording."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._port = PortDecoder(source, FITTING)
        self.matching = self._port.matching
        self._last: float | None = None

    def feed(self, packets: Sequence[Packet]) -> Exchanges:
        found = FoundExchanges(self.matching)
        for packet in packets:
            for item in self._port.feed(packet):
                found.add_item(item)
        times = [packet.time for packet in packets]
        exchanges = found.exchanges(self._source, times, self._last)
        self._last = times[-1]
        return exchanges


def scalar_exchanges(path) -> Iterator[Exchanges | Problem]:
    """The exchanges, and the problems between them; without notes."""
    ports: dict[Source, ScalarMatcher] = {}
    stream = None
    for item in stretches(CaptureReader(path)):
        if isinstance(item, Problem):
            for port in ports.values():
                port.matching.interrupt()
            stream = item.stream
            yield item
            continue
        source = item[0].source
        if any(other.recording != source.recording for other in ports):
            ports.clear()
        port = ports.setdefault(source, ScalarMatcher(source))
        if stream is not None:
            port.matching.interrupt(stream)
            stream = None
        yield port.feed(item)


def stretches(items: Iterable[Packet | Problem]) -> Iterator[Sequence[Packet] | Problem]:
    waiting: list[Packet] = []
    for item in items:
        if waiting and (len(waiting) == MOST_PACKETS or not continues(waiting[-1], item)):
            yield waiting
            waiting = []
        if isinstance(item, Problem):
            yield item
        else:
            waiting.append(item)
    if waiting:
        yield waiting


def continues(last: Packet, item: Packet | Problem) -> bool:
    if isinstance(item, Problem):
        return False
    return item.source == last.source and -JUMP <= item.time - last.time <= LONGEST_PAUSE
