"""Runs the application: a socket of our own, uvicorn on it, and a clean end.

One worker, no access log, WebSockets pinged so that a lid that was closed is noticed. The first
Ctrl-C closes recordings and the port, the second ends the process at once.
"""

from __future__ import annotations

import asyncio
import errno
import logging
import os
import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

import uvicorn
from fastapi import FastAPI

from mikas.errors import UsageError, reason_of
from mikas.i18n import Text

FIRST_PORT = 8071
_TRIED = 20
_SEND_BUFFER = 1 << 16  # what a slow client may have under way in the system; the rest waits here
_PING = 20.0
_GRACE = 3
_INTERRUPTED = 130  # as docs/cli.md has it
_NO_NEWS = (
    "ASGI callable returned without completing handshake.",  # a WebSocket that was refused
    "Cancel %s running task(s), timeout graceful shutdown exceeded",  # who asked has had to go
)


def listen(port: int | None, *, lan: bool) -> socket.socket:
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
            f"The dashboard can't listen on port {port or FIRST_PORT}: {why.en}; name another with "
            "--host-port, or none: then it takes a free one",
            f"Панель не может занять порт {port or FIRST_PORT}: {why.ru}; укажите другой ключом "
            "--host-port или не указывайте: тогда найдётся свободный",
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

    Raises `KeyboardInterrupt` afterwards, as Ctrl-C does everywhere; a second Ctrl-C meanwhile
    ends the process at once.
    """
    server = Server(app, ready=ready)
    server.run(sockets=[own])
    server.finish_signal()


def _is_news(record: logging.LogRecord) -> bool:
    """Whether a person at the terminal has any use of it."""
    error = record.exc_info[1] if record.exc_info else None
    return record.msg not in _NO_NEWS and not isinstance(error, asyncio.CancelledError)


class Server(uvicorn.Server):
    """uvicorn as we want it."""

    def __init__(self, app: FastAPI, *, ready: Callable[[], None] = lambda: None) -> None:
        log = logging.getLogger("uvicorn.error")
        log.setLevel(logging.ERROR)
        log.addFilter(_is_news)
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
        self._signal: int | None = None  # by which signal

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Ends in good order at the first signal; that for Ctrl-C stays with us to the end."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        signals = [signal.SIGINT, signal.SIGTERM]
        if sys.platform == "win32":
            signals.append(signal.SIGBREAK)
        before = {it: signal.signal(it, self.handle_exit) for it in signals}
        try:
            yield
        finally:
            for it, handler in before.items():
                if it != signal.SIGINT:
                    signal.signal(it, handler)

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:  # noqa: ARG002  (uvicorn's)
        """The first signal asks, the second Ctrl-C does not wait."""
        if self._signal is not None and sig == signal.SIGINT:
            os._exit(_INTERRUPTED)
        self._signal = self._signal or sig
        self.should_exit = True

    def finish_signal(self) -> None:
        """What the signal would have done by itself."""
        if self._signal == signal.SIGINT:
            # All is closed, the rest takes a moment: one more has nothing to end, and would only
            # show in the status.
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            raise KeyboardInterrupt
        if self._signal is not None:
            signal.raise_signal(self._signal)

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Tells when it answers."""
        await super().startup(sockets)
        if not self.should_exit:
            self._ready()
