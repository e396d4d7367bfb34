"""The HTTP server: its socket, uvicorn with the application's settings, and a clean shutdown.

One worker, no access log; WebSockets are pinged to detect a computer that sleeps. The first Ctrl-C
closes recordings and the port, the second ends the process at once.
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

from mikas.errors import reason_of, usage_error

FIRST_PORT = 8071
_TRIED = 20
_SEND_BUFFER = 1 << 16  # bytes of a slow client that the system may queue
_PING = 20.0
_GRACE = 3
_INTERRUPTED = 130  # as docs/cli.md has it
_EXPECTED = (  # messages of uvicorn that report no error
    "ASGI callable returned without completing handshake.",  # a refused WebSocket
    "Cancel %s running task(s), timeout graceful shutdown exceeded",
)


def listen(port: int | None, *, lan: bool) -> socket.socket:
    """Return a socket on `port`, or on the first free one from 8071 on. Raises `UsageError`."""
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
    raise usage_error(
        f"The dashboard can't listen on port {port or FIRST_PORT}: {why.en}; choose another "
        "with --host-port, or omit it to take a free one",
        f"Панель не может занять порт {port or FIRST_PORT}: {why.ru}; укажите другой ключом "
        "--host-port или уберите его, тогда найдётся свободный",
    ) from failure


def _bound(host: str, port: int) -> socket.socket:
    own = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        if sys.platform != "win32":  # where the option would share the port with another program
            own.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        own.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
        own.bind((host, port))
        own.listen()  # without it, two programs may be bound to one port
    except OSError:
        own.close()
        raise
    return own


def own_addresses() -> tuple[str, ...]:
    """Return this computer's addresses in the network, the likeliest first, then its names."""
    found: dict[str, None] = {}
    with suppress(OSError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect(("192.0.2.1", 9))  # nothing is sent: the system chooses the interface
        found[probe.getsockname()[0]] = None
    name = socket.gethostname()
    with suppress(OSError):
        for *_, address in socket.getaddrinfo(name, None, socket.AF_INET):
            found[str(address[0])] = None
    numbers = [address for address in found if not address.startswith(("127.", "0."))]
    return (*numbers, name, f"{name}.local")


def serve(app: FastAPI, own: socket.socket, *, ready: Callable[[], None]) -> None:
    """Serve `app` on `own` until Ctrl-C; `ready` is called once the server responds.

    Raises `KeyboardInterrupt` after a clean shutdown; a second Ctrl-C ends the process at once.
    """
    server = Server(app, ready=ready)
    server.run(sockets=[own])
    server.finish_signal()


def _is_error(record: logging.LogRecord) -> bool:
    """Whether the record is an error that a person at the terminal can act on."""
    error = record.exc_info[1] if record.exc_info else None
    return record.msg not in _EXPECTED and not isinstance(error, asyncio.CancelledError)


class Server(uvicorn.Server):
    """uvicorn with the application's settings."""

    def __init__(self, app: FastAPI, *, ready: Callable[[], None] = lambda: None) -> None:
        log = logging.getLogger("uvicorn.error")
        log.setLevel(logging.ERROR)
        log.addFilter(_is_error)
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
                ws_per_message_deflate=False,  # on a loopback, bandwidth costs less than CPU time
                server_header=False,
                timeout_graceful_shutdown=_GRACE,
            )
        )
        self._ready = ready
        self._signal: int | None = None  # the first one received

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Shut down at the first signal; Ctrl-C stays handled until the end."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        signals = [signal.SIGINT, signal.SIGTERM]
        if sys.platform == "win32":
            signals.append(signal.SIGBREAK)
        before = {number: signal.signal(number, self.handle_exit) for number in signals}
        try:
            yield
        finally:
            for number, handler in before.items():
                if number != signal.SIGINT:
                    signal.signal(number, handler)

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:  # noqa: ARG002  (uvicorn's)
        """Shut down at the first signal; exit at once at a second Ctrl-C."""
        if self._signal is not None and sig == signal.SIGINT:
            os._exit(_INTERRUPTED)
        self._signal = self._signal or sig
        self.should_exit = True

    def finish_signal(self) -> None:
        """Do what the received signal does by default."""
        if self._signal == signal.SIGINT:
            # All is closed: another Ctrl-C would only change the exit status.
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            raise KeyboardInterrupt
        if self._signal is not None:
            signal.raise_signal(self._signal)

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start, and call `ready`."""
        await super().startup(sockets)
        if not self.should_exit:
            self._ready()
