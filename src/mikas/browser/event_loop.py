"""asyncio's own event loop on a green thread, in place of Pyodide's.

Pyodide's loop makes each callback a call from JavaScript. This one is `asyncio.BaseEventLoop` as it
is: only its wait for sockets, of which a browser has none, became a wait to be woken up.
"""

from __future__ import annotations

import asyncio
import threading
from typing import Any

from mikas.browser.suspension import give_way


class _Waker:
    """Where `BaseEventLoop` waits for events; none ever come but the wake-up."""

    def __init__(self) -> None:
        self._woken = threading.Event()

    def wake(self) -> None:
        self._woken.set()

    def select(self, timeout: float | None) -> list[Any]:
        """Wait for a wake-up, for `timeout` seconds at most."""
        if timeout is None or timeout > 0:
            self._woken.wait(timeout)
        else:  # the bytes of the port and other threads get their turn, too
            give_way()
        self._woken.clear()
        return []


class EventLoop(asyncio.BaseEventLoop):
    """An event loop without sockets."""

    def __init__(self) -> None:
        super().__init__()
        self._selector = _Waker()

    def _write_to_self(self) -> None:
        self._selector.wake()

    def _process_events(self, event_list: list[Any]) -> None:
        """Nothing: there are no events."""
