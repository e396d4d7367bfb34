"""The stored faults as they were last read, and when each was first seen on this connection."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass

from mikas.catalog import Fault


@dataclass(frozen=True, slots=True)
class Page:
    """What one reading brought."""

    time: float
    faults: tuple[Fault, ...]
    first_seen: dict[int, float]


class FaultBook:
    """Any thread may write and read."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._first: dict[int, float] = {}
        self.page: Page | None = None

    def clear(self) -> None:
        """Another unit, or none."""
        with self._lock:
            self._first.clear()
            self.page = None

    def keep(self, faults: Sequence[Fault], time: float) -> Page:
        """`faults` were stored at `time`; one that came back after it was erased is new."""
        with self._lock:
            codes = [fault.code for fault in faults]
            self._first = {code: self._first.get(code, time) for code in codes}
            self.page = Page(time, tuple(faults), dict(self._first))
            return self.page
