"""The end of a program that an icon has started: it has no terminal for Ctrl-C.

The page's button ends it. It also ends by itself, ten minutes after its last page was closed, so
that nothing forgotten holds the adapter; not while it records or reads a dump.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.errors import Busy
from mikas.i18n import Text

AWAY: Final = 600.0
"""Seconds without a page. A page that the browser has only put to sleep keeps its connection."""

_TERMINAL: Final = Text(
    "the program was started in a terminal. End it there, with Ctrl-C",
    "программа запущена из терминала. Завершите её там клавишами Ctrl-C",
)


class Ending:
    """Ends `dashboard`'s program. All of it runs in the event loop."""

    def __init__(self, dashboard: Dashboard) -> None:
        self._dashboard = dashboard
        self._end: Callable[[], None] | None = None
        self._used = dashboard.clock()

    def attach(self, end: Callable[[], None]) -> None:
        """Set how the program ends; called by the server."""
        self._end = end
        self._used = self._dashboard.clock()

    def end_program(self) -> None:
        """End the program in good order: the recording and the port are closed. Raises `Busy`."""
        if not self._dashboard.settings.desktop or self._end is None:
            raise Busy(problem=_TERMINAL)
        self._end()

    def check(self) -> None:
        """End the program if it is not used any more; the server calls this once a second."""
        if not self._dashboard.settings.desktop:
            return
        now = self._dashboard.clock()
        if self._is_used():
            self._used = now
        elif now - self._used >= AWAY:
            self.end_program()

    def _is_used(self) -> bool:
        dashboard = self._dashboard
        return bool(
            dashboard.control.viewers
            or dashboard.recorder.file_name
            or any(job.phase == "running" for job in dashboard.dump_jobs.jobs.values())
        )
