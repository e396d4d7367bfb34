"""The connection to one unit, as dumps, plan, recorder and changes use it: port, ask, now, ecu.

Jobs take their turn on the line between two sampling cycles; the event loop awaits them and goes on
meanwhile.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Protocol, TypeVar

from mikas.client import Ecu
from mikas.dashboard.errors import Busy, NotConnected
from mikas.dashboard.session.monitor import ConnectionMonitor
from mikas.dashboard.session.sampling_thread import SamplingThread
from mikas.dashboard.settings import PortSettings
from mikas.i18n import Text
from mikas.sampling.events import LineState

T = TypeVar("T")

_TURN = 30.0  # s that a job waits for its turn
_ALIVE = (LineState.ECU_ALIVE, LineState.SAMPLING)
_LINE_BUSY = Text("the line is busy; the request was cancelled", "линия занята; запрос отменён")


class TakesJobs(Protocol):
    """Runs jobs between two cycles."""

    def call(self, job: Callable[[Ecu], T]) -> Future[T]:
        """Queue `job`."""
        ...


async def run_in_turn(thread: TakesJobs, job: Callable[[Ecu], T], seconds: float) -> T:
    """Return the result of `job`, run between two cycles of `thread`. Raises what `job` raises.

    Raises `Busy` if its turn does not come within `seconds`; it is then never run. A job that has
    started is waited for: it may have changed something, and its result has to be reported.
    """
    future = thread.call(job)
    wrapped = asyncio.wrap_future(future)
    try:
        done, _ = await asyncio.wait({wrapped}, timeout=seconds)
        if not done:
            if future.cancel():
                raise Busy(problem=_LINE_BUSY)
            await asyncio.wait({wrapped})
    finally:
        if not wrapped.done():
            future.cancel()
    return wrapped.result()


class Connection:
    """`port` and `thread` are set by the `ConnectionManager`; None: not connected.

    `port` stays while the thread is replaced or the port is lent to a diagnosis.
    """

    def __init__(self, monitor: ConnectionMonitor, port: PortSettings | None = None) -> None:
        self.port = port
        self.thread: SamplingThread | None = None
        self._monitor = monitor

    async def ask(self, job: Callable[[Ecu], T], *, seconds: float = _TURN) -> T:
        """Return the result of `job(ecu)`, run between two cycles. Raises what `job` raises.

        Raises `NotConnected`, and `Busy` if its turn does not come within `seconds`.
        """
        thread = self.thread
        if thread is None or self._monitor.line not in _ALIVE:
            raise self.not_connected()

        def in_turn(ecu: Ecu) -> T:
            self._monitor.busy()
            return job(ecu)

        return await run_in_turn(thread, in_turn, seconds)

    def now(self) -> float:
        """Return the time of the link's clock; without a link, the computer's."""
        thread = self.thread
        return time.time() if thread is None else thread.now()

    @property
    def ecu(self) -> Ecu | None:
        """The unit, for reading its attributes only."""
        return thread.ecu if (thread := self.thread) else None

    @property
    def is_demo(self) -> bool:
        """Whether the car is a virtual one."""
        return (port := self.port) is not None and port.url.startswith("sim:")

    def not_connected(self) -> NotConnected:
        """Return the error for a unit that does not answer, with the reason if it is known."""
        reason = self._monitor.reason
        return NotConnected(advice=reason) if reason else NotConnected()
