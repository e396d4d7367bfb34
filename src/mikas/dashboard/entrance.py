"""The entrance: accepts connections on one socket, and gives each the protocol of the server.

With TLS, this computer gets plain HTTP and the network TLS. A browser on this computer would warn
of a self-signed certificate, and no other computer can read what goes over 127.0.0.1. Everyone else
has to shake hands first; a client that speaks plain HTTP, or nothing, is closed. `connections`
counts and bounds all of them from the moment of acceptance.
"""

from __future__ import annotations

import asyncio
import logging
import socket
import ssl
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final
from weakref import WeakSet

from mikas.dashboard.connections import (
    HEAD_SECONDS,
    AcceptedSocket,
    TcpConnections,
    is_exhausted,
)

PLAIN: Final = "127.0.0.1"
"""The address of this computer at which connections are not encrypted."""
_GOODBYE: Final = 2.0  # s for the other side to end TLS
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
        self._tasks: set[asyncio.Task[None]] = set()
        self._network: WeakSet[asyncio.Transport] = WeakSet()

    def open(self) -> None:
        """Begin to accept; in the event loop."""
        self.own.setblocking(False)
        asyncio.get_running_loop().add_reader(self.own, self._accept)

    def admit_network(self, context: ssl.SSLContext | None) -> None:
        """Serve the network by `context`; None: close its connections, and refuse new ones."""
        self.context = context
        if context is None:
            for task in self._tasks:
                task.cancel()  # handshakes; a connection of this computer takes none
            for transport in tuple(self._network):
                transport.abort()

    async def close(self) -> None:
        """Accept no more, and end the handshakes; connections stay."""
        asyncio.get_running_loop().remove_reader(self.own)
        if self._again is not None:
            self._again.cancel()
        for task in self._tasks:
            task.cancel()
        if self._tasks:
            await asyncio.wait(self._tasks)

    def _accept(self) -> None:
        """Accept those that wait."""
        loop = asyncio.get_running_loop()
        try:
            for _ in range(_AT_ONCE):
                task = loop.create_task(self._admit(self.guard.accept(self.own)))
                self._tasks.add(task)
                task.add_done_callback(self._tasks.discard)
        except (BlockingIOError, InterruptedError, ConnectionAbortedError):
            return  # no other one waits, or it has gone already
        except OSError as error:
            if is_exhausted(error):
                _log.warning("no more connections: the system has no files left; trying again")
            loop.remove_reader(self.own)
            self._again = loop.call_later(_OUT_OF_DESCRIPTORS, self.open)

    async def _admit(self, accepted: AcceptedSocket) -> None:
        loop = asyncio.get_running_loop()
        try:
            context = self.context
            is_plain = self.plain or accepted.getsockname()[0] == PLAIN
            if not is_plain and context is None:  # closed to the network
                accepted.close()
                return
            transport, protocol = await loop.connect_accepted_socket(
                self.create,
                accepted,
                ssl=None if is_plain else context,
                ssl_handshake_timeout=None if is_plain else HEAD_SECONDS,
                ssl_shutdown_timeout=None if is_plain else _GOODBYE,
            )
            accepted.connection.attach(transport, protocol)
            if is_plain:
                return
            self._network.add(transport)
            if self.context is not context:  # closed, or opened again, during the handshake
                transport.abort()
        except OSError:  # of TLS, too: plain HTTP, silence, an early end
            accepted.close()
