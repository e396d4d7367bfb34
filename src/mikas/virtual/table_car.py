"""A car with constant data: for tests, and for a unit on a bench without an engine."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import ceil, inf


class TableCar:
    """Data from a table, raw bytes by parameter code; `rpm` only paces streams by strokes (D15)."""

    def __init__(
        self, data: Mapping[int, bytes], *, faults: Iterable[int] = (), rpm: float = 0.0
    ) -> None:
        self.codes = tuple(data)
        self.faults = list(faults)
        self.rpm = rpm
        self.on = True
        self._data = dict(data)
        self._untouched = dict(data)

    def size_of(self, code: int) -> int | None:
        """Bytes of the datum."""
        return len(self._data[code]) if code in self._data else None

    def raw(self, code: int, now: float) -> bytes:  # noqa: ARG002  (nothing moves here)
        """The datum, at any time."""
        return self._data[code]

    def write(self, code: int, data: bytes) -> bool:
        """Everything may be written."""
        self._data[code] = data
        return True

    def powered(self, now: float) -> bool:  # noqa: ARG002  (whatever the time)
        """As the switch `on` says."""
        return self.on

    def next_change(self, after: float) -> float:  # noqa: ARG002  (nothing moves here)
        """Never by itself."""
        return inf

    def next_stroke(self, stroke: int, after: float) -> float:
        """Cycles of two turns that began at time 0."""
        if self.rpm <= 0:
            return inf
        cycle = 120 / self.rpm
        offset = max(0, stroke - 1) * cycle / 4
        count = ceil((after - offset) / cycle)
        time = count * cycle + offset
        # The quotient of two floats may round onto the stroke that has just been.
        return time if time >= after else (count + 1) * cycle + offset

    def power_cycle(self) -> None:
        """Forget written data."""
        self._data = dict(self._untouched)
