"""Sends webhooks to this computer, in a thread of its own: sampling never waits for them.

A name is resolved once, before the first request. All its addresses must be loopback ones, and each
request connects to the first of these at which a program listens (localhost is ::1 and 127.0.0.1,
a program often at one of them): a name that changes later, a redirect and a proxy lead nowhere. At
most twenty requests wait; of an answer nothing is read but its status.
"""

from __future__ import annotations

import http.client
import queue
import socket
import threading
from collections.abc import Callable, Iterable
from contextlib import closing, suppress
from dataclasses import dataclass
from typing import Final

from mikas.conditions.addresses import check_webhook, is_loopback, not_here
from mikas.errors import reason_of, usage_error
from mikas.i18n import Text

WAITING: Final = 20
"""Requests that wait at most."""
PATIENCE: Final = 2.0
"""Seconds for a connection, and for an answer."""
_END: Final = 1.0  # s that the end waits for the requests before it
_HTTP: Final = 80

_FULL: Final = Text(
    "The webhook {url} is too slow: a request was left out.",
    "Вебхук {url} не успевает: один запрос пропущен.",
)
_REFUSED: Final = Text("The webhook {url} answered {status}.", "Вебхук {url} ответил {status}.")
_FAILED: Final = Text(
    "The webhook {url} can't be reached ({why}). Is the program that gets it running?",
    "Вебхук {url} недоступен ({why}). Запущена ли программа, которая его принимает?",
)
_NO_HTTP: Final = Text("no answer in HTTP", "ответ не по HTTP")


@dataclass(frozen=True, slots=True)
class LoopbackTarget:
    """An address on this computer, resolved."""

    url: str
    """As it was written."""
    addresses: tuple[str, ...]
    """To which it connects, the first that takes it."""
    port: int
    """Of the program there."""
    host: str
    """The header `Host`."""
    path: str
    """With the query."""


def resolved(
    url: str, addresses_of: Callable[[str, int], Iterable[str]] | None = None
) -> LoopbackTarget:
    """Resolve the host of `url`, once. Raises `UsageError` unless it is this computer alone."""
    parts = check_webhook(url)
    host, port = parts.hostname or "", parts.port or _HTTP
    try:
        found = list((addresses_of or _addresses)(host, port))
    except OSError as error:
        reason = reason_of(error)
        raise usage_error(
            f"The webhook {url}: {host} is not found ({reason.en})",
            f"Вебхук {url}: {host} не находится ({reason.ru})",
        ).caused_by(error) from error
    if not found or not all(map(is_loopback, found)):
        raise not_here(host)
    path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
    return LoopbackTarget(url, tuple(dict.fromkeys(found)), port, parts.netloc, path)


def _addresses(host: str, port: int) -> list[str]:
    found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    return [str(each[4][0]) for each in found]


class Webhooks:
    """Sends to `urls`, one after the other. `on_failure` is called once for a failure that lasts.

    Raises `UsageError` for an address that is not on this computer.
    """

    def __init__(self, urls: Iterable[str], on_failure: Callable[[Text], object]) -> None:
        self._targets = {url: resolved(url) for url in dict.fromkeys(urls)}
        self._on_failure = on_failure
        self._said: dict[str, set[Text]] = {}  # by address, until nothing waits and one succeeds
        self._queue: queue.Queue[tuple[LoopbackTarget, bytes] | None] = queue.Queue(WAITING)
        self._thread = threading.Thread(target=self._run, name="webhooks", daemon=True)
        if self._targets:
            self._thread.start()

    def send(self, url: str, body: bytes) -> None:
        """Send `body` as JSON as soon as possible; never waits."""
        try:
            self._queue.put_nowait((self._targets[url], body))
        except queue.Full:
            self._say(url, _FULL.filled(url=url))

    def close(self) -> None:
        """End, after the requests that wait, within a second."""
        if self._thread.ident is None:
            return
        try:
            self._queue.put(None, timeout=_END)
        except queue.Full:
            return  # a daemon: it ends with the program
        self._thread.join(_END)

    def _run(self) -> None:
        while (waiting := self._queue.get()) is not None:
            target, body = waiting
            failure = post(target, body)
            if failure is None:
                if self._queue.empty():
                    self._said.pop(target.url, None)
            else:
                self._say(target.url, failure)

    def _say(self, url: str, failure: Text) -> None:
        said = self._said.setdefault(url, set())
        if failure not in said:
            said.add(failure)
            self._on_failure(failure)


def post(target: LoopbackTarget, body: bytes) -> Text | None:
    """Send one request; return why it failed, None: it did not."""
    headers = {
        "Host": target.host, "Content-Type": "application/json", "Connection": "close",
    }  # fmt: skip
    try:
        with closing(_connected(target)) as connection:
            connection.request("POST", target.path, body, headers)
            status = connection.getresponse().status
    except http.client.HTTPException:
        return _FAILED.filled(url=target.url, why=_NO_HTTP)
    except OSError as error:
        return _FAILED.filled(url=target.url, why=reason_of(error))
    return None if status < 300 else _REFUSED.filled(url=target.url, status=status)


def _connected(target: LoopbackTarget) -> http.client.HTTPConnection:
    """Return a connection to the first address that takes it. Raises `OSError` of the last one."""
    *others, last = target.addresses
    for address in others:
        connection = http.client.HTTPConnection(address, target.port, timeout=PATIENCE)
        with suppress(OSError):
            connection.connect()
            return connection
    connection = http.client.HTTPConnection(last, target.port, timeout=PATIENCE)
    connection.connect()
    return connection
