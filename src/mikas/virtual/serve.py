"""A virtual unit for other programs: its wire on a pty or a TCP port, in real time.

The only place under `virtual` that does I/O and knows the real clock. One event loop serves any
number of buses. Bytes leave when their last bit would have left the wire, so a tester at the other
end sees the pace of 9600 baud. The loop wants a selector with microseconds (`run`): epoll's
milliseconds are as long as a byte.

When nobody reads, bytes are thrown away, as an adapter on a port that nobody has opened does.
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
_AT_ONCE = 64  # bytes of one wire that are made up for before other wires have their turn


class ServedBus:
    """Runs one bus in real time on an event loop; `write` takes what the tester gets.

    `clock` is the bus's clock. `feed` is for what the tester sends.
    """

    def __init__(
        self, bus: Bus, clock: Callable[[], float], write: Callable[[bytes], None]
    ) -> None:
        self._bus = bus
        self._clock = clock
        self._write = write
        self._loop = asyncio.get_running_loop()
        self._timer: asyncio.TimerHandle | None = None
        self._seen = clock()

    def feed(self, data: bytes) -> None:
        """The tester wrote `data`, just now.

        If this loop woke late, something on the wire is overdue; the tester's bytes came before it.
        """
        overdue = nextafter(self._bus.next_event(), -inf)
        self._bus.send(data, min(self._clock(), max(self._seen, overdue)))
        self.run_on()

    def send_break(self, seconds: float) -> None:
        """The tester held the line low."""
        self._bus.send_break(seconds, self._clock())
        self.run_on()

    def run_on(self) -> None:
        """Runs the wire to the present, hands out what arrived, and comes back when due."""
        bus = self._bus
        enough = max(self._seen, bus.next_event()) + _AT_ONCE * bus.byte_time
        now = min(self._clock(), enough)
        data, _ = bus.take(now)
        self._seen = now
        if data:
            self._write(data)
        if self._timer:
            self._timer.cancel()
        due = bus.next_event()
        self._timer = (
            None
            if due == inf
            else self._loop.call_later(max(0.0, due - self._clock()), self.run_on)
        )

    def stop(self) -> None:
        """Nothing more is done."""
        if self._timer:
            self._timer.cancel()


class PtyPort:
    """A bus on a pseudo-terminal of its own; `url` is the path that a tester opens. POSIX only."""

    def __init__(self, bus: Bus, clock: Callable[[], float]) -> None:
        import pty
        import tty

        self._master, self._slave = pty.openpty()
        # The slave stays open here, so that a tester that goes does not take the port with it.
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.url = os.ttyname(self._slave)
        self._served = ServedBus(bus, clock, self._write)
        self._loop = asyncio.get_running_loop()
        self._loop.add_reader(self._master, self._read)
        self._served.run_on()

    def _read(self) -> None:
        with suppress(BlockingIOError):
            self._served.feed(os.read(self._master, _READ))

    def _write(self, data: bytes) -> None:
        with suppress(BlockingIOError):
            os.write(self._master, data)

    def close(self) -> None:
        """Takes the port away: whoever has it open sees its adapter unplugged."""
        self._served.stop()
        self._loop.remove_reader(self._master)
        os.close(self._slave)
        os.close(self._master)


class TcpPort:
    """A bus on a TCP port, for one tester at a time; another one is turned away. Made by `open`."""

    def __init__(self, bus: Bus, clock: Callable[[], float]) -> None:
        self.url = ""
        self._served = ServedBus(bus, clock, self._write)
        self._server: asyncio.Server | None = None
        self._tester: asyncio.Transport | None = None

    @classmethod
    async def open(cls, bus: Bus, clock: Callable[[], float], host: str, port: int) -> TcpPort:
        """Listens on `host:port`; with port 0 the system chooses one. Raises `PortFailed`."""
        served = cls(bus, clock)
        await served._listen(host, port)
        return served

    async def _listen(self, host: str, port: int) -> None:
        loop = asyncio.get_running_loop()
        try:
            self._server = await loop.create_server(lambda: _Connection(self), host, port)
        except OSError as error:
            raise PortFailed(url=f"{host}:{port}", problem=reason_of(error)) from error
        shown = f"[{host}]" if ":" in host else host  # an IPv6 address
        self.url = f"socket://{shown}:{self._server.sockets[0].getsockname()[1]}"
        self._served.run_on()

    def accept(self, tester: asyncio.Transport) -> bool:
        """Whether `tester` gets the wire; it does not while another one has it."""
        if self._tester is not None:
            return False
        self._tester = tester
        return True

    def leave(self, tester: asyncio.Transport) -> None:
        """`tester` hung up."""
        if tester is self._tester:
            self._tester = None

    def feed(self, data: bytes) -> None:
        """The tester wrote `data`."""
        self._served.feed(data)

    def _write(self, data: bytes) -> None:
        if self._tester and self._tester.get_write_buffer_size() < _READ:
            self._tester.write(data)

    def close(self) -> None:
        """Hangs up and stops listening."""
        self._served.stop()
        if self._tester:
            self._tester.abort()
        if self._server:
            self._server.close()


class _Connection(asyncio.Protocol):
    """Somebody on a `TcpPort`."""

    def __init__(self, port: TcpPort) -> None:
        self._port = port

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        if not self._port.accept(transport):
            transport.abort()

    def data_received(self, data: bytes) -> None:
        self._port.feed(data)

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002  (why is all the same)
        self._port.leave(self._transport)


def run(main: Coroutine[Any, Any, T]) -> T:
    """`asyncio.run` on a loop whose timers are good to microseconds."""
    with asyncio.Runner(
        loop_factory=lambda: asyncio.SelectorEventLoop(selectors.SelectSelector())
    ) as runner:
        return runner.run(main)
