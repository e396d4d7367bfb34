"""Stacks that wait: Pyodide suspends the running one until a future is done (JSPI).

`pyodide.ffi.run_sync` takes any future. That of a promise costs a task of Pyodide's event loop, a
third of a millisecond; `Wait` is a future that calls back at once, a tenth of that. JavaScript has
the promises and timers (`web/src/site/worker/waits.ts`) and says by number which one is over.

Pyodide's thread states share what a thread has for itself: the number of the running thread, the
running event loop and its task are put back when a stack goes on.
"""

from __future__ import annotations

import _thread
import itertools
import time
from asyncio.events import _get_running_loop, _set_running_loop

# Not in the type stubs; nothing public puts back the task of a stack that goes on.
from asyncio.tasks import _swap_current_task  # type: ignore[attr-defined]
from collections.abc import Awaitable, Callable, Generator
from typing import TYPE_CHECKING, Any, Final, Protocol, cast

if TYPE_CHECKING:
    import asyncio

MAIN: Final = _thread.get_ident()
"""The number of the thread that runs what JavaScript calls."""

_LONGEST_RUN: Final = 0.008  # s of Python; then the browser and all that wait for it have a turn

_numbers = itertools.count()
_waiting: dict[int, Wait] = {}
_ident = MAIN
_promises: Promises
_run_sync: Callable[[Any], Any]
_pyodide_loop: asyncio.AbstractEventLoop | None = None
_turned = 0.0
"""When JavaScript said last that something is over."""


class Promises(Protocol):
    """What JavaScript hands in. Of each `number` it says once that it is over."""

    def answer(
        self, kept: Callable[[int, Any], None], broken: Callable[[int, object], None], /
    ) -> None:
        """Report the end of each number by these."""

    def follow(self, number: int, promise: Awaitable[Any], /) -> None:
        """It is over when the promise is kept or broken."""

    def after(self, number: int, milliseconds: float, /) -> None:
        """It is over after this time, unless it is cancelled."""

    def cancel(self, number: int, /) -> None: ...

    def turn(self, number: int, /) -> None:
        """It is over after all that the browser has waiting."""


class Wait:
    """A future for one stack, which `wake` ends with its result; the first call counts."""

    __slots__ = ("_callback", "_done", "_error", "_number", "_result")
    _asyncio_future_blocking = False  # by which asyncio knows a future

    def __init__(self) -> None:
        self._callback: Callable[[Wait], object] | None = None
        self._done = False
        self._error: BaseException | None = None
        self._number = -1
        self._result: Any = None

    def hold(self, seconds: float | None = None) -> Any:  # noqa: ANN401  (what `wake` got)
        """Suspend this stack until `wake`, and return its result; False after `seconds`."""
        if self._done:
            return self.result()
        if seconds is None:
            result = _hold(self)
            give_way()  # stacks that wake each other would leave the browser no turn
            return result
        _promises.after(self.listen(), seconds * 1000)
        try:
            return _hold(self)
        finally:
            if _waiting.pop(self._number, None) is not None:
                _promises.cancel(self._number)

    def listen(self) -> int:
        """Return the number by which JavaScript ends this wait."""
        self._number = next(_numbers)
        _waiting[self._number] = self
        return self._number

    def wake(self, result: object = True, error: BaseException | None = None) -> None:
        """End the wait; from any stack, or from JavaScript."""
        if self._done:
            return
        self._done, self._result, self._error = True, result, error
        if self._callback is not None:
            self._callback(self)

    def add_done_callback(
        self, callback: Callable[[Wait], object], *, context: object = None
    ) -> None:
        """As a future; `context` is asyncio's, and stacks have none."""
        del context
        self._callback = callback
        if self._done:
            callback(self)

    def done(self) -> bool:
        """As a future."""
        return self._done

    def cancelled(self) -> bool:
        """As a future; it is never cancelled."""
        return False

    def exception(self) -> BaseException | None:
        """As a future."""
        return self._error

    def result(self) -> Any:  # noqa: ANN401  (what `wake` got)
        """As a future."""
        if self._error is not None:
            raise self._error
        return self._result

    def get_loop(self) -> asyncio.AbstractEventLoop | None:
        """As a future; it belongs to no loop, so it fits every one."""
        return _get_running_loop()

    def __await__(self) -> Generator[Wait, None, Any]:
        yield self
        return self.result()


def use(promises: Promises, run_sync: Callable[[Any], Any]) -> None:
    """Use what JavaScript hands in."""
    global _promises, _run_sync, _pyodide_loop
    _promises, _run_sync = promises, run_sync
    _pyodide_loop = _get_running_loop()

    def kept(number: int, result: object) -> None:
        global _turned
        _turned = time.perf_counter()
        if (wait := _waiting.pop(number, None)) is not None:
            wait.wake(result)

    def broken(number: int, reason: object) -> None:
        """JavaScript may break a promise by anything, Python raises exceptions only."""
        error = reason if isinstance(reason, BaseException) else RuntimeError(str(reason))
        if (wait := _waiting.pop(number, None)) is not None:
            wait.wake(error=error)

    promises.answer(kept, broken)


def suspend(promise: Awaitable[Any]) -> Any:  # noqa: ANN401  (what the promise holds)
    """Wait for a promise of JavaScript; other threads run meanwhile. Raises its rejection."""
    wait = Wait()
    _promises.follow(wait.listen(), promise)
    return wait.hold()


def yield_turn() -> None:
    """Let everything run that the browser has waiting: messages, bytes of the port, timers."""
    wait = Wait()
    _promises.turn(wait.listen())
    wait.hold()


def give_way() -> None:
    """Let everything run, as `yield_turn`, if the browser had no turn for some milliseconds."""
    if time.perf_counter() - _turned > _LONGEST_RUN:
        yield_turn()


def begin_thread(ident: int) -> None:
    """Note that the running stack is that of a new thread."""
    global _ident
    _ident = ident
    _set_running_loop(None)


def end_thread() -> None:
    """Note that it ends; what JavaScript calls next runs in the main thread."""
    global _ident
    _ident = MAIN
    _set_running_loop(_pyodide_loop)


def get_ident() -> int:
    """Return the number of the running thread."""
    return _ident


def _hold(wait: Wait) -> Any:  # noqa: ANN401  (what `wake` got)
    global _ident
    ident, _ident = _ident, MAIN
    loop = _get_running_loop()
    task = _swap_current_task(loop, None) if loop is not None else None
    _set_running_loop(_pyodide_loop)
    try:
        return _run_sync(cast("Any", wait))
    finally:
        _ident = ident
        _set_running_loop(loop)
        if loop is not None:
            _swap_current_task(loop, task)
