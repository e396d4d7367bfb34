"""The outermost middleware: checks every request, and adds security headers to every response.

A request gets its rights from `Access` (they go along in the scope) and a limit for its body. The
headers keep a browser from doing more with the pages than intended. Plain ASGI, so that WebSockets
and streams pass unchanged.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from starlette.datastructures import MutableHeaders
from starlette.responses import RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from mikas.dashboard.error_responses import json_response, refusal_response
from mikas.dashboard.errors import ApiRefusal, TokenRequired, TooLarge
from mikas.dashboard.security.access import Access, is_encrypted
from mikas.foreign_logs import MOST_BYTES
from mikas.i18n import Text

MAX_BODY = 1 << 16
MAX_LONG_BODY = 1 << 20
MAX_RECORDING = 1 << 28
_LONG = re.compile(r"/api/(presets|dumps/[^/]+/compare)")
_FOREIGN = re.compile(r"/api/foreign-logs/(preview|values)")
POLICY = (
    "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; base-uri 'none'; "
    "form-action 'self'; frame-ancestors 'none'"
)
_HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
_TRUSTED = {"Cross-Origin-Opener-Policy": "same-origin"}
"""Browsers accept this header over TLS, and from their own computer."""
_YEAR = 365 * 24 * 3600


class AccessMiddleware:
    """Passes the requests that `access` allows."""

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self.app = app
        self.access = access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle one connection."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        is_trusted = is_encrypted(scope) or self.access.is_local(scope)
        sending = _with_headers(send, _HEADERS | (_TRUSTED if is_trusted else {}))
        try:
            rights = {"rights": self.access.judge(scope), "local": self.access.is_local(scope)}
            scope.setdefault("state", {}).update(rights)
        except ApiRefusal as error:
            answer = refusal_response(error, scope)
            if isinstance(error, TokenRequired) and self.access.offers_token(scope):
                answer = self._set_cookie(scope)
            await answer(scope, receive, sending)
            return
        if scope["type"] == "websocket":
            await self.app(scope, receive, send)
        elif self.access.offers_token(scope):
            await self._set_cookie(scope)(scope, receive, sending)
        else:
            await self._limited(scope, receive, sending)

    def _set_cookie(self, scope: Scope) -> Response:
        """Set the token as a cookie, and remove it from the address bar.

        Lax: browsers do not send a strict cookie with a link that was opened from a messenger's
        page. `Access` refuses other sites' pages with or without the cookie.
        """
        response = RedirectResponse("/", 303)
        response.set_cookie(
            self.access.cookie,
            self.access.token,
            max_age=_YEAR,
            httponly=True,
            samesite="lax",
            secure=is_encrypted(scope),
        )
        return response

    def _most(self, scope: Scope) -> int:
        """Return how long the body may be; only this computer sends files."""
        if scope["path"] == "/api/recordings" and self.access.is_local(scope):
            return MAX_RECORDING
        if _FOREIGN.fullmatch(scope["path"]) and self.access.is_local(scope):
            return MOST_BYTES + 1  # the reader says that such a file is too large
        return MAX_LONG_BODY if _LONG.fullmatch(scope["path"]) else MAX_BODY

    async def _limited(self, scope: Scope, receive: Receive, send: Send) -> None:
        most = self._most(scope)
        too_large = TooLarge(
            problem=Text(f"more than {most >> 10} KiB", f"больше {most >> 10} КиБ")
        )
        length = dict(scope["headers"]).get(b"content-length", b"0")
        if not length.isdigit() or int(length) > most:
            await json_response(too_large)(scope, receive, send)
            return
        taken = 0

        async def counted() -> Message:
            nonlocal taken
            message = await receive()
            taken += len(message.get("body", b""))
            if taken > most:
                raise too_large  # the application answers with it
            return message

        await self.app(scope, counted, send)


def _with_headers(send: Send, headers: Mapping[str, str]) -> Send:
    """Add `headers` to the response, unless it has its own."""

    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            own = MutableHeaders(scope=message)
            for name, value in headers.items():
                own.setdefault(name, value)
        await send(message)

    return send_with_headers
