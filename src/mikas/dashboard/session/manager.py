"""The switch: which port, and the one session on it at a time.

Connecting, disconnecting and lending the port exclude each other; who comes second is refused, not
kept waiting. What a session tells is the hub's business (`tell`, `ended`).
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

from mikas.dashboard.errors import Busy
from mikas.dashboard.session.monitor import DIAGNOSIS, DISCONNECTED, OTHER_PORT, RECONNECTED
from mikas.dashboard.session.thread import Session
from mikas.dashboard.settings import Settings
from mikas.dashboard.wishes import Way
from mikas.errors import NoPortGiven, UsageError
from mikas.i18n import Text
from mikas.link.ports import listed
from mikas.link.urls import parse

_FIRST_WORD = 2.0  # s that `connect` waits for what the port says
CHANGING = Text("the connection is being changed", "соединение как раз меняется")


class Switch:
    """`begin` makes the session of a way and what goes with it, `over` is told that it has ended
    because somebody wanted it, and why.
    """

    def __init__(
        self,
        settings: Settings,
        way: Way | None,
        *,
        begin: Callable[[Way], Session],
        over: Callable[[Session, Text], None],
    ) -> None:
        self.way = way
        """How the unit is reached, or will be when the application starts; None: not at all."""
        self.session: Session | None = None
        self._settings = settings
        self._begin, self._over = begin, over
        self._changing = asyncio.Lock()
        self._first_word = asyncio.Event()

    def start(self) -> None:
        """To what is to be connected at once."""
        self._loop = asyncio.get_running_loop()
        if self.way is not None:
            self._open(self.way)

    async def connect(
        self, url: str | None, *, echo: str = "auto", wanted: Callable[[str], None] = lambda _: None
    ) -> None:
        """Connects to `url`, or to the one likely adapter; a connection that there is ends.

        `wanted` is given the URL when there is nothing wrong with the wish. Raises what is wrong
        with the wish; what is wrong with the line is told by the state.
        """
        async with self._alone():
            if url is None:
                url = await asyncio.to_thread(self.likely)
            parse(url)
            again = self.way is not None and self.way.url == url
            await self.close(RECONNECTED if again else OTHER_PORT)
            wanted(url)
            self.way = Way(url, echo)
            self._open(self.way)
            await self._listen()

    async def disconnect(self) -> None:
        """Lets go of the port."""
        async with self._alone():
            await self.close()
            self.way = None

    @asynccontextmanager
    async def lent(self) -> AsyncIterator[None]:
        """Lets go of the port meanwhile, and takes it again."""
        async with self._alone():
            way = self.way
            await self.close(DIAGNOSIS)
            try:
                yield
            finally:
                if way is not None:
                    self._open(way)

    async def close(self, why: Text = DISCONNECTED) -> None:
        """Ends the session, if there is one; `way` stays."""
        session, self.session = self.session, None
        if session is not None:
            await asyncio.to_thread(session.stop)
            self._over(session, why)

    def likely(self) -> str:
        """The URL of the one likely adapter. Raises `NoPortGiven`."""
        ports = self._settings.find()
        likely = [port.url for port in ports if port.likely]
        if len(likely) != 1:
            raise NoPortGiven(found=listed(ports))
        return likely[0]

    @property
    def changing(self) -> bool:
        """Whether the connection is being changed just now."""
        return self._changing.locked()

    def heard(self) -> None:
        """The port has said its first word; from any thread."""
        self._loop.call_soon_threadsafe(self._first_word.set)

    @asynccontextmanager
    async def _alone(self) -> AsyncIterator[None]:
        if self._changing.locked():
            raise Busy(problem=CHANGING)
        async with self._changing:
            yield

    def _open(self, way: Way) -> None:
        self._first_word.clear()
        session = self._begin(way)
        self.session = session
        session.start()

    async def _listen(self) -> None:
        """Until the port has said its first word. Raises what is wrong with its address."""
        try:
            async with asyncio.timeout(_FIRST_WORD):
                await self._first_word.wait()
        except TimeoutError:
            return  # it takes its time; the state will tell
        if self.session is not None and isinstance(self.session.failure, UsageError):
            raise self.session.failure
