"""The entrance with TLS: one socket, plain HTTP from this computer, TLS from the network.

A browser on this computer would warn of a self-signed certificate, and no other computer can read
what goes over 127.0.0.1. Everyone else has to shake hands first, within some seconds; a client that
speaks plain HTTP, or nothing, is closed. Handshakes are counted for each address, so that half-open
ones do not take all descriptors.
"""

from __future__ import annotations

import asyncio
import socket
import ssl
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

PLAIN: Final = "127.0.0.1"
"""The address of this computer at which connections are not encrypted."""
_HANDSHAKE: Final = 10.0  # s
_GOODBYE: Final = 2.0  # s for the other side to end TLS
_MOST: Final = 64  # handshakes at a time
_MOST_OF_ONE: Final = 8  # of one address; browsers open six connections
_OUT_OF_DESCRIPTORS: Final = 0.5  # s until the next try


class Entrance:
    """Accepts connections on `own`, a listening socket, and gives each a protocol of `create`."""

    def __init__(
        self,
        own: socket.socket,
        create: Callable[[], asyncio.Protocol],
        context: ssl.SSLContext,
    ) -> None:
        self._own, self._create, self._context = own, create, context
        self._accepting: asyncio.Task[None] | None = None
        self._shaking: Counter[str] = Counter()
        self._tasks: set[asyncio.Task[None]] = set()

    def open(self) -> None:
        """Begin to accept; in the event loop."""
        self._own.setblocking(False)
        self._accepting = asyncio.create_task(self._accept())

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
                connection, (address, *_) = await loop.sock_accept(self._own)
            except OSError:
                await asyncio.sleep(_OUT_OF_DESCRIPTORS)
                continue
            task = asyncio.create_task(self._admit(connection, address))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    async def _admit(self, connection: socket.socket, address: str) -> None:
        loop = asyncio.get_running_loop()
        with _closed_on_error(connection):
            if connection.getsockname()[0] == PLAIN:
                await loop.connect_accepted_socket(self._create, connection)
                return
            with self._handshake(address):
                await loop.connect_accepted_socket(
                    self._create,
                    connection,
                    ssl=self._context,
                    ssl_handshake_timeout=_HANDSHAKE,
                    ssl_shutdown_timeout=_GOODBYE,
                )

    @contextmanager
    def _handshake(self, address: str) -> Iterator[None]:
        """Count a handshake. Raises `OSError` if there are too many."""
        shaking = self._shaking
        if shaking.total() >= _MOST or shaking[address] >= _MOST_OF_ONE:
            raise ConnectionRefusedError
        shaking[address] += 1
        try:
            yield
        finally:
            shaking[address] -= 1
            if not shaking[address]:
                del shaking[address]


@contextmanager
def _closed_on_error(connection: socket.socket) -> Iterator[None]:
    """Close the connection if it can't be admitted: plain HTTP, silence, an early end, a crowd."""
    try:
        yield
    except OSError:  # those of TLS are, too
        connection.close()
