"""The stored faults as last read, when each was first seen on this connection, and the earlier
readings of the same unit, for a report's erased faults.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from mikas.catalog import Fault
from mikas.client import Ecu
from mikas.sampling.events import FaultReading

_MAX_KEPT: Final = 100  # readings that differ


@dataclass(frozen=True, slots=True)
class StoredFaults:
    """The faults of the latest reading, and when each was first seen."""

    time: float
    faults: tuple[Fault, ...]
    first_seen: dict[int, float]


class FaultHistory:
    """Any thread may write and read. `latest` is None until this connection's first reading."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._first: dict[int, float] = {}
        self._readings: list[FaultReading] = []
        self.latest: StoredFaults | None = None

    def disconnect(self) -> None:
        """End the connection; the unit's earlier readings are kept for its next one."""
        with self._lock:
            self._first.clear()
            self.latest = None

    def clear(self) -> None:
        """Drop everything: another unit answers."""
        self.disconnect()
        with self._lock:
            self._readings.clear()

    @property
    def readings(self) -> tuple[FaultReading, ...]:
        """The readings that differ from those before, and the latest; none without a latest one."""
        with self._lock:
            if self.latest is None:
                return ()
            return (*self._readings, FaultReading(self.latest.time, self._readings[-1].codes))

    def read(self, ecu: Ecu) -> StoredFaults:
        """Read the stored faults; a job of the sampling thread."""
        return self.add(ecu.faults(), ecu.tester.link.now())

    def add(self, faults: Sequence[Fault], time: float, *, erased: bool = False) -> StoredFaults:
        """Add the faults that were stored at `time`; `erased`: shortly before.

        A fault that came back after it was erased is new.
        """
        with self._lock:
            codes = tuple(fault.code for fault in faults)
            if not self._readings or self._readings[-1].codes != codes:
                self._readings = [*self._readings, FaultReading(time, codes, erased)][-_MAX_KEPT:]
            self._first = {code: self._first.get(code, time) for code in codes}
            self.latest = StoredFaults(time, tuple(faults), dict(self._first))
            return self.latest
