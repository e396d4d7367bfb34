"""One examination of a connection: the doctor's steps in a thread of its own, until `end`.

Ending is closing the link under the doctor, as a session is ended: whatever it waits for ends at
once, and what it would say of a link that we closed ourselves is not told.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

from mikas.client.doctor import Step, examine
from mikas.link import Link

if TYPE_CHECKING:
    from mikas.dashboard.settings import Settings


class _NotWanted(Exception):
    """Nobody wants this examination any more."""


class Examination:
    """Of what is behind `url`; run once. `task` is set by whoever runs it."""

    def __init__(self, url: str, settings: Settings) -> None:
        self._url, self._settings = url, settings
        self._stopping = threading.Event()
        self._lock = threading.Lock()
        self._link: Link | None = None
        self.task: asyncio.Task[None] | None = None
        """Runs it, and gives the port back afterwards."""

    def run(self, tell: Callable[[Step], None]) -> None:
        """The steps, each told as it ends. The port is free when this returns."""
        options = self._settings.connection
        try:
            for step in examine(self._open, options.create_tester, options.catalog):
                if not self._stopping.is_set():  # else it ends by itself: its link is closed
                    tell(step)
        except _NotWanted:
            return

    def stop(self) -> None:
        """Ends it, from any thread; before it has begun as well."""
        self._stopping.set()
        with self._lock:
            link = self._link
        if link is not None:
            link.close()

    async def end(self) -> None:
        """Ends it, and waits until the port was given back."""
        await asyncio.to_thread(self.stop)
        if self.task is not None:
            await asyncio.wait({self.task})

    def _open(self) -> Link:
        if self._stopping.is_set():
            raise _NotWanted
        link = self._settings.open_port(self._url)
        with self._lock:
            self._link = link
        if self._stopping.is_set():
            link.close()
        return link
