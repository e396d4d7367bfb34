"""The door of the application: every request passes here first, and every answer last.

In: judged by `Access` (its rights go along in the scope), its body bounded. Out: the headers that
keep a browser from doing more with our pages than we mean. Plain ASGI, so that WebSockets and
streams pass untouched.
"""

from __future__ import annotations

from collections.abc import Mapping

from starlette.datastructures import MutableHeaders
from starlette.responses import RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from mikas.dashboard.api.errors import answer_to
from mikas.dashboard.error_responses import refusal
from mikas.dashboard.errors import ApiRefusal, TokenRequired, TooLarge
from mikas.dashboard.security.access import Access
from mikas.i18n import Text

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
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
_HERE = {"Cross-Origin-Opener-Policy": "same-origin"}
"""Over plain HTTP a browser heeds this one on its own computer only, and complains elsewhere."""
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
        dressed = _dressed(send, _HEADERS | (_HERE if self.access.is_here(scope) else {}))
        try:
            judged = {"rights": self.access.judge(scope), "here": self.access.is_here(scope)}
            scope.setdefault("state", {}).update(judged)
        except ApiRefusal as error:
            await self._turn_away(error, scope, receive, dressed)
            return
        if scope["type"] == "websocket":
            await self.app(scope, receive, send)
        elif self.access.offers_token(scope):
            await self._welcome()(scope, receive, dressed)
        else:
            await self._bounded(scope, receive, dressed)

    async def _turn_away(
        self, error: ApiRefusal, scope: Scope, receive: Receive, send: Send
    ) -> None:
        if scope["type"] == "http":
            if isinstance(error, TokenRequired) and self.access.offers_token(scope):
                await self._welcome()(scope, receive, send)
                return
            await refusal(error, scope)(scope, receive, send)
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
        """The token becomes a cookie, and leaves the address bar.

        Lax, since a strict one does not go along with a link that was pressed in a messenger's
        page; what other pages may do is decided by `Access`, cookie or not.
        """
        answer = RedirectResponse("/", 303)
        answer.set_cookie(
            self.access.cookie,
            self.access.token,
            max_age=_YEAR,
            httponly=True,
            samesite="lax",
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


def _dressed(send: Send, headers: Mapping[str, str]) -> Send:
    """Adds `headers` to the answer, unless it brings its own."""

    async def dress(message: Message) -> None:
        if message["type"] == "http.response.start":
            own = MutableHeaders(scope=message)
            for name, value in headers.items():
                own.setdefault(name, value)
        await send(message)

    return dress
