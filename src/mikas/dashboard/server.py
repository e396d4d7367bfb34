"""The HTTP server: uvicorn with the application's settings, and a clean shutdown.

One worker, no access log; WebSockets are pinged to detect a computer that sleeps. `connections`
bounds the connections and their times. The first Ctrl-C closes recordings and the port, the second
ends the process at once.

What each TCP connection waits for is seen from the application, by ASGI alone (`PhaseReports`). A
request finds its connection by its two ends, which ASGI names. The connection enters

    NOTHING    with a request, or a WebSocket, and again when the request's body is whole
    BODY       while the application waits for the rest of the body
    REQUEST    with the end of the response

A connection whose request has not come to the application is left as it was accepted: in REQUEST.
"""

from __future__ import annotations

import asyncio
import logging
import os
import signal
import socket
import ssl
import sys
import threading
import time
from collections.abc import Awaitable, Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Any

import uvicorn
from fastapi import FastAPI
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from mikas.dashboard.connections import (
    TcpConnection,
    TcpConnections,
    TcpLimits,
    TcpPhase,
    TurnClock,
)
from mikas.dashboard.entrance import Entrance
from mikas.dashboard.memory import use_one_arena

_PING = 20.0
_GRACE = 3
_IDLE = 8  # seconds; httpx sends a request on a connection that was idle for up to 5
_TICKS = 10  # of uvicorn's clock, a second
_TURNS = 10  # of the event loop, in which a connection that was dropped has gone
_INTERRUPTED = 130  # as docs/reference/cli.md has it
_EXPECTED = (  # messages of uvicorn that report no error
    "ASGI callable returned without completing handshake.",  # a refused WebSocket
    "Cancel %s running task(s), timeout graceful shutdown exceeded",
    "Invalid UTF-8 sequence received from client.",
)
_TOO_LATE = "can't handle event type"
"""As h11 begins, where a client sent nonsense behind a request that was not answered yet."""

_log = logging.getLogger("mikas.dashboard")


def serve(
    app: FastAPI,
    own: Sequence[socket.socket],
    *,
    ready: Callable[[], None],
    tls: ssl.SSLContext | None = None,
) -> None:
    """Serve `app` on the sockets `own` until Ctrl-C; `ready` is called once the server responds.

    `tls`: what the network gets, while this computer gets plain HTTP; None: both plain HTTP.
    Raises `KeyboardInterrupt` after a clean shutdown; a second Ctrl-C ends the process at once.
    """
    server = Server(app, ready=ready, tls=tls)
    server.run(sockets=list(own))
    server.finish_signal()


def _is_error(record: logging.LogRecord) -> bool:
    """Whether the record is an error that a person at the terminal can act on."""
    error = record.exc_info[1] if record.exc_info else None
    return record.msg not in _EXPECTED and not isinstance(error, asyncio.CancelledError)


def _report(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """Report an error of a callback, unless clients cause it at will."""
    if not _is_too_late(context.get("exception")):
        loop.default_exception_handler(context)


def _is_too_late(error: object) -> bool:
    return str(error).startswith(_TOO_LATE)


class Server(uvicorn.Server):
    """uvicorn with the application's settings. `clock`: seconds, for the times of connections."""

    def __init__(
        self,
        app: FastAPI,
        *,
        ready: Callable[[], None] = lambda: None,
        tls: ssl.SSLContext | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        use_one_arena()
        log = logging.getLogger("uvicorn.error")
        log.setLevel(logging.ERROR)
        log.addFilter(_is_error)
        logging.getLogger("asyncio").setLevel(logging.ERROR)  # of clients that have gone
        self.guard: TcpConnections = TcpConnections(TcpLimits.of_this_process(), TurnClock(clock))
        super().__init__(
            uvicorn.Config(
                PhaseReports(app, self.guard),
                log_config=None,
                access_log=False,
                lifespan="on",
                loop="asyncio:SelectorEventLoop",  # `Entrance` waits for its socket by itself
                http="h11",
                ws="websockets-sansio",
                ws_max_size=1 << 16,
                ws_ping_interval=_PING,
                ws_ping_timeout=_PING,
                ws_per_message_deflate=False,  # on a loopback, bandwidth costs less than CPU time
                server_header=False,
                workers=1,
                proxy_headers=False,  # else FORWARDED_ALLOW_IPS lets a header name the sender
                timeout_keep_alive=_IDLE,
                timeout_graceful_shutdown=_GRACE,
            )
        )
        self._app, self._ready, self._tls = app, ready, tls
        self._entrances: list[Entrance] = []
        self._signal: int | None = None  # the first one received
        self._failing: set[Callable[[], object]] = set()  # parts of a tick

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

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Cancel reports and exports at once, then shut down, whatever the clients do meanwhile."""
        state = self._app.state
        closings = (*(entrance.close for entrance in self._entrances),
                    state.sharing.close_for_good, state.dashboard.library.close,
                    self._drop_closing)  # fmt: skip
        for close in closings:
            await _finished(close)
        if not await _finished(lambda: super(Server, self).shutdown(sockets)):
            await self.lifespan.shutdown()  # the recording and the port are closed all the same

    async def _drop_closing(self) -> None:
        """Drop the connections that are being closed: uvicorn can't shut down such a WebSocket."""
        for _ in range(_TURNS):
            self.guard.drop_closing()
            if not any(it.transport.is_closing() for it in self.server_state.connections):
                return
            await asyncio.sleep(0)

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start, open the entrances, and call `ready`."""
        asyncio.get_running_loop().set_exception_handler(_report)
        await super().startup([])
        plain = self._tls is None
        self._entrances = [self._entrance(it, self._tls, plain=plain) for it in sockets or ()]
        first = () if plain else self._entrances
        self._app.state.sharing.attach(self._entrance, first)
        self._app.state.ending.attach(self._end)
        if not self.should_exit:
            self._ready()

    def _end(self) -> None:
        """Shut down without a signal."""
        self.should_exit = True

    def _entrance(
        self, own: socket.socket, context: ssl.SSLContext | None, *, plain: bool = False
    ) -> Entrance:
        """Return an open entrance, whose connections are counted with those of the others."""
        entrance = Entrance(own, self._protocol, self.guard, context, plain=plain)
        entrance.open()
        return entrance

    def _protocol(self) -> asyncio.Protocol:
        """Return the protocol of a new connection, as `uvicorn.Server.startup` makes it."""
        create: Callable[..., asyncio.Protocol] = self.config.http_protocol_class
        return create(
            config=self.config, server_state=self.server_state, app_state=self.lifespan.state
        )

    async def on_tick(self, counter: int) -> bool:
        """End the connections that have waited for too long, once a second; and unused programs.

        This computer's addresses in the network are looked at as often.

        Nothing that fails here ends the loop: it is reported once while it repeats.
        """
        self.guard.clock()
        if counter % _TICKS == 0:
            state = self._app.state
            for part in (self.guard.sweep, state.ending.check, state.sharing.check):
                self._perform(part)
        return await super().on_tick(counter)

    def _perform(self, part: Callable[[], object]) -> None:
        try:
            part()
            self._failing.discard(part)
        except Exception:  # any: the other parts, and the next turn, follow
            if part not in self._failing:
                _log.exception("a bug in the server's clock")
            self._failing.add(part)


async def _finished(close: Callable[[], Awaitable[object]]) -> bool:
    """Await one step of the end; return whether it was done. A bug in it is reported."""
    try:
        await close()
    except Exception:  # any: the other steps follow
        _log.exception("a bug at the end of the program")
        return False
    return True


class PhaseReports:
    """`app`, whose requests report to `guard`."""

    def __init__(self, app: ASGIApp, guard: TcpConnections) -> None:
        self._app, self._guard = app, guard

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Respond as `app` does."""
        kind = scope["type"]
        connection = None
        if kind != "lifespan" and scope["client"] and scope["server"]:
            connection = self._guard.between(scope["client"], scope["server"])
        if connection is None:
            await self._app(scope, receive, send)
            return
        connection.enter(TcpPhase.NOTHING, self._guard.clock())
        if kind == "websocket":
            await self._app(scope, receive, send)
            return
        request = _Request(connection, self._guard.clock, receive, send)
        try:
            await self._app(scope, request.receive, request.send)
        finally:
            request.end()


@dataclass
class _Request:
    """A request whose phases `connection` enters."""

    _connection: TcpConnection
    _clock: Callable[[], float]
    _receive: Receive
    _send: Send
    _is_whole: bool = False
    _is_over: bool = False

    async def receive(self) -> Message:
        """Wait for the body, or for the end of the connection."""
        self._enter(TcpPhase.BODY)
        message = await self._receive()
        if not message.get("more_body"):
            self._enter(TcpPhase.NOTHING)
            self._is_whole = True
        return message

    async def send(self, message: Message) -> None:
        """Send a part of the response."""
        try:
            await self._send(message)
        except Exception as error:  # any: what it is decides
            if _is_too_late(error):  # as if the client had left
                raise asyncio.CancelledError from error
            raise
        if message["type"] == "http.response.body" and not message.get("more_body"):
            self.end()

    def end(self) -> None:
        """Wait for the next request; once: by then the next one may be in progress."""
        if not self._is_over:
            self._is_over = True
            self._connection.enter(TcpPhase.REQUEST, self._clock())

    def _enter(self, phase: TcpPhase) -> None:
        if not (self._is_whole or self._is_over):
            self._connection.enter(phase, self._clock())
