"""Threads in a browser's worker, which has one: blocking code suspends its own stack (JSPI).

`install` replaces what `threading` is made of, the lock and the start of a thread. Everything above
(`Condition`, `Event`, `queue`, executors, asyncio's and anyio's threads) is Python's own. Each
thread is a call from JavaScript on a stack of its own, with a thread state of its own in Pyodide.
A thread runs until it waits, so two never run at once, and one that computes for long holds up all
others: the reader worker exists for such work.

The waits are JavaScript's (`web/src/site/worker/waits.ts`).
"""

from __future__ import annotations

import _thread
import itertools
import queue
import sys
import threading
import time
from _threading_local import local
from asyncio.events import _get_running_loop, _set_running_loop
from asyncio.tasks import _swap_current_task  # type: ignore[attr-defined]
from collections import deque
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any, Final, Protocol, SupportsIndex

if TYPE_CHECKING:
    import asyncio

_MAIN: Final = _thread.get_ident()
_idents = itertools.count(_MAIN + 1)
_ident = _MAIN
"""Of the running thread."""


class Wait(Protocol):
    """A promise that `wake` keeps with true, and a time limit with false."""

    promise: Awaitable[bool]

    def wake(self) -> None: ...


class Waits(Protocol):
    """What JavaScript hands in."""

    def wait(self, milliseconds: float | None, /) -> Wait: ...

    def turn(self) -> Wait:
        """Return a wait that is over after all that the browser has waiting."""

    def start(self, run: Callable[[], None], /) -> None:
        """Call `run` soon, on a stack of its own."""


_waits: Waits
_pyodide_loop: asyncio.AbstractEventLoop | None = None
_run_sync: Callable[[Awaitable[Any]], Any]


def suspend(promise: Awaitable[Any]) -> Any:  # noqa: ANN401  (what JavaScript's promise holds)
    """Wait for a promise of JavaScript; other threads run meanwhile. Raises its rejection.

    Pyodide waits by a task of its own event loop, and its thread states share what a thread has for
    itself. So the running loop, its task and the number of this thread are put back afterwards.
    """
    global _ident
    ident, _ident = _ident, _MAIN
    loop = _get_running_loop()
    task = _swap_current_task(loop, None) if loop is not None else None
    _set_running_loop(_pyodide_loop)
    try:
        return _run_sync(promise)
    finally:
        _ident = ident
        _set_running_loop(loop)
        if loop is not None:
            _swap_current_task(loop, task)


def yield_turn() -> None:
    """Let everything run that the browser has waiting: messages, bytes of the port, timers."""
    suspend(_waits.turn().promise)


def get_ident() -> int:
    """Return the number of the running thread."""
    return _ident


class Lock:
    """As `threading.Lock`. A release hands the lock to the thread that has waited longest."""

    __slots__ = ("__weakref__", "_held", "_waiting")

    def __init__(self) -> None:
        self._held = False
        self._waiting: deque[Wait] | None = None

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """Acquire the lock; return whether it was, within `timeout` seconds."""
        if not self._held:
            self._held = True
            return True
        if not blocking or timeout == 0:
            return False
        wait = _waits.wait(None if timeout < 0 else timeout * 1000)
        if self._waiting is None:
            self._waiting = deque()
        self._waiting.append(wait)
        woken: bool = suspend(wait.promise)
        if not woken and wait in self._waiting:
            self._waiting.remove(wait)
            return False
        return True  # perhaps handed over just when the time was up

    def release(self) -> None:
        """Release the lock. Raises `RuntimeError` if it is not held."""
        if not self._held:
            raise RuntimeError("release unlocked lock")
        if self._waiting:
            self._waiting.popleft().wake()  # it stays held, by the other
        else:
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
        global _ident
        _ident = ident
        _set_running_loop(None)
        try:
            function()
        except SystemExit:
            pass
        except BaseException as error:  # any: a bug, which must not end silently
            sys.excepthook(type(error), error, error.__traceback__)
        finally:
            handle._set_done()
            _ident = _MAIN
            _set_running_loop(_pyodide_loop)

    _waits.start(run)
    return handle


def _start_new(function: Callable[..., object], args: Any, kwargs: Any = None) -> int:  # noqa: ANN401
    """As `_thread.start_new_thread`."""
    ident = _start(lambda: function(*args, **(kwargs or {}))).ident
    assert ident is not None
    return ident


def sleep(seconds: float | SupportsIndex) -> None:
    """As `time.sleep`."""
    milliseconds = float(seconds) * 1000
    if milliseconds < 0:
        raise ValueError("sleep length must be non-negative")
    suspend(_waits.wait(milliseconds).promise)


def install(waits: Waits, run_sync: Callable[[Awaitable[Any]], Any]) -> None:
    """Put these threads in place of Python's, before anything starts one or makes a lock."""
    global _waits, _run_sync, _pyodide_loop
    _waits, _run_sync = waits, run_sync
    _pyodide_loop = _get_running_loop()
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
