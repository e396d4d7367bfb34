"""A port that is opened before the program is loaded: it listens to the line meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Self

from mikas.errors import NoConnection
from mikas.link.base import Link
from mikas.link.urls import open_link


class PortAhead:
    """The port `url`, opened at once. `open` hands over its link, and opens all further ones.

    The system collects what arrives until then, so the handshake counts this time as listened to
    (D13). A port that fails to open is tried again by `open`, which then raises the error. Raises
    as `open_link`, but no `NoConnection`. As a context manager, it closes a link that was not
    handed over.
    """

    def __init__(self, url: str, open_port: Callable[[str], Link] = open_link) -> None:
        self.url = url
        self._open_port = open_port
        self._links: list[Link] = []
        with suppress(NoConnection):
            link = open_port(url)
            link.opened = link.now()
            self._links.append(link)

    def open(self, url: str) -> Link:
        """Return an open link of `url`. Raises as `open_link`. Any thread may call this."""
        if url == self.url and self._links:
            return self._links.pop()
        return self._open_port(url)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for link in self._links:
            link.close()
