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
from mikas.errors import LinkLost, NoConnection
from mikas.i18n import Text

T = TypeVar("T")
_ENDED = Text("sampling has ended", "опрос закончен")
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
        """Fail the waiting jobs and all later ones, with `error` or `LinkLost`."""
        with self._lock:
            self._over = error or LinkLost(url=self._url, problem=_ENDED, advice=_BEGIN_AGAIN)
        self.fail(self._over)

    def fail(self, error: BaseException) -> None:
        """Fail the jobs that wait now with `error`."""
        for future, _ in self._take_all():
            if future.set_running_or_notify_cancel():
                future.set_exception(error)

    def run(self, ecu: Ecu) -> None:
        """Run the jobs that wait now. Raises the `NoConnection` of one of them."""
        taken = self._take_all()
        while taken:
            future, job = taken.popleft()
            if not future.set_running_or_notify_cancel():
                continue
            try:
                future.set_result(job(ecu))
            except Exception as error:  # every error goes to the caller
                future.set_exception(error)
                if isinstance(error, NoConnection):
                    self._put_back(taken)
                    raise
            except BaseException as error:  # Ctrl-C: the caller must not wait
                future.set_exception(error)
                self._put_back(taken)
                raise

    def _take_all(self) -> deque[_Waiting]:
        with self._lock:
            taken, self._waiting = self._waiting, deque()
        return taken

    def _put_back(self, jobs: deque[_Waiting]) -> None:
        with self._lock:
            self._waiting.extendleft(reversed(jobs))
