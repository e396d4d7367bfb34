"""One-off requests (faults, memory, a write) that other threads want done between two cycles.

None of them waits for what may never come: while nobody answers, each fails with the error that
says why, after one more look at the line; when sampling has ended, so do they. And none starves the
others: those that were waiting are all done, then there is a cycle, however many come meanwhile.
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
_BEGIN_AGAIN = Text("Begin sampling again, then ask.", "Начните опрос снова, затем спросите.")
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
        """`job` waits for its turn, which the future tells the end of. Cancelling it is safe."""
        future: Future[T] = Future()
        with self._lock:
            if self._over is None:
                self._waiting.append((future, job))
                return future
        future.set_exception(self._over)
        return future

    def open(self) -> None:
        """From here on jobs are looked after."""
        with self._lock:
            self._over = None

    def close(self, error: BaseException | None = None) -> None:
        """Nobody looks after jobs any more: those that wait fail, and all later ones."""
        with self._lock:
            self._over = error or LinkLost(url=self._url, problem=_ENDED, advice=_BEGIN_AGAIN)
        self.fail(self._over)

    def fail(self, error: BaseException) -> None:
        """What waits now fails with `error`."""
        for future, _ in self._take_all():
            if future.set_running_or_notify_cancel():
                future.set_exception(error)

    def run(self, ecu: Ecu) -> None:
        """Does what waits now. Raises the `NoConnection` that one of them met."""
        taken = self._take_all()
        while taken:
            future, job = taken.popleft()
            if not future.set_running_or_notify_cancel():
                continue
            try:
                future.set_result(job(ecu))
            except Exception as error:  # it is the caller's, whatever it is
                future.set_exception(error)
                if isinstance(error, NoConnection):
                    self._put_back(taken)
                    raise
            except BaseException as error:  # Ctrl-C: nobody may wait for this one for ever
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
