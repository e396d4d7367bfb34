"""Jobs of other threads (read faults, read memory, write), run between two cycles.

While no ECU answers, a job fails with the error of the next attempt; after the end of sampling a
job fails at once. All waiting jobs are run, then a cycle follows, even if more jobs arrive.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, TypeVar

from mikas.client import Ecu
from mikas.errors import LinkClosed, NoConnection
from mikas.i18n import Text

T = TypeVar("T")
_BEGIN_AGAIN = Text("Start sampling again, then retry.", "Запустите опрос и повторите запрос.")
_Waiting = tuple[Future[Any], Callable[[Ecu], Any]]


class JobQueue:
    """A queue between threads. Before `open` jobs wait; after `close` they fail at once."""

    def __init__(self, url: str) -> None:
        self._url = url
        self._lock = threading.Lock()
        self._waiting: deque[_Waiting] = deque()
        self._over: BaseException | None = None

    def __bool__(self) -> bool:
        return bool(self._waiting)

    def submit(self, job: Callable[[Ecu], T]) -> Future[T]:
        """Queue `job`; the future gets its result and may be cancelled."""
        future: Future[T] = Future()
        with self._lock:
            if self._over is None:
                self._waiting.append((future, job))
                return future
        future.set_exception(self._over)
        return future

    def open(self) -> None:
        """Begin to accept jobs."""
        with self._lock:
            self._over = None

    def close(self, error: BaseException | None = None) -> None:
        """Fail the waiting jobs and all later ones, by `error`, that of before, or `LinkClosed`."""
        with self._lock:
            ended = self._over or LinkClosed(url=self._url, advice=_BEGIN_AGAIN)
            self._over = error or ended
        self.fail(self._over)

    def fail(self, error: BaseException) -> None:
        """Fail the jobs that wait now with `error`; in the sampling thread, as `run`."""
        for _ in range(len(self._waiting)):
            future, _ = self._waiting.popleft()
            if future.set_running_or_notify_cancel():
                future.set_exception(error)

    def run(self, ecu: Ecu) -> None:
        """Run the jobs that wait now. Raises the `NoConnection` of one of them; the rest waits."""
        for _ in range(len(self._waiting)):
            future, job = self._waiting.popleft()
            if not future.set_running_or_notify_cancel():
                continue
            try:
                future.set_result(job(ecu))
            except BaseException as error:  # every error goes to the caller, who waits
                future.set_exception(error)
                if isinstance(error, NoConnection) or not isinstance(error, Exception):  # Ctrl-C
                    raise
