"""The door of the application: every request passes here first, and every answer last.

In: judged by `Access` (its rights go along in the scope), its body bounded. Out: the headers that
keep a browser from doing more with our pages than we mean. Plain ASGI, so that WebSockets and
streams pass untouched.
"""

from __future__ import annotations

from html import escape
from typing import Any

from starlette.datastructures import MutableHeaders
from starlette.responses import HTMLResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from mikas.dashboard.access import Access
from mikas.dashboard.answers import answer_to
from mikas.dashboard.refusals import ApiRefusal, TokenWanted, TooLarge
from mikas.language import Text

LARGEST_BODY = 1 << 20
POLICY = (
    "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; base-uri 'none'; "
    "form-action 'self'; frame-ancestors 'none'"
)
_HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
_YEAR = 365 * 24 * 3600
_POLICY_VIOLATION = 1008
_TOO_LARGE = Text(f"more than {LARGEST_BODY >> 20} MiB", f"больше {LARGEST_BODY >> 20} МиБ")


class Doorkeeper:
    """Lets in what `access` lets in."""

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self.app = app
        self.access = access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """One connection."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        try:
            judged = {"rights": self.access.judge(scope), "here": self.access.is_here(scope)}
            scope.setdefault("state", {}).update(judged)
        except ApiRefusal as error:
            await self._turn_away(error, scope, receive, send)
            return
        if scope["type"] == "websocket":
            await self.app(scope, receive, send)
        elif self.access.offers_token(scope):
            await self._welcome()(scope, receive, _dressed(send))
        else:
            await self._bounded(scope, receive, _dressed(send))

    async def _turn_away(
        self, error: ApiRefusal, scope: Scope, receive: Receive, send: Send
    ) -> None:
        if scope["type"] == "http":
            if isinstance(error, TokenWanted) and self.access.offers_token(scope):
                await self._welcome()(scope, receive, _dressed(send))
                return
            await _refusal(error, scope)(scope, receive, _dressed(send))
            return
        await receive()  # the handshake
        if "websocket.http.response" in scope.get("extensions", {}):
            answer = answer_to(error)
            await send(
                {
                    "type": "websocket.http.response.start",
                    "status": answer.status_code,
                    "headers": answer.raw_headers,
                }
            )
            await send({"type": "websocket.http.response.body", "body": answer.body})
            return
        await send({"type": "websocket.close", "code": _POLICY_VIOLATION})

    def _welcome(self) -> Response:
        """The token becomes a cookie, and leaves the address bar."""
        answer = RedirectResponse("/", 303)
        answer.set_cookie(
            self.access.cookie,
            self.access.token,
            max_age=_YEAR,
            httponly=True,
            samesite="strict",
        )
        return answer

    async def _bounded(self, scope: Scope, receive: Receive, send: Send) -> None:
        length = dict(scope["headers"]).get(b"content-length", b"0")
        if not length.isdigit() or int(length) > LARGEST_BODY:
            await answer_to(TooLarge(problem=_TOO_LARGE))(scope, receive, send)
            return
        taken = 0
        begun = False

        async def counted() -> Message:
            nonlocal taken
            message = await receive()
            taken += len(message.get("body", b""))
            if taken > LARGEST_BODY:
                raise TooLarge(problem=_TOO_LARGE)
            return message

        async def noted(message: Message) -> None:
            nonlocal begun
            begun = True
            await send(message)

        try:
            await self.app(scope, counted, noted)
        except TooLarge as error:
            if begun:
                raise
            await answer_to(error)(scope, receive, send)


def _refusal(error: ApiRefusal, scope: Scope) -> Response:
    """JSON for the API; a page in plain words for a person who opened an address."""
    wanted = dict(scope["headers"]).get(b"accept", b"").decode("latin-1")
    if scope["path"].startswith("/api") or "text/html" not in wanted:
        return answer_to(error)
    said = "".join(
        f'<p lang="{language}">{escape(text)}</p>'
        for language, text in zip(("en", "ru"), error.text, strict=True)
    )
    return HTMLResponse(
        f'<!doctype html><meta charset="utf-8"><title>mikas</title><h1>mikas</h1>{said}',
        error.status,
    )


def _dressed(send: Send) -> Send:
    """Adds our headers to the answer, unless it brings its own."""

    async def dress(message: Any) -> None:  # noqa: ANN401  (as ASGI has it)
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in _HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return dress
