"""The lock on writing memory and parameters: open for some minutes, on one connection,
for the client that opened it: when the seat changes hands it is closed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(slots=True)
class WritingLock:
    """`clock`: seconds that never run back."""

    clock: Callable[[], float]
    _until: float | None = None

    def open(self, seconds: float) -> None:
        """Lets write for so long from now on."""
        self._until = self.clock() + seconds

    def close(self) -> None:
        """No more writing."""
        self._until = None

    @property
    def left(self) -> float | None:
        """Seconds until it closes itself; None: it is closed."""
        until = self._until
        left = 0.0 if until is None else until - self.clock()
        return left if left > 0 else None
