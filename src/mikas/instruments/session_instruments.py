"""The instruments of one session, each on a thread of its own.

The session's thread takes values and changes from here, which never waits; what an instrument does,
or does not, costs the unit's line nothing. Those in a virtual car have no thread: they are read in
the car's own time, which may be simulated.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Final

from mikas.catalog.instrument_channels import InstrumentChannel
from mikas.i18n import Text
from mikas.instruments.choosing import ChosenInstrument
from mikas.instruments.places import SIM
from mikas.instruments.reading import (
    InstrumentChange,
    InstrumentReader,
    InstrumentReading,
    InstrumentSink,
)
from mikas.instruments.sources import InstrumentSource, LinkSource
from mikas.link import Link, open_link
from mikas.link.ports import Port, find_ports
from mikas.link.reconnecting import ReconnectingPort

_PAUSE: Final = 0.2  # s from one look at a lost one to the next
_END: Final = 2.0  # s that the end waits for a thread


class SessionInstruments:
    """The instruments `chosen` beside the unit at `port`; `sink`: the recorder.

    `comments`: as of `InstrumentReader`. `open_port`: opens a port of theirs; `find`: the ports of
    this computer. `sources`: in place of theirs, read in the session's thread, for tests.
    `own_source`: of an instrument that has no port, or None.
    """

    def __init__(
        self,
        chosen: Iterable[ChosenInstrument],
        port: ReconnectingPort,
        sink: InstrumentSink,
        comments: tuple[str, Callable[[Text], str]],
        *,
        open_port: Callable[[str], Link] = open_link,
        find: Callable[[], list[Port]] = find_ports,
        sources: Sequence[InstrumentSource] = (),
        own_source: Callable[[ChosenInstrument], InstrumentSource | None] = lambda _: None,
    ) -> None:
        self.chosen: tuple[ChosenInstrument, ...] = tuple(chosen)
        self._port, self._own_source = port, own_source
        self._open_port, self._find = open_port, find
        self._changes: deque[InstrumentChange] = deque()
        self._ended = threading.Event()
        self._threads: list[threading.Thread] = []
        self._in_turn: list[InstrumentReader] = []  # read in the session's thread
        self._alone: list[InstrumentReader] = []
        for number, each in enumerate(self.chosen):
            is_virtual = each.url.lower() == SIM
            source = sources[number] if sources else self._source(each, is_virtual=is_virtual)
            reader = InstrumentReader(
                number,
                each,
                source,
                sink,
                clock=port.now,
                report=self._changes.append,
                comments=comments,
            )
            (self._in_turn if is_virtual or sources else self._alone).append(reader)
        self.readers: tuple[InstrumentReader, ...] = (*self._in_turn, *self._alone)
        """The readers, for their states."""

    def _source(self, chosen: ChosenInstrument, *, is_virtual: bool) -> InstrumentSource:
        if (own := self._own_source(chosen)) is not None:
            return own
        if not is_virtual:
            return LinkSource(chosen, self._port.now, self._open_port, self._find)
        from mikas.instruments.virtual_source import VirtualSource  # the engine: for this only

        return VirtualSource(chosen, self._port)

    @property
    def channels(self) -> tuple[InstrumentChannel, ...]:
        """The channels of all, in the order of the instruments."""
        return tuple(channel for each in self.chosen for channel in each.channels)

    def follow(self) -> list[InstrumentChange]:
        """Return the changes since the last call; the first one begins to read."""
        if len(self._threads) < len(self._alone) and not self._ended.is_set():
            for reader in self._alone:
                thread = threading.Thread(
                    target=self._run, args=(reader,), name="mikas-instrument", daemon=True
                )
                self._threads.append(thread)
                thread.start()
        for reader in self._in_turn:
            reader.poll()
        found = []
        while self._changes:
            found.append(self._changes.popleft())
        return found

    def fresh(self, time: float) -> Mapping[str, InstrumentReading]:
        """Return the values that are not too old at `time`, by channel."""
        found: dict[str, InstrumentReading] = {}
        for reader in self.readers:
            found |= reader.fresh(time)
        return found

    def close(self) -> None:
        """End the threads and close the ports; a second call does nothing."""
        self._ended.set()
        for reader in self.readers:
            reader.close()
        for thread in self._threads:
            thread.join(_END)

    def _run(self, reader: InstrumentReader) -> None:
        while not self._ended.is_set():
            if not reader.poll():
                self._ended.wait(_PAUSE)
