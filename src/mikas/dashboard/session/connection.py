"""The connection to one unit: jobs on its line, and the channels that are sampled.

Jobs take their turn on the line between two sampling cycles; the event loop awaits them and
continues meanwhile.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TypeVar

from mikas.client import Ecu
from mikas.client.connecting import ConnectionOptions
from mikas.dashboard.errors import Busy, NotConnected
from mikas.dashboard.session.monitor import ConnectionMonitor
from mikas.dashboard.session.port_threads import SamplingThread
from mikas.dashboard.settings import PlanSettings, PortSettings
from mikas.i18n import Text
from mikas.link.reconnecting import ReconnectingPort
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import LineState
from mikas.sampling.plan import Price

T = TypeVar("T")

_TURN = 30.0  # s that a job waits for its turn
_ALIVE = (LineState.ECU_ALIVE, LineState.SAMPLING)
_LINE_BUSY = Text("the line is busy; the request was cancelled", "линия занята; запрос отменён")


async def run_in_turn(thread: SamplingThread, job: Callable[[Ecu], T], seconds: float) -> T:
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


class SamplingPlanner:
    """The channels to sample and their cost, with and without a connection. Any thread may call.

    `request`: all channels at first.
    """

    def __init__(
        self, connection: Connection, monitor: ConnectionMonitor, options: ConnectionOptions
    ) -> None:
        self._connection, self._monitor, self._options = connection, monitor, options
        self._catalog = options.catalog
        self._lock = threading.Lock()
        self.request = PlanSettings(dict.fromkeys(self.channels, 1))

    @property
    def channels(self) -> list[str]:
        """The names of all channels of the catalog."""
        parameters = (parameter.name for parameter in self._catalog.parameters)
        return [*parameters, *self._catalog.derived]

    def sample(self, request: PlanSettings) -> None:
        """Sample `request` from now on, or from the next connection. Raises `UnknownParameter` …"""
        with self._lock:  # two requests at once: the one that is sampled is the one that is shown
            if (thread := self._connection.thread) is not None:
                thread.acquisition.reconfigure(
                    request.names, request.method or "auto", request.rate
                )
            else:
                for name in request.every:
                    self._catalog.channel(name)
            self.request = request
            self._monitor.set_names(request.every)

    def relearn(self) -> None:
        """Drop the measured speeds and limits of this unit. Raises `NotConnected`."""
        if (thread := self._connection.thread) is None:
            raise NotConnected
        thread.acquisition.relearn()

    def price(self, names: Sequence[str], method: str) -> Price:
        """Return the cost of one cycle of `names`, by the limits known of the unit, if any."""
        thread = self._connection.thread
        acquisition = thread.acquisition if thread else self._unconnected
        return acquisition.price(names, method)

    @cached_property
    def _unconnected(self) -> Acquisition:
        """An acquisition that never runs: it knows the costs on a unit with default limits."""
        port = ReconnectingPort("sim:")
        return Acquisition(port, self._options.create_ecu, self._catalog)
