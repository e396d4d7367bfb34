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
_MOST_OVERDUE = 64  # overdue bytes of one wire before the next wire's turn


class ServedBus:
    """Runs one bus in real time on an event loop; `write` takes the bytes for the tester.

    `clock` is the bus's clock.
    """

    def __init__(
        self, bus: Bus, clock: Callable[[], float], write: Callable[[bytes], None]
    ) -> None:
        self._bus = bus
        self._clock = clock
        self._write = write
        self._loop = asyncio.get_running_loop()
        self._timer: asyncio.TimerHandle | None = None
        self._latest = clock()

    def feed(self, data: bytes) -> None:
        """Put `data` of the tester on the wire now, before any overdue event of a late loop."""
        overdue = nextafter(self._bus.next_event(), -inf)
        self._bus.send(data, min(self._clock(), max(self._latest, overdue)))
        self.advance()

    def send_break(self, seconds: float) -> None:
        """Hold the line low, as the tester does."""
        self._bus.send_break(seconds, self._clock())
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

    def stop(self) -> None:
        """Cancel the next call."""
        if self._timer:
            self._timer.cancel()


class PtyPort:
    """A bus on a pseudo-terminal; `url` is the path that a tester opens. POSIX only."""

    def __init__(self, bus: Bus, clock: Callable[[], float]) -> None:
        import pty
        import tty

        self._master, self._slave = pty.openpty()
        # The slave stays open here, so that the port remains when a tester closes it.
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.url = os.ttyname(self._slave)
        self._served = ServedBus(bus, clock, self._write)
        self._loop = asyncio.get_running_loop()
        self._loop.add_reader(self._master, self._read)
        self._served.advance()

    def _read(self) -> None:
        with suppress(BlockingIOError):
            self._served.feed(os.read(self._master, _READ))

    def _write(self, data: bytes) -> None:
        with suppress(BlockingIOError):
            os.write(self._master, data)

    def close(self) -> None:
        """Remove the port: a tester sees an unplugged adapter."""
        self._served.stop()
        self._loop.remove_reader(self._master)
        os.close(self._slave)
        os.close(self._master)


class TcpPort:
    """A bus on a TCP port, from `open`. One tester at a time; another connection is closed."""

    def __init__(self, bus: Bus, clock: Callable[[], float]) -> None:
        self.url = ""
        self._served = ServedBus(bus, clock, self._write)
        self._server: asyncio.Server | None = None
        self._tester: asyncio.Transport | None = None

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
        tcp_port._served.advance()
        return tcp_port

    def accept(self, tester: asyncio.Transport) -> bool:
        """Connect `tester` to the wire; False: another tester is connected."""
        if self._tester is not None:
            return False
        self._tester = tester
        return True

    def leave(self, tester: asyncio.Transport) -> None:
        """Disconnect `tester`."""
        if tester is self._tester:
            self._tester = None

    def feed(self, data: bytes) -> None:
        """Put `data` of the tester on the wire."""
        self._served.feed(data)

    def _write(self, data: bytes) -> None:
        if self._tester and self._tester.get_write_buffer_size() < _READ:
            self._tester.write(data)

    def close(self) -> None:
        """Close the connection and stop listening."""
        self._served.stop()
        if self._tester:
            self._tester.abort()
        if self._server:
            self._server.close()


class _Connection(asyncio.Protocol):
    """A connection to a `TcpPort`."""

    def __init__(self, port: TcpPort) -> None:
        self._port = port

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        if not self._port.accept(transport):
            transport.abort()

    def data_received(self, data: bytes) -> None:
        self._port.feed(data)

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002  (any reason)
        self._port.leave(self._transport)


def run(main: Coroutine[Any, Any, T]) -> T:
    """Run `main` on a loop whose timers have microseconds."""
    with asyncio.Runner(
        loop_factory=lambda: asyncio.SelectorEventLoop(selectors.SelectSelector())
    ) as runner:
        return runner.run(main)
