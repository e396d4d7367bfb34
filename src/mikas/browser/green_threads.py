"""Threads in a browser's worker, which has one: blocking code suspends its own stack.

`install` replaces what `threading` is made of, the lock and the start of a thread. Everything above
(`Condition`, `Event`, `queue`, executors, asyncio's and anyio's threads) is Python's own. Each
thread is a call from JavaScript on a stack of its own. It runs until it waits, so two never run at
once, and one that computes for long holds up all others. The reader worker exists for such work,
which gives way besides, where it looks whether it is cancelled.
"""

from __future__ import annotations

import _thread
import itertools
import queue
import sys
import threading
import time
from _threading_local import local
from collections.abc import Callable
from typing import Any, Final, Protocol, SupportsIndex

from mikas.browser.suspension import (
    MAIN,
    Promises,
    Wait,
    begin_thread,
    end_thread,
    get_ident,
    use,
)

_idents: Final = itertools.count(MAIN + 1)


class Stacks(Promises, Protocol):
    """What JavaScript hands in."""

    def start(self, run: Callable[[], None], /) -> None:
        """Call `run` soon, on a stack of its own that can be suspended."""


_stacks: Stacks


class Lock:
    """As `threading.Lock`. A release hands the lock to the thread that has waited longest."""

    __slots__ = ("__weakref__", "_held", "_waiting")

    def __init__(self) -> None:
        self._held = False
        self._waiting: list[Wait] = []

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """Acquire the lock; return whether it was, within `timeout` seconds."""
        if not self._held:
            self._held = True
            return True
        if not blocking or timeout == 0:
            return False
        wait = Wait()
        self._waiting.append(wait)
        if not wait.hold(None if timeout < 0 else timeout):
            self._waiting.remove(wait)
            return False
        return True

    def release(self) -> None:
        """Release the lock. Raises `RuntimeError` if it is not held."""
        if not self._held:
            raise RuntimeError("release unlocked lock")
        for wait in self._waiting:
            if not wait.done():  # else its time is up, and it removes itself
                self._waiting.remove(wait)
                wait.wake()
                return  # it stays held, by the other
        self._held = False

    def locked(self) -> bool:
        """Return whether the lock is held."""
        return self._held

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(self, *_: object) -> None:
        self.release()

    def _at_fork_reinit(self) -> None:
        self.__init__()  # type: ignore[misc]


class Handle:
    """As `_thread._ThreadHandle`: the system's part of a thread, which can be joined."""

    def __init__(self) -> None:
        self.ident: int | None = None
        self._running = Lock()

    def begin(self, ident: int) -> None:
        """Note that the thread has started."""
        self.ident = ident
        self._running.acquire()

    def join(self, timeout: float | None = None) -> None:
        """Wait until the thread has ended, for `timeout` seconds at most."""
        if self._running.acquire(timeout=-1 if timeout is None else max(timeout, 0)):
            self._running.release()

    def is_done(self) -> bool:
        """Return whether the thread has ended."""
        return self.ident is not None and not self._running.locked()

    def _set_done(self) -> None:
        if self._running.locked():
            self._running.release()


def _start(
    function: Callable[[], object], /, handle: Handle | None = None, *, daemon: bool = True
) -> Handle:
    """As `_thread.start_joinable_thread`. All are daemons: nothing waits for a tab's end."""
    del daemon
    handle = handle or Handle()
    ident = next(_idents)
    handle.begin(ident)

    def run() -> None:
        begin_thread(ident)
        try:
            function()
        except SystemExit:
            pass
        except BaseException as error:  # any: a bug, which must not end silently
            sys.excepthook(type(error), error, error.__traceback__)
        finally:
            handle._set_done()
            end_thread()

    _stacks.start(run)
    return handle


def _start_new(function: Callable[..., object], args: Any, kwargs: Any = None) -> int:  # noqa: ANN401
    """As `_thread.start_new_thread`."""
    ident = _start(lambda: function(*args, **(kwargs or {}))).ident
    assert ident is not None
    return ident


def sleep(seconds: float | SupportsIndex) -> None:
    """As `time.sleep`."""
    if float(seconds) < 0:
        raise ValueError("sleep length must be non-negative")
    Wait().hold(float(seconds))


def install(stacks: Stacks, run_sync: Callable[[Any], Any]) -> None:
    """Put these threads in place of Python's, before anything starts one or makes a lock."""
    global _stacks
    _stacks = stacks
    use(stacks, run_sync)
    module: Any = threading
    module.get_ident = get_ident
    module.Lock = module._allocate_lock = module._LockType = Lock
    module.local = local
    module._CRLock = None
    module.RLock = module._PyRLock
    module._start_joinable_thread = _start
    module._ThreadHandle = Handle
    bare: Any = _thread
    bare.get_ident = get_ident
    bare.allocate_lock = Lock
    bare.RLock = module._PyRLock
    bare.start_new_thread = _start_new
    bare.start_joinable_thread = _start
    queue.SimpleQueue = queue._PySimpleQueue  # type: ignore[attr-defined,misc]
    time.sleep = sleep
