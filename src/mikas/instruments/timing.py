"""When a message was sent: the moment at which its last byte arrived, within a chunk."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from mikas.instruments.events import InstrumentDecoder, InstrumentEvent

_MOST_BYTES: Final = 512  # behind an event in its chunk that count; a network's chunk has more


class TimedInstrumentDecoder:
    """A decoder, with the time of each event. `byte_time`: seconds of a byte on the wire."""

    def __init__(self, decoder: InstrumentDecoder, byte_time: float) -> None:
        self._decoder, self._byte_time = decoder, byte_time
        self._count = 0

    def drop(self) -> None:
        """Forget an unfinished message: the connection began again."""
        self._decoder.drop()

    def feed(self, data: bytes, time: float) -> Iterator[tuple[InstrumentEvent, float]]:
        """Yield the events that `data` completes; its last byte came at `time`. To be exhausted."""
        self._count += len(data)
        for event in self._decoder.feed(data):
            behind = max(0, min(self._count - event.end, _MOST_BYTES))
            yield event, time - behind * self._byte_time
