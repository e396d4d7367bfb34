"""The application as the site answers its page (`mikas.browser.asgi`): by messages, on the site's
threads and event loop. What tests reach it with is the page's end: `httpx`, and a WebSocket.
"""

from __future__ import annotations

import asyncio
import itertools
import threading
from contextlib import contextmanager
from queue import Empty, SimpleQueue

import httpx
from websockets.exceptions import ConnectionClosed
from websockets.frames import Close

from mikas.browser.asgi import PORT, PageServer
from mikas.browser.event_loop import EventLoop
from mikas.dashboard.app import create_app
from mikas.dashboard.security.access import Access

# What a browser adds by itself, and the page's messages do not have.
NOT_SENT = frozenset(
    ("host", "accept-encoding", "connection", "content-length", "user-agent", "transfer-encoding")
)


class PageEnd:
    """Sorts the answers by the numbers of what was asked."""

    def __init__(self):
        self.numbers = itertools.count(1)
        self.answers = {}

    def begin(self):
        number = next(self.numbers)
        self.answers[number] = SimpleQueue()
        return number, self.answers[number]

    def __getattr__(self, kind):
        """What `mikas.browser.asgi.Page` has."""

        def tell(number, *parts):
            self.answers[number].put((kind, *parts))

        return tell


class Transport(httpx.BaseTransport):
    """Requests of `httpx` as messages of the page."""

    def __init__(self, server, end):
        self._server, self._end = server, end

    def handle_request(self, request):
        body = request.read()
        number, answers = self._end.begin()
        self._server.receive_message(
            {
                "kind": "request",
                "id": number,
                "method": request.method,
                "path": request.url.raw_path.decode(),
                "headers": [
                    (name, value)
                    for name, value in request.headers.multi_items()
                    if name.lower() not in NOT_SENT
                ],
                "body": body or None,
            }
        )
        stream = Body(self._server, number, answers, request.extensions["timeout"]["read"])
        kind, *head = stream.next()
        assert kind == "head", kind
        headers = [(name, value.encode("latin-1")) for name, value in head[1]]
        return httpx.Response(head[0], headers=headers, stream=stream)


class Body(httpx.SyncByteStream):
    """The body of an answer, as it comes."""

    def __init__(self, server, number, answers, timeout):
        self._server, self._number, self._answers = server, number, answers
        self._timeout = timeout
        self._over = False

    def next(self):
        try:
            answer = self._answers.get(timeout=self._timeout)
        except Empty:
            raise httpx.ReadTimeout("no answer") from None
        self._over = answer[0] in ("end", "failed")
        if answer[0] == "failed":
            raise httpx.RemoteProtocolError(answer[1])
        return answer

    def __iter__(self):
        while (answer := self.next())[0] == "body":
            yield answer[1]

    def close(self):
        if not self._over:
            self._over = True
            self._server.receive_message({"kind": "abort", "id": self._number})


class Socket:
    """A WebSocket as the page has it, with the methods of `websockets`."""

    def __init__(self, server, end, address):
        self._server = server
        self._number, self._answers = end.begin()
        self._server.receive_message({"kind": "open", "id": self._number, "path": address})
        self._closed = None
        self._next(60, "opened")

    def _next(self, timeout, wanted):
        if self._closed is None:
            try:
                kind, *parts = self._answers.get(timeout=timeout)
            except Empty:
                raise TimeoutError from None
            if kind == wanted:
                return parts
            assert kind == "closed", kind
            self._closed = Close(*parts)
        raise ConnectionClosed(self._closed, None)

    def recv(self, timeout=None):
        return self._next(timeout, "message")[0]

    def send(self, data):
        if self._closed is not None:
            raise ConnectionClosed(self._closed, None)
        text = data.decode() if isinstance(data, bytes) else data
        self._server.receive_message({"kind": "send", "id": self._number, "data": text})

    def close(self, code=1000):
        if self._closed is None:
            self._closed = Close(code, "")
            self._server.receive_message({"kind": "close", "id": self._number, "code": code})

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class Reached:
    """How the application is reached."""

    def __init__(self, access, server, end, client):
        self.access, self.server, self.client = access, server, client
        self._end = end

    def open(self, address, headers):
        """A WebSocket; a browser sends no headers with it."""
        assert headers is None
        return Socket(self.server, self._end, address)


@contextmanager
def running(app, end):
    """An event loop on a thread of its own, with a `PageServer` for `app`."""
    ready, began, at_work = threading.Event(), [], set()

    async def counted(*call):
        task = asyncio.current_task()
        at_work.add(task)
        task.add_done_callback(at_work.discard)
        await app(*call)

    async def run():
        async with app.router.lifespan_context(app):
            stop, loop = asyncio.Event(), asyncio.get_running_loop()
            began.append((PageServer(counted, end), lambda: loop.call_soon_threadsafe(stop.set)))
            ready.set()
            await stop.wait()
            # As a server does: an answer that has come whole may have its file open still.
            if at_work:
                await asyncio.wait(at_work, timeout=60)

    def work():
        try:
            asyncio.run(run(), loop_factory=EventLoop)
        finally:
            ready.set()

    thread = threading.Thread(target=work)
    thread.start()
    ready.wait()
    server, stop = began[0]
    try:
        yield server
    finally:
        stop()
        thread.join()


@contextmanager
def served(dashboard, page, tls, access):
    """`page`: the folder of the built page; `access`: settings of `Access`."""
    assert tls is None
    rules = Access(PORT, **access)
    end = PageEnd()
    with running(create_app(dashboard, rules, folder=page), end) as server:
        url, transport = "http://localhost", Transport(server, end)
        with httpx.Client(base_url=url, timeout=60, transport=transport) as client:
            yield Reached(rules, server, end, client)
