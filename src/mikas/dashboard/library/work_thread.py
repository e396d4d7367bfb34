"""The thread of one piece of work, which ends it even in a loop without `check_cancelled`."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Final

from mikas.cancellation import Cancellation, Cancelled

_STEPS: Final = 10


class WorkThread(threading.Thread):
    """Runs `work`, then calls `ended` with its result or its exception; both in the thread.

    A daemon: it can't hold up the end of the program.
    """

    def __init__(
        self,
        name: str,
        work: Callable[[], object],
        ended: Callable[[object, BaseException | None], None],
    ) -> None:
        super().__init__(name=name, daemon=True)
        self.cancellation = Cancellation()
        self._work, self._ended = work, ended
        self._gate = threading.Lock()
        self._may_interrupt = False

    def interrupt(self) -> None:
        """Raise `Cancelled` in the work at its next step in Python; once, and only in the work.

        For work that has not ended by its cancellation. A step in C (a large compression) ends by
        itself first.
        """
        import ctypes  # seldom needed

        with self._gate:
            if not self._may_interrupt or self.ident is None:
                return
            self._may_interrupt = False
            ctypes.pythonapi.PyThreadState_SetAsyncExc(
                ctypes.c_ulong(self.ident), ctypes.py_object(Cancelled)
            )

    def run(self) -> None:
        """Run the work; in the thread."""
        result, failure = None, None
        try:
            try:
                with self._gate:
                    self._may_interrupt = True
                result = self.cancellation.run(self._work)
            finally:
                self._close_gate()
        except BaseException as error:  # any: it is raised where the work is awaited
            failure = error
        self._ended(result, failure)

    def _close_gate(self) -> None:
        """Let no exception come from outside after this."""
        try:
            with self._gate:
                self._may_interrupt = False
            for _ in range(_STEPS):  # one that was sent before arrives here at the latest
                pass
        except Cancelled:
            return  # too late; no second one is sent
