"""The entrance: accepts connections on one socket, and gives each the protocol of the server.

With TLS, this computer gets plain HTTP and the network TLS. A browser on this computer would warn
of a self-signed certificate, and no other computer can read what goes over 127.0.0.1. Everyone else
has to shake hands first; a client that speaks plain HTTP, or nothing, is closed. `connections`
counts and bounds all of them from the moment of acceptance. It also ends those that shake hands or
say goodbye for too long: asyncio's own timers would cut clients off after a stall of this program.
"""

from __future__ import annotations

import asyncio
import logging
import socket
import ssl
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final, cast
from weakref import WeakSet

from mikas.dashboard.connections import (
    AcceptedSocket,
    TcpConnection,
    TcpConnections,
    is_exhausted,
)

PLAIN: Final = "127.0.0.1"
"""The address of this computer at which connections are not encrypted."""
_LONG: Final = 3600.0  # s of asyncio's own timers of TLS
_MOST_UNSENT: Final = 4 << 20  # bytes of a WebSocket, whose sender waits long before
_ENDING: Final = 2.0  # s for handshakes that were ended
_OUT_OF_DESCRIPTORS: Final = 0.5  # s until the next try
_AT_ONCE: Final = 64  # connections that are accepted before others get a turn

_log = logging.getLogger("mikas.dashboard")


@dataclass(eq=False)
class Entrance:
    """Accepts connections on `own`, a listening socket, and gives each a protocol of `create`.

    `context`: how the network is served; None: closed to it. `plain`: everyone gets plain HTTP.
    """

    own: socket.socket
    create: Callable[[], asyncio.Protocol]
    guard: TcpConnections
    context: ssl.SSLContext | None
    plain: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        self._again: asyncio.TimerHandle | None = None
        self._arriving: dict[asyncio.Task[None], TcpConnection] = {}
        self._network: WeakSet[TcpConnection] = WeakSet()

    def open(self) -> None:
        """Begin to accept; in the event loop."""
        self.own.setblocking(False)
        asyncio.get_running_loop().add_reader(self.own, self._accept)

    def admit_network(self, context: ssl.SSLContext | None) -> None:
        """Serve the network by `context`; None: close its connections, and refuse new ones."""
        self.context = context
        if context is None:
            self._end_handshakes()
            for connection in tuple(self._network):
                connection.drop()

    async def close(self) -> None:
        """Accept no more, and end the handshakes; connections stay."""
        asyncio.get_running_loop().remove_reader(self.own)
        if self._again is not None:
            self._again.cancel()
        self._end_handshakes()
        if self._arriving:
            await asyncio.wait(self._arriving, timeout=_ENDING)

    def _end_handshakes(self) -> None:
        # Not by the tasks: one that is cancelled before its first step closes no socket.
        for connection in self._arriving.values():
            if not self._is_plain(connection):
                connection.drop()

    def _is_plain(self, connection: TcpConnection) -> bool:
        return self.plain or connection.here == PLAIN

    def _accept(self) -> None:
        """Accept those that wait."""
        loop = asyncio.get_running_loop()
        try:
            for _ in range(_AT_ONCE):
                accepted = self.guard.accept(self.own)
                task = loop.create_task(self._admit(accepted))
                self._arriving[task] = accepted.connection
                task.add_done_callback(self._arriving.pop)
        except (BlockingIOError, InterruptedError, ConnectionAbortedError):
            return  # no other one waits, or it has gone already
        except Exception as error:  # any: it is tried again, not at once
            if is_exhausted(error):
                _log.warning("no more connections: the system has no files left; trying again")
            elif not isinstance(error, OSError):
                _log.error("a connection could not be accepted", exc_info=error)
            loop.remove_reader(self.own)
            self._again = loop.call_later(_OUT_OF_DESCRIPTORS, self.open)

    async def _admit(self, accepted: AcceptedSocket) -> None:
        is_plain = self._is_plain(accepted.connection)
        context = None if is_plain else self.context
        if context is None and not is_plain:  # closed to the network
            accepted.close()
            return
        try:
            await asyncio.get_running_loop().connect_accepted_socket(
                lambda: _Arrival(self, accepted.connection, context),
                accepted,
                ssl=context,
                ssl_handshake_timeout=None if context is None else _LONG,
                ssl_shutdown_timeout=None if context is None else _LONG,
            )
        except OSError:  # of TLS, too: plain HTTP, silence, an early end
            accepted.close()
        except Exception:  # of one connection; the others go on
            _log.exception("a connection could not be opened")
            accepted.close()

    def begin(
        self,
        connection: TcpConnection,
        transport: asyncio.Transport,
        context: ssl.SSLContext | None,
    ) -> None:
        """Give a connection its protocol; its handshake is over, if there was one."""
        is_over = context is not None and self.context is not context  # since it began
        if is_over or connection.dropped:
            transport.abort()
            return
        if context is not None:
            self._network.add(connection)
        protocol = self.create()
        served = cast("asyncio.Transport", ServedTransport(transport))
        connection.attach(served, protocol)
        transport.set_protocol(protocol)
        protocol.connection_made(served)


@dataclass
class _Arrival(asyncio.Protocol):
    """The protocol of a connection until it can be used: the server's then takes its place."""

    entrance: Entrance
    connection: TcpConnection
    context: ssl.SSLContext | None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Make way."""
        self.entrance.begin(self.connection, cast("asyncio.Transport", transport), self.context)


class ServedTransport:
    """A transport as the server may use it: closed any number of times, written to in any state.

    asyncio's of TLS loses its connection when it is closed a second time, as uvicorn does where a
    WebSocket is refused or ended: it can then neither be asked nor aborted. And a WebSocket whose
    client wants answers (pings), and takes none, is aborted before they fill the memory.
    """

    def __init__(self, transport: asyncio.Transport) -> None:
        self._transport = transport
        self._is_websocket = False

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401  (asyncio's)
        return getattr(self._transport, name)

    def set_protocol(self, protocol: asyncio.BaseProtocol) -> None:
        """Set the protocol: that of a WebSocket, in place of HTTP."""
        self._is_websocket = True
        self._transport.set_protocol(protocol)

    def close(self) -> None:
        """Close, unless it is closed."""
        if not self._transport.is_closing():
            self._transport.close()

    def write(self, data: bytes) -> None:
        """Write, unless it is closed."""
        if self._transport.is_closing():
            return
        if self._is_websocket and self._transport.get_write_buffer_size() > _MOST_UNSENT:
            self._transport.abort()
        else:
            self._transport.write(data)
