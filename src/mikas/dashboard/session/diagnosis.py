"""One diagnosis of a connection: its steps run in a thread, until the last one or `end`.

Ending closes the link under the running step, as for the sampling thread: its wait ends at once,
and errors of a link that was closed here are not reported.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable

from mikas.client.doctor import Step, examine
from mikas.dashboard.settings import Settings
from mikas.link import Link


class _Stopped(Exception):
    """The diagnosis was stopped."""


class Diagnosis:
    """Examines the port `url` once."""

    def __init__(self, url: str, settings: Settings) -> None:
        self._url, self._settings = url, settings
        self._stopping = threading.Event()
        self._lock = threading.Lock()
        self._link: Link | None = None
        self.task: asyncio.Task[None] | None = None
        """The task that calls `run` and gives the port back; set by its creator."""

    def run(self, report: Callable[[Step], None]) -> None:
        """Run the steps, calling `report` as each ends. The port is free when this returns."""
        options = self._settings.connection
        try:
            for step in examine(self._open, options.create_tester, options.catalog):
                if not self._stopping.is_set():  # else its link was closed under it
                    report(step)
        except _Stopped:
            return

    def stop(self) -> None:
        """Stop the diagnosis, from any thread, also before it has started."""
        self._stopping.set()
        with self._lock:
            link = self._link
        if link is not None:
            link.close()

    async def end(self) -> None:
        """Stop the diagnosis, and wait until the port is given back."""
        await asyncio.to_thread(self.stop)
        if self.task is not None:
            await asyncio.wait({self.task})

    def _open(self) -> Link:
        if self._stopping.is_set():
            raise _Stopped
        link = self._settings.open_port(self._url)
        with self._lock:
            self._link = link
        if self._stopping.is_set():
            link.close()
        return link
