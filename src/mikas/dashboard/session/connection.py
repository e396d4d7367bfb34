"""The connection to one unit: its one sampling thread, jobs on its line, the sampled channels.

Connecting, disconnecting and lending the port exclude each other: the second request is refused,
not queued. Jobs take their turn on the line between two sampling cycles; the event loop awaits them
and continues meanwhile.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator, Callable, Sequence
from concurrent.futures import Future
from contextlib import asynccontextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import lcm
from typing import TypeVar

from mikas.catalog import Catalog
from mikas.cleaning import public_port
from mikas.client import Ecu
from mikas.client.connecting import ConnectionOptions, EchoSetting, PauseSetting
from mikas.dashboard.errors import ADVICE, Busy, NotConnected
from mikas.dashboard.session.monitor import DISCONNECTED, ConnectionMonitor
from mikas.dashboard.session.port_threads import SamplingThread
from mikas.dashboard.settings import PlanSettings, PortSettings, Settings
from mikas.errors import UnknownParameter, UsageError, usage_error
from mikas.i18n import Text
from mikas.instruments.places import at_one_port, likely_beside
from mikas.link.identity import KnownAdapter
from mikas.link.reconnecting import ReconnectingPort
from mikas.link.urls import parse, with_name
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import LineState
from mikas.sampling.plan import Plan, Price, datum_of

T = TypeVar("T")

_FIRST_STATE = 2.0  # s that `connect` waits for the port's first state
_TURN = 30.0  # s that a job waits for its turn
_MAY_ANSWER = (None, LineState.ECU_ALIVE, LineState.SAMPLING)
"""States of the line in which a job waits for its turn; None: the port is being opened."""
RECONNECTED = Text("The connection was restarted.", "Соединение установлено заново.")
DIAGNOSIS = Text("Paused for the connection check.", "Пауза на время проверки связи.")
SURVEY = Text("Paused for the survey of the unit.", "Пауза на время обследования блока.")
OTHER_REQUEST = Text("The line was used for another request.", "Линия была занята другим запросом.")
_OTHER_PORT = Text("Another connection was chosen.", "Выбрано другое соединение.")
CHANGING = Text("the connection is being changed", "соединение как раз меняется")
SURVEYING = Text("a survey of the unit is running", "идёт обследование блока")
_LINE_BUSY = Text("the line is busy; the request was cancelled", "линия занята; запрос отменён")


async def result_in_turn(future: Future[T], seconds: float) -> T:
    """Return the result of a job that runs between two cycles. Raises what the job raises.

    Raises `Busy` if its turn does not come within `seconds`; it is then never run. A job that has
    started is waited for: it may have changed something, and its result has to be reported.
    """
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


@dataclass(eq=False)
class Connection:
    """`port` and `thread`: None while not connected; any thread may read them.

    `port` stays while the thread is replaced or the port is lent to a diagnosis. `create` returns
    the thread of a port, to be started; `on_end` is called with a thread that was ended by a
    request, and the reason.
    """

    _settings: Settings
    monitor: ConnectionMonitor
    create: Callable[[PortSettings], SamplingThread]
    on_end: Callable[[SamplingThread, Text], None]
    port: PortSettings | None = None
    thread: SamplingThread | None = field(default=None, init=False)
    taken: Callable[[], frozenset[str]] = field(default=frozenset, init=False)
    """The URLs at which instruments beside the unit are; to be set before the first request."""

    def __post_init__(self) -> None:
        self._changing = asyncio.Lock()
        self._busy_with = CHANGING
        self._first_state = asyncio.Event()
        self._loop: asyncio.AbstractEventLoop | None = None  # None: the server does not run yet

    def begin(self) -> None:
        """Connect to the port that is set at the start, if any; the server need not run yet."""
        if self.port is not None and self.thread is None:
            self._open(self.port)

    def start(self) -> None:
        """Take requests; `begin`, unless that was called."""
        self._loop = asyncio.get_running_loop()
        self.begin()

    def stop(self) -> None:
        """End the sampling thread, if the server has not; may take seconds."""
        if (thread := self.thread) is not None:
            thread.stop()

    async def connect(
        self,
        url: str | None,
        *,
        echo: EchoSetting = "auto",
        pause: PauseSetting | None = None,
        accepted: Callable[[str], None] = lambda _: None,
    ) -> None:
        """Connect to `url`, or to the one likely adapter; an existing connection ends.

        `accepted` is called with the URL once the request is known to be valid. Raises the
        request's errors; errors of the line are in the state.
        """
        async with self._alone():
            if url is None:
                url = await asyncio.to_thread(self.likely)
            parse(url)
            if any(at_one_port(url, other) for other in self.taken()):
                raise usage_error(
                    f"At {public_port(url)} is an instrument beside the unit; choose another port, "
                    "or remove the instrument first",
                    f"На порту {public_port(url)} прибор рядом с блоком; выберите другой порт или "
                    "сначала уберите прибор",
                )
            port = self.port
            again = port is not None and port.url == url
            await self.close(RECONNECTED if again else _OTHER_PORT)
            accepted(url)
            self.port = PortSettings(url, echo, pause)
            self._open(self.port)
            await self._wait_for_state()

    def settings_of(self, url: str) -> PortSettings:
        """Return how the unit at `url` is reached: as now, if that port is in use."""
        port = self.port
        return port if port is not None and port.url == url else PortSettings(url)

    async def disconnect(self) -> None:
        """Close the port."""
        async with self._alone():
            await self.close()
            self.port = None

    @asynccontextmanager
    async def lent(self, why: Text = DIAGNOSIS, busy_with: Text = CHANGING) -> AsyncIterator[None]:
        """Close the port meanwhile, and open it again.

        `why`: of the pause; `busy_with`: why other requests are refused meanwhile.
        """
        async with self._alone(busy_with):
            port, adapter = self.port, self.thread.port.adapter if self.thread else None
            await self.close(why)
            try:
                yield
            finally:
                if port is not None:
                    self._open(port, adapter)

    def moved(self, address: str) -> None:
        """Note the present name of the adapter; in the sampling thread."""
        if (port := self.port) is not None:
            self.port = replace(port, url=with_name(port.url, address))

    async def close(self, why: Text = DISCONNECTED) -> None:
        """End the sampling thread, if there is one; the connection keeps its port settings."""
        thread, self.thread = self.thread, None
        if thread is not None:
            await asyncio.to_thread(thread.stop)
            self.on_end(thread, why)

    def likely(self) -> str:
        """Return the URL of the one likely adapter. Raises as `only_likely`."""
        return likely_beside(self.taken(), self._settings.find())

    @property
    def changing(self) -> bool:
        """Whether the connection is being changed at this moment."""
        return self._changing.locked()

    def state_known(self) -> None:
        """Note that the port has its first state; from any thread."""
        if (loop := self._loop) is not None:
            loop.call_soon_threadsafe(self._first_state.set)

    async def ask(self, job: Callable[[Ecu], T], *, seconds: float = _TURN) -> T:
        """Return the result of `job(ecu)`, run between two cycles. Raises what `job` raises.

        While the port is being opened, or the unit identified, the job waits for that. Raises
        `NotConnected`, what opening raises, and `Busy` if its turn does not come in `seconds`.
        """
        thread = self.thread
        if thread is None or thread.ended or self.monitor.line not in _MAY_ANSWER:
            raise self.not_connected()

        def in_turn(ecu: Ecu) -> T:
            self.monitor.session.pause(OTHER_REQUEST)
            return job(ecu)

        return await result_in_turn(thread.acquisition.call(in_turn), seconds)

    def now(self) -> float:
        """Return the time of the links' clock."""
        thread = self.thread
        return self._settings.wall.now() if thread is None else thread.now()

    @property
    def later(self) -> float:
        """The seconds that the date is later than the links' clock: it was set since."""
        return self.monitor.session.later

    def date(self) -> float:
        """Return the date of `now`."""
        return self.now() + self.later

    @property
    def is_demo(self) -> bool:
        """Whether the car is a virtual one."""
        return (port := self.port) is not None and port.url.startswith("sim:")

    def not_connected(self) -> NotConnected:
        """Return the error for a unit that does not answer, with the reason if it is known."""
        error = self.monitor.error
        return NotConnected(advice=ADVICE.text(error)) if error else NotConnected()

    @asynccontextmanager
    async def _alone(self, busy_with: Text = CHANGING) -> AsyncIterator[None]:
        self.check_unchanged()
        async with self._changing:
            self._busy_with = busy_with
            yield

    def check_unchanged(self) -> None:
        """Raise `Busy`, with the reason, while the connection is being changed or lent."""
        if self._changing.locked():
            raise Busy(problem=self._busy_with)

    def _open(self, port: PortSettings, adapter: KnownAdapter | None = None) -> None:
        self._first_state.clear()
        thread = self.create(port)
        thread.port.adapter = adapter
        self.thread = thread
        thread.start()

    async def _wait_for_state(self) -> None:
        """Wait for the port's first state. Raises the errors of its address."""
        try:
            async with asyncio.timeout(_FIRST_STATE):
                await self._first_state.wait()
        except TimeoutError:
            return  # the state will show the result
        thread = self.thread
        if thread is not None and isinstance(thread.failure, UsageError):
            raise thread.failure


def _is_known(catalog: Catalog, name: str) -> bool:
    """Whether `name` is a channel's, or a code, which no table lists; not another name of one."""
    try:
        return catalog.channel(name).name == name
    except UnknownParameter:
        return False


def _is_of_instruments(catalog: Catalog, name: str) -> bool:
    """Whether `name` is a derived channel that needs no parameter of the unit."""
    return name in catalog.derived and not catalog.required_by([name])


class SamplingPlanner:
    """The channels to sample and their cost, with and without a connection. Any thread may call.

    `request`: all channels at first. Another selection of tiles or traces changes only which of
    them come first (`prefer`), so it leaves no hole in the values.
    """

    def __init__(self, connection: Connection, options: ConnectionOptions) -> None:
        self._connection, self._options = connection, options
        self._lock = threading.Lock()
        self.request: PlanSettings = PlanSettings(dict.fromkeys(options.catalog.channels, 1))

    def sample(self, request: PlanSettings) -> None:
        """Sample `request` from now on, or from the next connection. Raises `UnknownParameter` …"""
        with self._lock:  # two requests at once: the one that is sampled is the one that is shown
            if (thread := self._connection.thread) is not None:
                thread.acquisition.reconfigure(request.names, request.method, request.rate)
            else:
                for name in request.every:
                    self._options.catalog.channel(name)
            self.request = replace(request, first=self.request.first)
            self._connection.monitor.set_names(request.every)

    def prefer(self, names: Sequence[str]) -> None:
        """Let these channels come first, as `Acquisition.prefer`. Raises `UnknownParameter`."""
        with self._lock:
            first = tuple(dict.fromkeys(self._options.catalog.channel(name).name for name in names))
            if (thread := self._connection.thread) is not None:
                thread.acquisition.prefer(first)
            self.request = replace(self.request, first=first)

    def cycles(self, plan: Plan | None) -> dict[str, int]:
        """Return in how many cycles of `plan` each channel is read once; None: as requested.

        A derived channel has a value where all its inputs are read.
        """
        every = self.request.every
        if plan is None:
            return every
        divisors = plan.divisors
        read = {p.parameter.name: divisors[datum_of(p.parameter)] for p in plan.parameters}

        def of(name: str, requested: int) -> int:
            inputs = self._inputs.get(name, (name,))
            return lcm(*(read.get(it, requested) for it in inputs))

        return {name: of(name, requested) for name, requested in every.items()}

    @cached_property
    def _inputs(self) -> dict[str, tuple[str, ...]]:
        """The parameters of each derived channel."""
        catalog = self._options.catalog
        return {it: catalog.required_by([it]) for it in catalog.derived}

    def use_catalog(self, catalog: Catalog) -> None:
        """Sample by another catalog, on the same connection: its new derived channels too."""
        with self._lock:
            before, self._options = self._options.catalog, replace(self._options, catalog=catalog)
            for made in ("_unconnected", "_inputs"):  # with the other catalog
                self.__dict__.pop(made, None)
            every = {name: n for name, n in self.request.every.items() if _is_known(catalog, name)}
            every |= {name: 1 for name in catalog.derived if name not in before.derived}
            first = tuple(name for name in self.request.first if _is_known(catalog, name))
            if all(_is_of_instruments(catalog, name) for name in every):  # or none is left
                every = dict.fromkeys(catalog.channels, 1)
            request = replace(self.request, every=every, first=first)
            if (thread := self._connection.thread) is not None:
                thread.acquisition.reconfigure(
                    request.names, request.method, request.rate, catalog=catalog
                )
                thread.acquisition.prefer(first)
            self.request = request
            self._connection.monitor.set_names(request.every)

    def relearn(self) -> None:
        """Drop the measured speeds and limits of this unit. Raises `NotConnected`."""
        if (thread := self._connection.thread) is None:
            raise NotConnected
        thread.acquisition.relearn()

    def price(self, names: Sequence[str], method: str, first: Sequence[str] = ()) -> Price:
        """Return the cost of one cycle of `names`, by the limits known of the unit, if any."""
        thread = self._connection.thread
        acquisition = thread.acquisition if thread else self._unconnected
        return acquisition.price(names, method, first)

    @cached_property
    def _unconnected(self) -> Acquisition:
        """An acquisition that never runs: it knows the costs on a unit with default limits."""
        port = ReconnectingPort("sim:")
        return Acquisition(port, self._options.create_ecu, self._options.catalog)
