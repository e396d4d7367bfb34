"""Reading the stored faults: after connecting, when MINERR changes, at both ends of a recording.

All of it is done by jobs between two cycles, one attempt each; a unit that is silent or refuses
delays nothing for longer than that.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Final

from mikas.catalog import Catalog
from mikas.client import Ecu
from mikas.dashboard.session.connection import Connection
from mikas.dashboard.session.history import FaultHistory
from mikas.dashboard.session.monitor import ConnectionMonitor
from mikas.dashboard.session.port_threads import SamplingThread
from mikas.sampling.events import Event, FaultReading, LineState
from mikas.sampling.fault_watch import FaultWatch

_LAST: Final = 1.0  # s that the end of a recording waits for its last reading


class FaultReader:
    """Reads into `history`, as `FaultWatch` says and at the begin and the end of a recording."""

    def __init__(
        self,
        connection: Connection,
        monitor: ConnectionMonitor,
        history: FaultHistory,
        catalog: Callable[[], Catalog],
    ) -> None:
        self._connection, self._monitor = connection, monitor
        self.history, self._catalog = history, catalog
        self._watch = FaultWatch()

    def follow(self, event: Event, thread: SamplingThread) -> None:
        """Follow an event; in the sampling thread."""
        if self._watch.is_due(event):
            thread.call(self._read)

    def know(self, reading: FaultReading) -> None:
        """Take a reading, made by whatever; in the sampling thread."""
        self._watch.know(reading)

    def read_first(self, thread: SamplingThread) -> None:
        """Read the faults soon, as a recording has started."""
        if not self._watch.refused:
            thread.call(lambda ecu: self._read(ecu, routine=False))

    async def read_last(self) -> None:
        """Read before a recording ends, or give up within a second. Never raises."""
        thread = self._connection.thread
        if thread is None or self._watch.refused or self._monitor.line is not LineState.SAMPLING:
            return
        future = thread.call(lambda ecu: self._read(ecu, routine=False))
        waiting = asyncio.wrap_future(future)
        waiting.add_done_callback(lambda it: it.cancelled() or it.exception())
        await asyncio.wait({waiting}, timeout=_LAST)
        future.cancel()

    def _read(self, ecu: Ecu, *, routine: bool = True) -> None:
        reading = self._watch.read(ecu, routine=routine)
        if reading is not None:
            catalog = self._catalog()
            faults = [catalog.fault(code) for code in reading.codes]
            self.history.add(faults, reading.time, routine=routine)
