"""Runs the application: a socket of our own, uvicorn on it, and a clean end.

One worker, no access log, WebSockets pinged so that a lid that was closed is noticed. The first
Ctrl-C closes recordings and lets go of the port, the second ends at once.
"""

from __future__ import annotations

import errno
import logging
import socket
import sys
from collections.abc import Callable
from contextlib import suppress

import uvicorn
from fastapi import FastAPI

from mikas.errors import UsageError, reason_of
from mikas.language import Text

FIRST_PORT = 8071
_TRIED = 20
_SEND_BUFFER = 1 << 16  # what a slow client may have under way in the system; the rest waits here
_PING = 20.0
_GRACE = 3


def listening(port: int | None, *, lan: bool) -> socket.socket:
    """A socket on `port`, or on the first free one from 8071 on. Raises `UsageError`."""
    wanted = range(FIRST_PORT, FIRST_PORT + _TRIED) if port is None else [port]
    failure: OSError | None = None
    for number in (*wanted, *([0] if port is None else [])):
        try:
            return _bound("0.0.0.0" if lan else "127.0.0.1", number)
        except OSError as error:
            failure = error
            if error.errno not in (errno.EADDRINUSE, errno.EACCES):
                break
    assert failure is not None
    why = reason_of(failure)
    raise UsageError(
        problem=Text(
            f"The dashboard can't listen on port {port or FIRST_PORT}: {why.en}",
            f"Панель не может занять порт {port or FIRST_PORT}: {why.ru}",
        )
    ) from failure


def _bound(host: str, port: int) -> socket.socket:
    own = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        if sys.platform != "win32":  # there it would share the port with whoever has it
            own.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        own.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
        own.bind((host, port))
        own.listen()  # bound alone, two programs may have it, and the second finds out too late
    except OSError:
        own.close()
        raise
    return own


def own_addresses() -> tuple[str, ...]:
    """This computer's addresses in the network, the likeliest first; then its name."""
    found: dict[str, None] = {}
    with suppress(OSError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect(("192.0.2.1", 9))  # nothing is sent: the system picks the way out
        found[probe.getsockname()[0]] = None
    name = socket.gethostname()
    with suppress(OSError):
        for *_, address in socket.getaddrinfo(name, None, socket.AF_INET):
            found[str(address[0])] = None
    numbers = [address for address in found if not address.startswith(("127.", "0."))]
    return (*numbers, name, f"{name}.local")


def serve(app: FastAPI, own: socket.socket, *, ready: Callable[[], None]) -> None:
    """Serves `app` on `own` until Ctrl-C; `ready` is called once it answers.

    Raises `KeyboardInterrupt` afterwards, as Ctrl-C does everywhere.
    """
    Server(app, ready=ready).run(sockets=[own])


class Server(uvicorn.Server):
    """uvicorn as we want it."""

    def __init__(self, app: FastAPI, *, ready: Callable[[], None] = lambda: None) -> None:
        logging.getLogger("uvicorn.error").setLevel(logging.ERROR)
        super().__init__(
            uvicorn.Config(
                app,
                log_config=None,
                access_log=False,
                lifespan="on",
                ws="websockets-sansio",
                ws_max_size=1 << 16,
                ws_ping_interval=_PING,
                ws_ping_timeout=_PING,
                ws_per_message_deflate=False,  # a loopback has room, a core has not
                server_header=False,
                timeout_graceful_shutdown=_GRACE,
            )
        )
        self._ready = ready

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Tells when it answers."""
        await super().startup(sockets)
        if not self.should_exit:
            self._ready()
