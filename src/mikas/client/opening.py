"""What `AsyncEcu.connect` returns: to be awaited, or to be entered at once.

ecu = await AsyncEcu.connect("sim:")
async with AsyncEcu.connect("sim:") as ecu: ...
"""

from __future__ import annotations

from collections.abc import Coroutine, Generator
from typing import Any, Generic, Protocol, TypeVar


class _Closing(Protocol):
    async def close(self) -> None: ...


T = TypeVar("T", bound=_Closing)


class Opening(Coroutine[Any, Any, T], Generic[T]):
    """A coroutine that is an asynchronous context manager too; leaving it closes the result."""

    def __init__(self, coroutine: Coroutine[Any, Any, T]) -> None:
        self._coroutine = coroutine
        self._opened: T | None = None

    def send(self, value: Any) -> Any:  # noqa: ANN401  (of any coroutine)
        """As of a coroutine."""
        return self._coroutine.send(value)

    def throw(self, *error: Any) -> Any:  # noqa: ANN401  (as `send`)
        """As of a coroutine."""
        return self._coroutine.throw(*error)

    def close(self) -> None:
        """As of a coroutine."""
        self._coroutine.close()

    def __await__(self) -> Generator[Any, Any, T]:
        return self._coroutine.__await__()

    async def __aenter__(self) -> T:
        self._opened = await self._coroutine
        return self._opened

    async def __aexit__(self, *_: object) -> None:
        if self._opened is not None:
            await self._opened.close()
