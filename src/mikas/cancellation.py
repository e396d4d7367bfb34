"""Cancellation of long work: loops over a file's contents call `check_cancelled`.

    cancellation = Cancellation()
    cancellation.run(work)      # in one thread
    cancellation.request()      # in another: the work raises `Cancelled` at its next check

A check costs a tenth of a microsecond; loops call it for each block of a file or each stretch of
rows. Work that was not started by `Cancellation.run` (the command line, a notebook) is never
cancelled in this way: there Ctrl-C raises `KeyboardInterrupt`.
"""

from __future__ import annotations

from collections.abc import Callable
from contextvars import ContextVar
from typing import Final, TypeVar

T = TypeVar("T")


class Cancelled(BaseException):
    """The work was cancelled. No `except Exception` may swallow it; `finally` still cleans up."""


class Cancellation:
    """The request to end one piece of work."""

    __slots__ = ("requested",)

    def __init__(self) -> None:
        self.requested: bool = False
        """The work is to end; it may not have ended yet."""

    def request(self) -> None:
        """Let the work end at its next check; any thread may call."""
        self.requested = True

    def run(self, work: Callable[[], T]) -> T:
        """Return the result of `work`. Raises `Cancelled`, also if `request` came before."""
        token = _CURRENT.set(self)
        try:
            check_cancelled()
            return work()
        finally:
            _CURRENT.reset(token)


_AT_EACH_CHECK: Final[list[Callable[[], object]]] = []
_CURRENT: ContextVar[Cancellation | None] = ContextVar("cancellation", default=None)


def at_each_check(act: Callable[[], object]) -> None:
    """Call `act` at each check of long work: where threads take turns, it lets the others run."""
    _AT_EACH_CHECK.append(act)


def check_cancelled() -> None:
    """Raise `Cancelled` if the work of this thread is to end."""
    cancellation = _CURRENT.get()
    if cancellation is None:
        return
    if cancellation.requested:
        raise Cancelled
    for act in _AT_EACH_CHECK:
        act()
