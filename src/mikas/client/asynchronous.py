"""`AsyncEcu`: the same unit for asyncio programs. Every method is `Ecu`'s own, run in a worker
thread.

Nothing is written twice: a method here is a delegation to the one of the same name. One worker
thread does all of it, in order, so the event loop never waits for the wire.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from functools import partial, update_wrapper
from typing import Any, Concatenate, Generic, ParamSpec, Self, TypeVar

from mikas.client.connecting import connect
from mikas.client.ecu import Ecu
from mikas.client.reading import Reading

P = ParamSpec("P")
R = TypeVar("R")
_END = object()


class _Delegated(Generic[P, R]):
    """A method of `Ecu`, awaited instead of called."""

    def __init__(self, method: Callable[Concatenate[Ecu, P], R]) -> None:
        self._method = method
        self.__doc__ = method.__doc__

    def __get__(self, instance: AsyncEcu, owner: type[AsyncEcu]) -> Callable[P, asyncio.Future[R]]:
        def call(*args: P.args, **kwargs: P.kwargs) -> asyncio.Future[R]:
            return instance.run(partial(self._method, instance.ecu, *args, **kwargs))

        update_wrapper(call, self._method)
        return call


class _Iterated(Generic[P, R]):
    """A method of `Ecu` that gives an iterator, iterated with `async for`."""

    def __init__(self, method: Callable[Concatenate[Ecu, P], Iterator[R]]) -> None:
        self._method = method
        self.__doc__ = method.__doc__

    def __get__(self, instance: AsyncEcu, owner: type[AsyncEcu]) -> Callable[P, AsyncIterator[R]]:
        def call(*args: P.args, **kwargs: P.kwargs) -> AsyncIterator[R]:
            return instance.iterate(partial(self._method, instance.ecu, *args, **kwargs))

        update_wrapper(call, self._method)
        return call


class AsyncEcu:
    """`async with await AsyncEcu.connect("sim:") as ecu: print(await ecu.read("TWAT"))`."""

    info = _Delegated(Ecu.info)
    passport = _Delegated(Ecu.passport)
    read = _Delegated(Ecu.read)
    set_list = _Delegated(Ecu.set_list)
    read_list = _Delegated(Ecu.read_list)
    write_parameter = _Delegated(Ecu.write_parameter)
    faults = _Delegated(Ecu.faults)
    erase_faults = _Delegated(Ecu.erase_faults)
    goto = _Delegated(Ecu.goto)
    raw = _Delegated(Ecu.raw)
    watch = _Iterated(Ecu.watch)
    supported = _Iterated(Ecu.supported)

    def __init__(self, ecu: Ecu, worker: ThreadPoolExecutor) -> None:
        self.ecu = ecu
        self._worker = worker

    @classmethod
    async def connect(cls, url: str | None = None, **settings: Any) -> Self:  # noqa: ANN401
        """As `mikas.connect`, with the same settings, and the same errors."""
        worker = ThreadPoolExecutor(1, thread_name_prefix="mikas")
        loop = asyncio.get_running_loop()
        try:
            ecu = await loop.run_in_executor(worker, partial(connect, url, **settings))
        except BaseException:
            worker.shutdown(wait=False)
            raise
        return cls(ecu, worker)

    def run(self, call: Callable[[], R]) -> asyncio.Future[R]:
        """`call()` in the worker thread; for `ecu.memory` and everything that has no method here.

        `await ecu.run(lambda: ecu.ecu.memory.code.read_block(0, 16))`
        """
        return asyncio.get_running_loop().run_in_executor(self._worker, call)

    async def iterate(self, make: Callable[[], Iterator[R]]) -> AsyncIterator[R]:
        """What the iterator of `make()` gives, each item fetched in the worker thread."""
        iterator = await self.run(make)
        try:
            while (item := await self.run(partial(next, iterator, _END))) is not _END:
                yield item
        finally:
            if close := getattr(iterator, "close", None):
                await self.run(close)

    @asynccontextmanager
    async def stream(
        self, *names: str, stroke: int | None = None
    ) -> AsyncIterator[AsyncIterator[dict[str, Reading]]]:
        """As `Ecu.stream`, with `async with` and `async for`."""
        context = self.ecu.stream(*names, stroke=stroke)
        readings = await self.run(context.__enter__)
        try:
            yield self.iterate(lambda: readings)
        finally:
            await self.run(lambda: context.__exit__(None, None, None))

    async def close(self) -> None:
        """Lets go of the port and ends the worker thread."""
        await self.run(self.ecu.close)
        self._worker.shutdown(wait=False)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()
