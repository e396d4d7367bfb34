"""A virtual unit for other programs: its wire on a pty or a TCP port, in real time.

The only module under `virtual` with I/O and the real clock. One event loop serves any number of
buses. A byte is written when its last bit leaves the wire, so the tester receives at 9600 baud. The
loop needs a selector with microseconds (`run`): epoll's milliseconds are as long as a byte. Bytes
that no tester reads are dropped.
"""

from __future__ import annotations

import asyncio
import os
import selectors
from collections.abc import Callable, Coroutine
from contextlib import suppress
from math import inf, nextafter
from typing import Any, TypeVar

from mikas.errors import PortFailed, reason_of
from mikas.virtual.bus import Bus

T = TypeVar("T")
_READ = 4096
_FOLLOW = 1.0  # s between two steps of an engine that no request reads
_MOST_OVERDUE = 64  # overdue bytes of one wire before the next wire's turn


class ServedBus:
    """A bus run in real time, by its own `clock`; `write` takes the bytes for the tester."""

    def __init__(
        self, bus: Bus, clock: Callable[[], float], write: Callable[[bytes], None]
    ) -> None:
        self._bus = bus
        self._clock = clock
        self._write = write
        self._loop = asyncio.get_running_loop()
        self._timer: asyncio.TimerHandle | None = None
        self._latest = clock()
        self._following = self._loop.call_later(_FOLLOW, self._follow)

    def feed(self, data: bytes) -> None:
        """Put `data` of the tester on the wire now, before any overdue event of a late loop."""
        overdue = nextafter(self._bus.next_event(), -inf)
        self._bus.send(data, min(self._clock(), max(self._latest, overdue)))
        self.advance()

    def advance(self) -> None:
        """Run the wire to the present, write received bytes, schedule the next call."""
        bus = self._bus
        limit = max(self._latest, bus.next_event()) + _MOST_OVERDUE * bus.byte_time
        now = min(self._clock(), limit)
        data, _ = bus.take(now)
        self._latest = now
        if data:
            self._write(data)
        if self._timer:
            self._timer.cancel()
        due = bus.next_event()
        self._timer = (
            None
            if due == inf
            else self._loop.call_later(max(0.0, due - self._clock()), self.advance)
        )

    def _follow(self) -> None:
        """Run the engine to the present, though nothing is requested.

        It takes 6 ms for each second. After half an hour the first request would wait for 10 s.
        """
        self._bus.ecu.responder.car.engine_speed(self._clock())
        self._following = self._loop.call_later(_FOLLOW, self._follow)

    def stop(self) -> None:
        """Cancel the next calls."""
        self._following.cancel()
        if self._timer:
            self._timer.cancel()


class PtyPort(ServedBus):
    """A bus on a pseudo-terminal; `url` is the path that a tester opens. POSIX only."""

    def __init__(self, bus: Bus, clock: Callable[[], float]) -> None:
        import pty
        import tty

        super().__init__(bus, clock, self._send)
        self._master, self._slave = pty.openpty()
        # The slave stays open here, so that the port remains when a tester closes it.
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.url = os.ttyname(self._slave)
        self._loop.add_reader(self._master, self._read)
        self.advance()

    def _read(self) -> None:
        with suppress(BlockingIOError):
            self.feed(os.read(self._master, _READ))

    def _send(self, data: bytes) -> None:
        with suppress(BlockingIOError):
            os.write(self._master, data)

    def close(self) -> None:
        """Remove the port: a tester sees an unplugged adapter."""
        self.stop()
        self._loop.remove_reader(self._master)
        os.close(self._slave)
        os.close(self._master)


class TcpPort(ServedBus):
    """A bus on a TCP port, from `open`. One tester at a time; another connection is closed."""

    def __init__(self, bus: Bus, clock: Callable[[], float]) -> None:
        super().__init__(bus, clock, self._send)
        self.url = ""
        self.tester: asyncio.Transport | None = None
        self._server: asyncio.Server | None = None

    @classmethod
    async def open(cls, bus: Bus, clock: Callable[[], float], host: str, port: int) -> TcpPort:
        """Listen on `host:port`; port 0: the system chooses one. Raises `PortFailed`."""
        tcp_port = cls(bus, clock)
        try:
            server = await asyncio.get_running_loop().create_server(
                lambda: _Connection(tcp_port), host, port
            )
        except OSError as error:
            raise PortFailed(url=f"{host}:{port}", problem=reason_of(error)) from error
        url_host = f"[{host}]" if ":" in host else host  # IPv6
        tcp_port.url = f"socket://{url_host}:{server.sockets[0].getsockname()[1]}"
        tcp_port._server = server
        tcp_port.advance()
        return tcp_port

    def _send(self, data: bytes) -> None:
        if self.tester and self.tester.get_write_buffer_size() < _READ:
            self.tester.write(data)

    def close(self) -> None:
        """Close the connection and stop listening."""
        self.stop()
        if self.tester:
            self.tester.abort()
        if self._server:
            self._server.close()


class _Connection(asyncio.Protocol):
    """A connection to a `TcpPort`."""

    def __init__(self, port: TcpPort) -> None:
        self._port = port

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        if self._port.tester is None:
            self._port.tester = transport
        else:
            transport.abort()

    def data_received(self, data: bytes) -> None:
        self._port.feed(data)

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002  (any reason)
        if self._port.tester is self._transport:
            self._port.tester = None


def run(main: Coroutine[Any, Any, T]) -> T:
    """Run `main` on a loop whose timers have microseconds."""
    with asyncio.Runner(
        loop_factory=lambda: asyncio.SelectorEventLoop(selectors.SelectSelector())
    ) as runner:
        return runner.run(main)
