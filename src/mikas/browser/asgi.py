"""Requests and WebSockets of the page, answered by the application as it is: ASGI without a socket.

The page sends messages (`web/src/site/program/messages.ts`); `receive_message` is called for each,
outside of every thread of Python. The answers go out through `BrowserPage`. The application sees a
client on its own computer: the page of this very tab.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, MutableMapping, Sequence
from typing import Any, Final, Protocol, TypeAlias
from urllib.parse import unquote

ASGIApp: TypeAlias = Callable[..., Any]
Scope: TypeAlias = MutableMapping[str, Any]
PORT: Final = 80
"""The port of the application's own address; there is no such port."""
_HOST: Final = b"localhost"
_CLIENT: Final = ("127.0.0.1", 0)
_BUG: Final = 1011
_FORBIDDEN: Final = 1008


class BrowserPage(Protocol):
    """The page's end; each call is one message to it."""

    def head(self, id: int, status: int, headers: Sequence[tuple[str, str]], /) -> None: ...  # noqa: A002

    def body(self, id: int, data: bytes, /) -> None: ...  # noqa: A002

    def end(self, id: int, /) -> None: ...  # noqa: A002

    def failed(self, id: int, message: str, /) -> None: ...  # noqa: A002

    def opened(self, id: int, /) -> None: ...  # noqa: A002

    def message(self, id: int, data: str, /) -> None: ...  # noqa: A002

    def closed(self, id: int, code: int, reason: str, /) -> None: ...  # noqa: A002


class PageServer:
    """Answers the page of this tab by `app`; made in the event loop's thread."""

    def __init__(self, app: ASGIApp, page: BrowserPage) -> None:
        self._app, self._page = app, page
        self._loop = asyncio.get_running_loop()
        self._inboxes: dict[int, asyncio.Queue[dict[str, Any]]] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    def receive_message(self, message: Mapping[str, Any]) -> None:
        """Take a message of the page; called from JavaScript, which takes it back afterwards."""
        own = dict(message)
        if own.get("body") is not None:
            own["body"] = bytes(own["body"])
        self._loop.call_soon_threadsafe(self._dispatch, own)

    def _dispatch(self, message: Mapping[str, Any]) -> None:
        number = message["id"]
        match message["kind"]:
            case "request":
                inbox = self._begin(number, self._answer(number, message))
                body = message["body"] or b""
                inbox.put_nowait({"type": "http.request", "body": body, "more_body": False})
            case "open":
                self._begin(number, self._converse(number, message["path"])).put_nowait(
                    {"type": "websocket.connect"}
                )
            case "abort":
                self._put(number, {"type": "http.disconnect"})
            case "send":
                self._put(number, {"type": "websocket.receive", "text": message["data"]})
            case "close":
                self._put(number, {"type": "websocket.disconnect", "code": message["code"]})

    def _begin(self, number: int, work: Any) -> asyncio.Queue[dict[str, Any]]:  # noqa: ANN401  (a coroutine)
        inbox = self._inboxes[number] = asyncio.Queue()
        task = self._loop.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return inbox

    def _put(self, number: int, message: dict[str, Any]) -> None:
        if (inbox := self._inboxes.get(number)) is not None:
            inbox.put_nowait(message)

    async def _answer(self, number: int, message: Mapping[str, Any]) -> None:
        scope = _scope("http", message["path"])
        scope["method"] = message["method"]
        scope["headers"] += [
            (name.lower().encode("latin-1"), value.encode("latin-1"))
            for name, value in message["headers"]
        ]
        if message["body"]:
            scope["headers"].append((b"content-length", str(len(message["body"])).encode()))

        async def send(part: Mapping[str, Any]) -> None:
            if part["type"] == "http.response.start":
                headers = [(n.decode("latin-1"), v.decode("latin-1")) for n, v in part["headers"]]
                self._page.head(number, part["status"], headers)
            elif part["type"] == "http.response.body":
                if part.get("body"):
                    self._page.body(number, bytes(part["body"]))
                if not part.get("more_body"):
                    self._page.end(number)

        await self._run(number, scope, send, self._page.failed)

    async def _converse(self, number: int, path: str) -> None:
        async def send(part: Mapping[str, Any]) -> None:
            match part["type"]:
                case "websocket.accept":
                    self._page.opened(number)
                case "websocket.send":
                    text = part.get("text")
                    self._page.message(number, part["bytes"].decode() if text is None else text)
                case "websocket.close":
                    self._page.closed(number, part.get("code", 1000), part.get("reason") or "")
                case "websocket.http.response.start":
                    self._page.closed(number, _FORBIDDEN, "")

        def failed(id: int, message: str) -> None:  # noqa: A002
            self._page.closed(id, _BUG, message)

        await self._run(number, _scope("websocket", path), send, failed)

    async def _run(
        self, number: int, scope: Scope, send: ASGIApp, failed: Callable[[int, str], None]
    ) -> None:
        try:
            await self._app(scope, self._inboxes[number].get, send)
        except Exception as error:  # any: a bug, which the page reports
            failed(number, f"{type(error).__name__}: {error}")
        finally:
            del self._inboxes[number]


def _scope(kind: str, address: str) -> Scope:
    path, _, query = address.partition("?")
    return {
        "type": kind,
        # As uvicorn. With 2.4, Starlette would see by an error of `send` only that a request was
        # aborted, so an answer that waits for what it sends would never end.
        "asgi": {"version": "3.0", "spec_version": "2.3"},
        "http_version": "1.1",
        "scheme": "http" if kind == "http" else "ws",
        "path": unquote(path),
        "raw_path": path.encode(),
        "query_string": query.encode(),
        "root_path": "",
        "headers": [(b"host", _HOST)],
        "client": _CLIENT,
        "server": ("localhost", PORT),
        "subprotocols": [],
        "state": {},
        "extensions": {"websocket.http.response": {}} if kind == "websocket" else {},
    }
