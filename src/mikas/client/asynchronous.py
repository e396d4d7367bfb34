"""`AsyncEcu`: a unit for asyncio programs. Its methods run those of `Ecu` in a worker thread.

One worker thread runs all calls in order, so the event loop never waits for the line. A cancelled
call ends between two exchanges, and so does every call at `close`: the worker is free for the next
one within the time of one exchange, and the line is in step.
"""

from __future__ import annotations

import asyncio
import re
from collections.abc import AsyncIterator, Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import asynccontextmanager, suppress
from functools import partial, update_wrapper, wraps
from inspect import signature
from typing import Concatenate, Final, Generic, NamedTuple, ParamSpec, Self, TypeVar, cast

from mikas.cancellation import Cancellation
from mikas.catalog import Catalog, Model
from mikas.client.connecting import StrPath, connect
from mikas.client.ecu import Ecu
from mikas.client.gate import Confirm
from mikas.client.memory.spaces import Memory, MemorySpace
from mikas.client.opening import Opening
from mikas.client.parameters.readings import Reading
from mikas.client.questions import Questions
from mikas.client.recorded import EcuRecording
from mikas.errors import CaptureError, LinkClosed

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")
_END = object()


class _Remote(Generic[T]):
    """An object whose methods are those of `_sync`, run in the worker thread of `_async_ecu`."""

    _async_ecu: AsyncEcu
    _sync: T


def _delegated(
    method: Callable[Concatenate[T, P], R],
) -> Callable[Concatenate[_Remote[T], P], asyncio.Future[R]]:
    """Return `method` of the unit, awaited instead of called."""

    @wraps(method)
    def call(self: _Remote[T], /, *args: P.args, **kwargs: P.kwargs) -> asyncio.Future[R]:
        return self._async_ecu.run(partial(method, self._sync, *args, **kwargs))

    return _returning(call, "Awaitable[{}]")


def _iterated(
    method: Callable[Concatenate[T, P], Iterator[R]],
) -> Callable[Concatenate[_Remote[T], P], AsyncItems[R]]:
    """As `_delegated`, for a method whose iterator is iterated with `async for`."""

    @wraps(method)
    def call(self: _Remote[T], /, *args: P.args, **kwargs: P.kwargs) -> AsyncItems[R]:
        return AsyncItems(self._async_ecu, partial(method, self._sync, *args, **kwargs))

    return _returning(call, "AsyncItems[{}]")


_ITERATED = re.compile(r"(?:Iterator|Generator)\[([^,]+?)(?:, None, None)?\]")


def _returning(call: Callable[P, R], form: str) -> Callable[P, R]:
    """Let `help` say what `call` returns, not what the unit's method does."""
    plain = signature(call)
    returned = str(plain.return_annotation)
    inner = _ITERATED.fullmatch(returned)
    changed = plain.replace(return_annotation=form.format(inner[1] if inner else returned))
    call.__signature__ = changed  # type: ignore[attr-defined]  # as inspect wants it
    return call


class _Connect(Generic[P]):
    """`connect`, awaited or entered by `async with`: the same options and errors."""

    def __init__(self, function: Callable[P, Ecu]) -> None:
        self._function = function
        self.__doc__ = function.__doc__

    def __get__(self, instance: object, owner: type[AsyncEcu]) -> Callable[P, Opening[AsyncEcu]]:
        async def opened(*args: P.args, **kwargs: P.kwargs) -> AsyncEcu:
            worker, questions = _Worker(), Questions(asyncio.get_running_loop())
            if callable(kwargs.get("confirm")):
                kwargs["confirm"] = questions.asking(cast("Confirm", kwargs["confirm"]))
            opening = worker.submit(partial(self._function, *args, **kwargs))
            try:
                return owner(await worker.awaited(opening), _worker=worker, _questions=questions)
            except BaseException:
                opening.future.add_done_callback(_close)  # it may open the unit all the same
                worker.end()
                raise

        def call(*args: P.args, **kwargs: P.kwargs) -> Opening[AsyncEcu]:
            return Opening(opened(*args, **kwargs))

        update_wrapper(call, self._function)
        return _returning(call, "AsyncEcu")


class _Call(NamedTuple, Generic[R]):
    """A call of the worker, and the request to end it."""

    future: Future[R]
    cancellation: Cancellation


class _Worker:
    """The one thread of an `AsyncEcu`."""

    def __init__(self) -> None:
        self._threads = ThreadPoolExecutor(1, thread_name_prefix="mikas")

    def submit(self, call: Callable[[], R]) -> _Call[R]:
        """Run `call()` after those before it. Raises `RuntimeError` after `end`."""
        cancellation = Cancellation()
        return _Call(self._threads.submit(cancellation.run, call), cancellation)

    def awaited(self, call: _Call[R]) -> asyncio.Future[R]:
        """Return what an event loop awaits; its cancellation ends the call."""
        awaited = asyncio.wrap_future(call.future)

        def ended(future: asyncio.Future[R]) -> None:
            if future.cancelled():
                call.cancellation.request()

        awaited.add_done_callback(ended)
        return awaited

    def end(self) -> None:
        """End the thread after its last call, without waiting for it."""
        self._threads.shutdown(wait=False)


class AsyncItems(AsyncIterator[R]):
    """The items of an iterator, each fetched in the worker thread.

    Cancelling the task that waits for an item ends the iterator, and so does its garbage collection
    after a `break`; `aclose` raises the error of ending it.
    """

    def __init__(self, ecu: AsyncEcu, make: Callable[[], Iterator[R]]) -> None:
        self._ecu = ecu
        self._items = _Items(make)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> R:
        try:
            item = await self._ecu.run(self._items.next)
        except asyncio.CancelledError:
            self._end()
            raise
        if item is _END:
            raise StopAsyncIteration
        return item  # type: ignore[return-value]  # anything but _END is the iterator's

    async def aclose(self) -> None:
        """End the iterator and a stream that it runs; a second call does nothing."""
        await self._ecu._ended(self._items.close)  # noqa: SLF001  (as below)

    def _end(self) -> None:
        # After the worker's current call, before the next one.
        self._ecu._submit(self._items.close)  # noqa: SLF001  (these items belong to it)

    def __del__(self) -> None:
        if not self._items.ended:
            self._end()


class _Items(Generic[R]):
    """The worker's side of `AsyncItems`, without a reference to it."""

    def __init__(self, make: Callable[[], Iterator[R]]) -> None:
        self._make = make
        self._iterator: Iterator[R] | None = None
        self.ended = False

    def next(self) -> R | object:
        if self.ended:
            return _END
        if self._iterator is None:
            self._iterator = self._make()
        item = next(self._iterator, _END)
        self.ended = item is _END
        return item

    def close(self) -> None:
        self.ended = True
        if close := getattr(self._iterator, "close", None):
            close()


class AsyncMemorySpace(_Remote[MemorySpace]):
    """A `MemorySpace`, with its methods to be awaited."""

    read: Final = _delegated(MemorySpace.read)
    read_block: Final = _delegated(MemorySpace.read_block)
    blocks: Final = _iterated(MemorySpace.blocks)
    write: Final = _delegated(MemorySpace.write)
    write_block: Final = _delegated(MemorySpace.write_block)
    write_runs: Final = _iterated(MemorySpace.write_runs)

    def __init__(self, ecu: AsyncEcu, sync: MemorySpace) -> None:
        self._async_ecu = ecu
        self._sync = sync
        self.name: str = sync.name
        """ram, xram, code or sfr."""
        self.last: int = sync.last
        """The highest address."""


class AsyncMemory:
    """`memory.ram`, `.xram`, `.code`, `.sfr`; or by name, `memory["ram"]`."""

    ram: AsyncMemorySpace
    """Internal RAM."""
    xram: AsyncMemorySpace
    """External RAM."""
    code: AsyncMemorySpace
    """Program memory."""
    sfr: AsyncMemorySpace
    """Special function registers."""

    def __init__(self, ecu: AsyncEcu, sync: Memory) -> None:
        self._sync = sync
        self.ram, self.xram, self.code, self.sfr = (
            AsyncMemorySpace(ecu, sync[name]) for name in Memory.NAMES
        )

    def __getitem__(self, name: str) -> AsyncMemorySpace:
        space: AsyncMemorySpace = getattr(self, self._sync[name].name)
        return space


class AsyncEcu(_Remote[Ecu]):
    """`async with AsyncEcu.connect("sim:") as ecu: print(await ecu.read("TWAT"))`.

    `await AsyncEcu.connect("sim:")` is one to be closed by `close`.
    `AsyncEcu(ecu)` takes an open `Ecu`. `ecu.ecu` is that; `run` calls what has no method here.
    `confirm` of `connect` may be a coroutine function; the event loop answers the gate by it.
    """

    connect: Final = _Connect(connect)
    info: Final = _delegated(Ecu.info)
    passport: Final = _delegated(Ecu.passport)
    read: Final = _delegated(Ecu.read)
    set_list: Final = _delegated(Ecu.set_list)
    read_list: Final = _delegated(Ecu.read_list)
    forget_list: Final = _delegated(Ecu.forget_list)
    write_parameter: Final = _delegated(Ecu.write_parameter)
    faults: Final = _delegated(Ecu.faults)
    engine_speed: Final = _delegated(Ecu.engine_speed)
    erase_faults: Final = _delegated(Ecu.erase_faults)
    goto: Final = _delegated(Ecu.goto)
    raw: Final = _delegated(Ecu.raw)
    limits: Final = _delegated(Ecu.limits)
    keep_timings: Final = _delegated(Ecu.keep_timings)
    forget_limits: Final = _delegated(Ecu.forget_limits)
    watch: Final = _iterated(Ecu.watch)
    supported: Final = _iterated(Ecu.supported)
    scan: Final = _iterated(Ecu.scan)

    def __init__(
        self, ecu: Ecu, *, _worker: _Worker | None = None, _questions: Questions | None = None
    ) -> None:
        self.ecu = ecu
        """The `Ecu` that the worker thread uses."""
        self.memory: AsyncMemory = AsyncMemory(self, ecu.memory)
        """Its memory, with methods to be awaited."""
        self._async_ecu = self
        self._sync = ecu
        self._worker = _worker or _Worker()
        self._questions = _questions
        if _questions:
            _questions.check = ecu.tester.ends.check
        self._closing: asyncio.Future[None] | None = None

    @property
    def catalog(self) -> Catalog:
        """As `Ecu.catalog`."""
        return self.ecu.catalog

    @property
    def model(self) -> Model:
        """As `Ecu.model`."""
        return self.ecu.model

    @property
    def version_code(self) -> int:
        """As `Ecu.version_code`."""
        return self.ecu.version_code

    def run(self, call: Callable[[], R]) -> asyncio.Future[R]:
        """Run `call()` in the worker thread: `await ecu.run(lambda: ecu.ecu.tester.statistics)`.

        Raises the errors of `call`, and `LinkClosed` after `close`. If the task that waits is
        cancelled, `call` ends between two exchanges.
        """
        return self._worker.awaited(self._submitted(call))

    def iterate(self, make: Callable[[], Iterator[R]]) -> AsyncItems[R]:
        """Iterate over `make()`, with each item fetched in the worker thread."""
        return AsyncItems(self, make)

    @asynccontextmanager
    async def stream(
        self, *names: str, stroke: int | None = None
    ) -> AsyncIterator[AsyncItems[dict[str, Reading]]]:
        """As `Ecu.stream`, with `async with` and `async for`."""
        context = self.ecu.stream(*names, stroke=stroke)
        try:
            readings = await self.run(context.__enter__)
            yield self.iterate(lambda: readings)
        except BaseException as error:
            # Also if it was cancelled while the worker started the stream.
            await self._ended(partial(context.__exit__, type(error), error, error.__traceback__))
            raise
        await self._ended(partial(context.__exit__, None, None, None))

    @asynccontextmanager
    async def record(
        self,
        path: StrPath,
        *,
        on_failure: Callable[[CaptureError], object] | None = None,
    ) -> AsyncIterator[EcuRecording]:
        """As `Ecu.record`, with `async with`; `on_failure` is called in the worker thread."""
        call = self._submitted(lambda: self.ecu.record(path, on_failure=on_failure))
        try:
            recording = await self._worker.awaited(call)
        except BaseException:
            call.future.add_done_callback(_close)  # it may have begun all the same
            raise
        with recording:
            yield recording

    async def close(self) -> None:
        """Close the port and end the worker thread; a second call does nothing.

        A call that another task waits for ends with `LinkClosed` before its next exchange, and a
        question that is not answered yet counts as answered with no. If the task that waits is
        cancelled, the port is closed all the same.
        """
        if self._closing is None:
            if self._questions:
                self._questions.end()
            self.ecu.tester.end_calls()
            self._closing = self._worker.awaited(self._worker.submit(self.ecu.close))
            self._worker.end()
        await asyncio.shield(self._closing)

    async def _ended(self, call: Callable[[], object]) -> None:
        """Run what ends a stream, also if the task that waits is cancelled; `close` ends all."""
        with suppress(LinkClosed):
            await asyncio.shield(self.run(call))

    def _submitted(self, call: Callable[[], R]) -> _Call[R]:
        """Return the running `call`. Raises `LinkClosed` after `close`."""
        if self._closing is not None:
            raise LinkClosed(url=self.ecu.tester.link.url)
        return self._worker.submit(call)

    def _submit(self, call: Callable[[], object]) -> None:
        with suppress(RuntimeError):  # closed meanwhile, which ended the iterator
            self._worker.submit(call)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()


def _close(opening: Future[Ecu] | Future[EcuRecording]) -> None:
    if not opening.cancelled() and opening.exception() is None:
        opening.result().close()
