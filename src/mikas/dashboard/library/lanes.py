"""Lanes of work: how many pieces run at a time, which of them wait, and what ends one.

A piece of work runs in a thread of its own. Of a lane's slots the network gets all but one, and one
key (a file) gets one from this computer and one from the network. Of the pieces that wait, those of
this computer come first, then one of each address in turn. So neither a long or crafted file nor a
viewer in the network takes up a lane, and no viewer's work makes this computer wait.

A piece is cancelled (`mikas.cancellation`) at its deadline, with the task that awaits it (its
client has disconnected), and at the end of the program; if it has not ended a second later, it is
interrupted, even in a loop without `check_cancelled`. Its slot is free when its thread has really
ended.
"""

from __future__ import annotations

import asyncio
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass
from traceback import clear_frames
from typing import Any, Final, TypeVar

from mikas.cancellation import Cancellation, Cancelled
from mikas.dashboard.errors import Busy, TookTooLong
from mikas.i18n import Text

T = TypeVar("T")

_PATIENCE: Final = 1.0  # s for a cancelled piece to end
_STEPS: Final = 10  # after which an exception sent to a thread has arrived
_TOO_MANY: Final = Text(
    "too many requests of this kind are waiting already; try again in a moment",
    "таких запросов уже ждёт слишком много; повторите чуть позже",
)
_CLOSING: Final = Text("the dashboard is closing", "панель закрывается")


@dataclass(frozen=True, slots=True)
class LaneLimits:
    """`slots`: pieces that run at once, two or more. `deadline`: seconds of one.

    `places`: pieces of this computer that run or wait; the network has as many, and one address in
    it `per_address` of these.
    """

    slots: int
    deadline: float
    places: int
    per_address: int


class _Piece:
    """`turn`: it may run. `done`: its thread has ended, with this outcome."""

    def __init__(self, key: str | None, address: str | None) -> None:
        self.key, self.address = key, address
        self.turn: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.outcome: Future[Any] = Future()
        self.done = asyncio.wrap_future(self.outcome)
        self.thread: WorkThread | None = None

    def cancel(self) -> None:
        """Let the work end at its next check."""
        if self.thread is not None:
            self.thread.cancellation.request()


class Lane:
    """One lane; its methods are called in the event loop.

    `address`: of a client in the network; None: the client is on this computer. `too_long`: the
    error of a piece that passes its deadline. `on_end`: called when a piece has ended.
    """

    def __init__(
        self,
        limits: LaneLimits,
        too_long: type[TookTooLong] = TookTooLong,
        on_end: Callable[[], None] = lambda: None,
    ) -> None:
        self.limits = limits
        self._too_long, self._on_end = too_long, on_end
        self._places: Counter[str | None] = Counter()
        self._turns: dict[str | None, int] = {}  # by address: the number of its last turn
        self._waiting: list[_Piece] = []
        self._running: list[_Piece] = []
        self._closed = False

    @contextmanager
    def place(self, address: str | None) -> Iterator[None]:
        """Hold a place for one piece, its waiting and the sending of its result. Raises `Busy`."""
        places, limits = self._places, self.limits
        if address is None:
            is_full = places[None] >= limits.places
        else:
            in_network = places.total() - places[None]
            is_full = in_network >= limits.places or places[address] >= limits.per_address
        if is_full:
            raise Busy(problem=_TOO_MANY)
        places[address] += 1
        try:
            yield
        finally:
            places[address] -= 1
            if not places[address]:
                del places[address]
                self._turns.pop(address, None)

    async def run(
        self,
        work: Callable[[], T],
        *,
        key: str | None,
        address: str | None,
        deadline: float | None = None,
    ) -> T:
        """Return the result of `work`; `deadline`: another than the lane's, from its start on.

        `key` None: it shares nothing with other work.

        Raises `TookTooLong`, and `Busy` at the end of the program.
        """
        if self._closed:
            raise Busy(problem=_CLOSING)
        deadline = self.limits.deadline if deadline is None else deadline
        piece = _Piece(key, address)
        self._waiting.append(piece)
        try:
            self._give_turns()
            await piece.turn
            self._start(piece, work)
        except BaseException:
            self._leave(piece)
            raise
        try:
            await asyncio.wait({piece.done}, timeout=deadline)
            if not piece.done.done():
                raise self._too_long(seconds=f"{deadline:g}")
            result: T = piece.done.result()
            return result
        except Cancelled:
            raise Busy(problem=_CLOSING) from None
        finally:
            await self._end(piece)  # the caller may delete the files that it works on

    @property
    def is_busy(self) -> bool:
        """Whether a piece runs or waits."""
        return bool(self._running or self._waiting)

    async def close(self) -> None:
        """Cancel all pieces, and give the running ones a moment to end."""
        self._closed = True
        for piece in self._waiting:
            if not piece.turn.done():
                piece.turn.set_exception(Busy(problem=_CLOSING))
        for piece in self._running:
            piece.cancel()
        if self._running:
            await asyncio.wait({piece.done for piece in self._running}, timeout=_PATIENCE)

    def _give_turns(self) -> None:
        """Give turns, except to those that may not run yet: to this computer first, then to the
        address whose last turn is the longest ago; of equals, in the order of coming.
        """
        while ready := [it for it in self._waiting if not it.turn.done() and self._may_run(it)]:
            piece = min(ready, key=lambda it: self._turns.get(it.address, 0) if it.address else -1)
            self._turns[piece.address] = max(self._turns.values(), default=0) + 1
            self._waiting.remove(piece)
            self._running.append(piece)
            piece.turn.set_result(None)

    def _may_run(self, piece: _Piece) -> bool:
        local = [it for it in self._running if it.address is None]
        network = [it for it in self._running if it.address is not None]
        if len(self._running) >= self.limits.slots:
            return False
        if piece.address is not None and len(network) >= self.limits.slots - 1:
            return False
        alike = local if piece.address is None else network
        return piece.key is None or piece.key not in (it.key for it in alike)

    def _leave(self, piece: _Piece) -> None:
        for pieces in (self._waiting, self._running):
            if piece in pieces:
                pieces.remove(piece)
        self._give_turns()

    def _start(self, piece: _Piece, work: Callable[[], object]) -> None:
        def leave(done: asyncio.Future[Any]) -> None:
            done.exception()  # retrieved here, in case its client has disconnected
            self._leave(piece)
            self._on_end()

        piece.done.add_done_callback(leave)
        piece.thread = WorkThread(f"mikas {piece.key or 'work'}", work, piece.outcome)
        piece.thread.start()

    @staticmethod
    async def _end(piece: _Piece) -> None:
        if piece.done.done() or piece.thread is None:
            return
        piece.cancel()
        try:
            await asyncio.wait({piece.done}, timeout=_PATIENCE)
        finally:
            if not piece.done.done():
                piece.thread.interrupt()


class WorkThread(threading.Thread):
    """Runs `work`, and sets its result or its exception as `outcome`.

    A daemon: it can't hold up the end of the program.
    """

    def __init__(self, name: str, work: Callable[[], object], outcome: Future[Any]) -> None:
        super().__init__(name=name, daemon=True)
        self.cancellation: Cancellation = Cancellation()
        self._work, self._outcome = work, outcome
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
        try:
            try:
                with self._gate:
                    self._may_interrupt = True
                result = self.cancellation.run(self._work)
            finally:
                self._close_gate()
        except BaseException as error:  # any: it is raised where the work is awaited
            # Its frames hold what the work has read, and it holds them, in a circle.
            clear_frames(error.__traceback__)
            self._outcome.set_exception(error)
        else:
            self._outcome.set_result(result)

    def _close_gate(self) -> None:
        """Let no exception come from outside after this."""
        try:
            with self._gate:
                self._may_interrupt = False
            for _ in range(_STEPS):  # one that was sent before arrives here at the latest
                pass
        except Cancelled:
            return  # too late; no second one is sent
