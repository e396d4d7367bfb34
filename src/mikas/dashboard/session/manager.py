"""Connecting, disconnecting and lending the port: one sampling thread at a time.

These exclude each other: the second request is refused, not queued. The events of a thread go to
the composing `Dashboard`.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

from mikas.dashboard.errors import Busy
from mikas.dashboard.session.connection import Connection
from mikas.dashboard.session.monitor import DIAGNOSIS, DISCONNECTED, OTHER_PORT, RECONNECTED
from mikas.dashboard.session.port_threads import SamplingThread
from mikas.dashboard.settings import PortSettings, Settings
from mikas.errors import NoPortGiven, UsageError
from mikas.i18n import Text
from mikas.link.ports import listed
from mikas.link.urls import parse

_FIRST_STATE = 2.0  # s that `connect` waits for the port's first state
CHANGING = Text("the connection is being changed", "соединение как раз меняется")


class ConnectionManager:
    """Sets the port and the thread of `connection`.

    `create` returns the thread of a port, to be started; `on_end` is called with a thread that was
    ended by a request, and the reason.
    """

    def __init__(
        self,
        settings: Settings,
        connection: Connection,
        *,
        create: Callable[[PortSettings], SamplingThread],
        on_end: Callable[[SamplingThread, Text], None],
    ) -> None:
        self._settings, self._connection = settings, connection
        self._create, self._on_end = create, on_end
        self._changing = asyncio.Lock()
        self._first_state = asyncio.Event()

    def start(self) -> None:
        """Connect to the port that the connection has at the start, if any."""
        self._loop = asyncio.get_running_loop()
        if self._connection.port is not None:
            self._open(self._connection.port)

    async def connect(
        self,
        url: str | None,
        *,
        echo: str = "auto",
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
            port = self._connection.port
            again = port is not None and port.url == url
            await self.close(RECONNECTED if again else OTHER_PORT)
            accepted(url)
            self._connection.port = PortSettings(url, echo)
            self._open(self._connection.port)
            await self._wait_for_state()

    async def disconnect(self) -> None:
        """Close the port."""
        async with self._alone():
            await self.close()
            self._connection.port = None

    @asynccontextmanager
    async def lent(self) -> AsyncIterator[None]:
        """Close the port meanwhile, and open it again."""
        async with self._alone():
            port = self._connection.port
            await self.close(DIAGNOSIS)
            try:
                yield
            finally:
                if port is not None:
                    self._open(port)

    async def close(self, why: Text = DISCONNECTED) -> None:
        """End the sampling thread, if there is one; the connection keeps its port settings."""
        thread, self._connection.thread = self._connection.thread, None
        if thread is not None:
            await asyncio.to_thread(thread.stop)
            self._on_end(thread, why)

    def likely(self) -> str:
        """Return the URL of the one likely adapter. Raises `NoPortGiven`."""
        ports = self._settings.find()
        likely = [port.url for port in ports if port.likely]
        if len(likely) != 1:
            raise NoPortGiven(found=listed(ports))
        return likely[0]

    @property
    def changing(self) -> bool:
        """Whether the connection is being changed at this moment."""
        return self._changing.locked()

    def state_known(self) -> None:
        """Note that the port has its first state; from any thread."""
        self._loop.call_soon_threadsafe(self._first_state.set)

    @asynccontextmanager
    async def _alone(self) -> AsyncIterator[None]:
        if self._changing.locked():
            raise Busy(problem=CHANGING)
        async with self._changing:
            yield

    def _open(self, port: PortSettings) -> None:
        self._first_state.clear()
        thread = self._create(port)
        self._connection.thread = thread
        thread.start()

    async def _wait_for_state(self) -> None:
        """Wait for the port's first state. Raises the errors of its address."""
        try:
            async with asyncio.timeout(_FIRST_STATE):
                await self._first_state.wait()
        except TimeoutError:
            return  # the state will show the result
        thread = self._connection.thread
        if thread is not None and isinstance(thread.failure, UsageError):
            raise thread.failure
