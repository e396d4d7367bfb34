"""What each TCP connection waits for, seen from the application: ASGI alone, nothing of the server.

A request finds its connection by its two ends, which ASGI names. The connection enters

    NOTHING    with a request, or a WebSocket, and again when the request's body is whole
    BODY       while the application waits for the rest of the body
    REQUEST    with the end of the response

A connection whose request has not come to the application is left as it was accepted: in REQUEST.
"""

from __future__ import annotations

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from mikas.dashboard.connections import TcpConnection, TcpConnections, TcpPhase


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
        request = _Request(self._guard, connection, receive, send)
        try:
            await self._app(scope, request.receive, request.send)
        finally:
            request.end()


class _Request:
    """One request, of which both ways are followed."""

    def __init__(
        self, guard: TcpConnections, connection: TcpConnection, receive: Receive, send: Send
    ) -> None:
        self._guard, self._connection = guard, connection
        self._receive, self._send = receive, send
        self._is_whole = self._is_over = False

    async def receive(self) -> Message:
        """Receive, and report the wait for the body."""
        self._enter(TcpPhase.BODY)
        message = await self._receive()
        if not message.get("more_body"):
            self._enter(TcpPhase.NOTHING)
            self._is_whole = True
        return message

    async def send(self, message: Message) -> None:
        """Send, and report the end of the response."""
        await self._send(message)
        if message["type"] == "http.response.body" and not message.get("more_body"):
            self.end()

    def end(self) -> None:
        """Report the end, once: by then the next request may have begun."""
        if not self._is_over:
            self._is_over = True
            self._connection.enter(TcpPhase.REQUEST, self._guard.clock())

    def _enter(self, phase: TcpPhase) -> None:
        if not (self._is_whole or self._is_over):
            self._connection.enter(phase, self._guard.clock())
