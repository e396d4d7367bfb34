"""The stored faults as they were last read, when each was first seen on this connection, and what
the same unit told before: a report has to say what was erased.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass

from mikas.catalog import Fault
from mikas.report.fault_history import FaultReading

_MOST = 100  # readings that differ


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
        self._heard: list[FaultReading] = []
        self.page: Page | None = None

    def clear(self) -> None:
        """Nobody is connected; what the unit told before is kept, should it come back."""
        with self._lock:
            self._first.clear()
            self.page = None

    def forget(self) -> None:
        """It is another unit."""
        self.clear()
        with self._lock:
            self._heard.clear()

    @property
    def heard(self) -> tuple[FaultReading, ...]:
        """The readings that differ from the ones before, and the latest; none: not read on this
        connection.
        """
        with self._lock:
            if self.page is None:
                return ()
            return (*self._heard, FaultReading(self.page.time, self._heard[-1].codes))

    def keep(self, faults: Sequence[Fault], time: float, *, erased: bool = False) -> Page:
        """`faults` were stored at `time`, `erased`: just after erasing; one that came back after it
        was erased is new.
        """
        with self._lock:
            codes = [fault.code for fault in faults]
            if not self._heard or self._heard[-1].codes != tuple(codes):
                self._heard = [*self._heard, FaultReading(time, tuple(codes), erased)][-_MOST:]
            self._first = {code: self._first.get(code, time) for code in codes}
            self.page = Page(time, tuple(faults), dict(self._first))
            return self.page
