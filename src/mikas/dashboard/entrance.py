"""The entrance with TLS: one socket, plain HTTP from this computer, TLS from the network.

A browser on this computer would warn of a self-signed certificate, and no other computer can read
what goes over 127.0.0.1. Everyone else has to shake hands first; a client that speaks plain HTTP,
or nothing, is closed. `connections` counts and bounds all of them from the moment of acceptance.
"""

from __future__ import annotations

import asyncio
import socket
import ssl
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final
from weakref import WeakSet

from mikas.dashboard.connections import HEAD_SECONDS

PLAIN: Final = "127.0.0.1"
"""The address of this computer at which connections are not encrypted."""
_GOODBYE: Final = 2.0  # s for the other side to end TLS
_OUT_OF_DESCRIPTORS: Final = 0.5  # s until the next try


class Entrance:
    """Accepts connections on `own`, a listening socket, and gives each a protocol of `create`."""

    def __init__(
        self,
        own: socket.socket,
        create: Callable[[], asyncio.Protocol],
        context: ssl.SSLContext | None,
    ) -> None:
        self._own, self._create, self._context = own, create, context
        self._accepting: asyncio.Task[None] | None = None
        self._tasks: set[asyncio.Task[None]] = set()
        self._network: WeakSet[asyncio.Transport] = WeakSet()

    def open(self) -> None:
        """Begin to accept; in the event loop."""
        self._own.setblocking(False)
        self._accepting = asyncio.create_task(self._accept())

    def admit_network(self, context: ssl.SSLContext | None) -> None:
        """Serve the network by `context`; None: close its connections, and refuse new ones."""
        self._context = context
        if context is None:
            for task in self._tasks:
                task.cancel()  # handshakes; a connection of this computer takes none
            for transport in tuple(self._network):
                transport.abort()

    async def close(self) -> None:
        """Accept no more, and end the handshakes; connections stay."""
        tasks = {*self._tasks, *filter(None, [self._accepting])}
        for task in tasks:
            task.cancel()
        if tasks:
            await asyncio.wait(tasks)

    async def _accept(self) -> None:
        loop = asyncio.get_running_loop()
        while True:
            try:
                connection, _ = await loop.sock_accept(self._own)
            except OSError:
                await asyncio.sleep(_OUT_OF_DESCRIPTORS)
                continue
            task = asyncio.create_task(self._admit(connection))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    async def _admit(self, connection: socket.socket) -> None:
        loop = asyncio.get_running_loop()
        with _closed_on_error(connection):
            if connection.getsockname()[0] == PLAIN:
                await loop.connect_accepted_socket(self._create, connection)
                return
            context = self._context
            if context is None:  # closed to the network
                connection.close()
                return
            transport, _ = await loop.connect_accepted_socket(
                self._create,
                connection,
                ssl=context,
                ssl_handshake_timeout=HEAD_SECONDS,
                ssl_shutdown_timeout=_GOODBYE,
            )
            self._network.add(transport)
            if self._context is not context:  # closed, or opened again, during the handshake
                transport.abort()


@contextmanager
def _closed_on_error(connection: socket.socket) -> Iterator[None]:
    """Close the connection if it can't be admitted: plain HTTP, silence, an early end."""
    try:
        yield
    except OSError:  # those of TLS are, too
        connection.close()
