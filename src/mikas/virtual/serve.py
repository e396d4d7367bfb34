"""A virtual unit for other programs: its wire on a pty or a TCP port, in real time.

The only module under `virtual` with I/O and the real clock. One event loop serves any number of
buses. A byte is written when its last bit leaves the wire, so the tester receives at 9600 baud. The
loop needs a selector with microseconds (`run`): epoll's milliseconds are as long as a byte.

No tester costs memory. Its bytes are read as fast as the wire takes them: `_MOST_WAITING` wait
here, the others in the tester's own system, and none is lost. They go with the connection. Bytes
that a tester does not read are dropped.
"""

from __future__ import annotations

import asyncio
import os
import selectors
import socket
import sys
from collections.abc import Callable, Coroutine
from contextlib import suppress
from math import ceil, inf, nextafter
from typing import Any, TypeVar

from mikas.errors import PortFailed, reason_of
from mikas.i18n import Text
from mikas.virtual.bus import Bus
from mikas.virtual.instruments import VirtualInstrument

T = TypeVar("T")
_READ = 4096
_FOLLOW = 1.0  # s between two steps of an engine that no request reads
_MOST_OVERDUE = 64  # overdue bytes of one wire before the next wire's turn
_MOST_WAITING = 1024  # bytes of a tester that wait for the wire: about two of the longest requests
_GIVES_WAY = 60.0  # s; a tester that is idle for so long can't keep another one out
_KEEP_ALIVE = {"TCP_KEEPIDLE": 30, "TCP_KEEPINTVL": 10, "TCP_KEEPCNT": 3}  # s, s, probes
_OTHER_ADDRESS = Text(
    "Choose another port number, or an address of this computer.",
    "Выберите другой номер порта или адрес этого компьютера.",
)
_MOST_UNREAD = 512  # bytes of an instrument
_SOCKET_BUFFER = 1 << 14  # bytes of the system's buffers for a tester, in each direction


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
        self._resuming: asyncio.TimerHandle | None = None
        self._latest = clock()
        self._following = self._loop.call_later(_FOLLOW, self._follow)

    def feed(self, data: bytes) -> None:
        """Put `data` of the tester on the wire now, before any overdue event of a late loop.

        With `waiting` of `_MOST_WAITING` bytes or more, `_pause` is called, and `_resume` later.
        """
        overdue = nextafter(self._bus.next_event(), -inf)
        self._bus.send(data, min(self._clock(), max(self._latest, overdue)))
        self.advance()
        if self.waiting >= _MOST_WAITING and self._resuming is None:
            self._pause()
            self._resume_later()

    @property
    def waiting(self) -> int:
        """The number of the tester's bytes that wait for the wire."""
        return ceil(max(0.0, self._bus.sending_until - self._latest) / self._bus.byte_time)

    def drop_waiting(self) -> None:
        """Drop the waiting bytes: the tester has gone."""
        self._bus.drop_unsent(self._latest)
        if self._resuming:
            self._resuming.cancel()
            self._resuming = None
        self.advance()

    def _pause(self) -> None:
        """Read no more of the tester's bytes, until `_resume`."""

    def _resume(self) -> None:
        """Read the tester's bytes again."""

    def _resume_later(self) -> None:
        half = self._bus.byte_time * _MOST_WAITING / 2
        self._resuming = self._loop.call_later(half, self._try_to_resume)

    def _try_to_resume(self) -> None:
        self._resuming = None
        self.advance()
        if self.waiting < _MOST_WAITING:
            self._resume()
        else:  # this computer is slower than the wire
            self._resume_later()

    def advance(self) -> None:
        """Run the wire to the present, write received bytes, schedule the next call."""
        bus = self._bus
        limit = max(self._latest, bus.next_event()) + _MOST_OVERDUE * bus.byte_time
        now = min(self._clock(), limit)
        data, _ = bus.collect_received(now)
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
        for call in (self._following, self._timer, self._resuming):
            if call:
                call.cancel()


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
        self.url: str = os.ttyname(self._slave)
        self._resume()
        self.advance()

    def _pause(self) -> None:
        self._loop.remove_reader(self._master)

    def _resume(self) -> None:
        self._loop.add_reader(self._master, self._read)

    def _read(self) -> None:
        with suppress(BlockingIOError):
            self.feed(os.read(self._master, max(1, _MOST_WAITING - self.waiting)))

    def _send(self, data: bytes) -> None:
        with suppress(BlockingIOError):
            os.write(self._master, data)

    def close(self) -> None:
        """Remove the port: a tester sees an unplugged adapter."""
        self.stop()
        self._loop.remove_reader(self._master)
        os.close(self._slave)
        os.close(self._master)


class InstrumentPty:
    """A virtual instrument on a pseudo-terminal of its own, in real time. POSIX only.

    Bytes that no program reads are dropped, as at a serial port.
    """

    def __init__(self, instrument: VirtualInstrument, clock: Callable[[], float]) -> None:
        import pty
        import tty

        self._instrument, self._clock = instrument, clock
        self._loop = asyncio.get_running_loop()
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.url: str = os.ttyname(self._slave)
        self.name: str = instrument.name
        self._timer = self._loop.call_soon(self._send)

    def _send(self) -> None:
        import fcntl
        import termios

        for _, message in self._instrument.sent(self._clock()):
            waiting = int.from_bytes(
                fcntl.ioctl(self._slave, termios.FIONREAD, bytes(4)), sys.byteorder
            )
            if waiting > _MOST_UNREAD:
                termios.tcflush(self._slave, termios.TCIFLUSH)
            with suppress(BlockingIOError):
                os.write(self._master, message)
        delay = max(0.0, self._instrument.next_time - self._clock())
        self._timer = self._loop.call_later(delay, self._send)

    def close(self) -> None:
        """Remove the port: a reader sees an unplugged adapter."""
        self._timer.cancel()
        os.close(self._slave)
        os.close(self._master)


class TcpPort(ServedBus):
    """A bus on a TCP port, from `open`. One tester at a time; another connection is closed.

    But a tester that for a minute was idle, took no bytes or sent more than the wire carries gives
    way: it may have vanished, or be no tester at all.
    """

    def __init__(self, bus: Bus, clock: Callable[[], float]) -> None:
        super().__init__(bus, clock, self._send)
        self.url = ""
        self.tester: asyncio.Transport | None = None
        self._active = -inf  # when the tester last showed that it is one
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
            failed = PortFailed(
                url=f"{host}:{port}", problem=reason_of(error), advice=_OTHER_ADDRESS
            )
            raise failed.caused_by(error) from error
        for each in server.sockets:  # connections have the same buffers
            each.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _SOCKET_BUFFER)
            each.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SOCKET_BUFFER)
        url_host = f"[{host}]" if ":" in host else host  # IPv6
        tcp_port.url = f"socket://{url_host}:{server.sockets[0].getsockname()[1]}"
        tcp_port._server = server
        tcp_port.advance()
        return tcp_port

    def accept(self, transport: asyncio.Transport) -> None:
        """Take `transport` for the tester, or close it."""
        now = self._clock()
        if self.tester is not None:
            if now - self._active < _GIVES_WAY:
                transport.abort()
                return
            self.release(self.tester)
        self.tester, self._active = transport, now

    def release(self, transport: asyncio.Transport) -> None:
        """Close `transport`; if that was the tester, drop its bytes."""
        transport.abort()
        if self.tester is transport:
            self.tester = None
            self.drop_waiting()

    def feed(self, data: bytes) -> None:
        idle = self._bus.next_event() == inf and self._bus.sending_until <= self._clock()
        if idle or not self.waiting:  # a tester waits for the answer
            self._active = self._clock()
        super().feed(data)

    def _pause(self) -> None:
        if self.tester:
            self.tester.pause_reading()

    def _resume(self) -> None:
        if self.tester:
            self.tester.resume_reading()

    def _send(self, data: bytes) -> None:
        if self.tester and (unsent := self.tester.get_write_buffer_size()) < _READ:
            if not unsent:
                self._active = self._clock()
            self.tester.write(data)

    def close(self) -> None:
        """Close the connection and stop listening."""
        self.stop()
        if self.tester:
            self.tester.abort()
        if self._server:
            self._server.close()


class _Connection(asyncio.BufferedProtocol):
    """A connection to a `TcpPort`."""

    def __init__(self, port: TcpPort) -> None:
        self._port = port
        self._buffer = bytearray(_MOST_WAITING)

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        connection = transport.get_extra_info("socket")
        with suppress(OSError):  # it has gone already
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
            for name, value in _KEEP_ALIVE.items():
                if hasattr(socket, name):  # macOS and Windows lack some
                    connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
        self._port.accept(transport)

    def get_buffer(self, sizehint: int) -> memoryview:  # noqa: ARG002  (the wire says how much)
        return memoryview(self._buffer)[: max(1, _MOST_WAITING - self._port.waiting)]

    def buffer_updated(self, nbytes: int) -> None:
        self._port.feed(bytes(self._buffer[:nbytes]))

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002  (any reason)
        self._port.release(self._transport)


def run(main: Coroutine[Any, Any, T]) -> T:
    """Run `main` on a loop whose timers have microseconds."""
    with asyncio.Runner(
        loop_factory=lambda: asyncio.SelectorEventLoop(selectors.SelectSelector())
    ) as runner:
        return runner.run(main)
