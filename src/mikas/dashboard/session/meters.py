"""What the line does now: sets a second, how full the wire is, errors in the last minute.

All by the link's clock, so that a simulated one reads alike.
"""

from __future__ import annotations

from collections import deque

_RATE_OVER = 3.0
_LOAD_OVER = 3.0
_MINUTE = 60.0
_BITS_PER_BYTE = 10  # §1


class Meters:
    """The caller holds the monitor's lock."""

    def __init__(self) -> None:
        self.samples = 0
        self.errors = 0
        self._times: deque[float] = deque()
        self._wire: deque[tuple[float, int]] = deque()
        self._errors: deque[float] = deque(maxlen=10_000)

    def sample(self, time: float) -> None:
        """One set came."""
        self.samples += 1
        self._times.append(time)
        while self._times[0] < time - _RATE_OVER:
            self._times.popleft()

    def error(self, time: float) -> None:
        """One more exchange was spoilt."""
        self.errors += 1
        self._errors.append(time)

    def wire(self, time: float, total: int) -> None:
        """`total` bytes have passed on the wire so far."""
        if not self._wire or time - self._wire[-1][0] >= 0.2:
            self._wire.append((time, total))
        while len(self._wire) > 2 and self._wire[1][0] < time - _LOAD_OVER:
            self._wire.popleft()

    def rate(self, now: float) -> float:
        """Sets a second; 0 when none came lately."""
        times = self._times
        while times and times[0] < now - _RATE_OVER:
            times.popleft()
        if len(times) < 2:
            return 0.0
        seconds = max(times[-1] - times[0], now - times[0] - 1.0)
        return (len(times) - 1) / seconds if seconds > 0 else 0.0

    def load(self, baud: int) -> float:
        """The part of the time in which the wire carries something."""
        if len(self._wire) < 2:
            return 0.0
        (began, before), (ended, after) = self._wire[0], self._wire[-1]
        if ended <= began:
            return 0.0
        return min(1.0, (after - before) * _BITS_PER_BYTE / baud / (ended - began))

    def errors_minute(self, now: float) -> int:
        """Spoilt exchanges of the last minute."""
        while self._errors and self._errors[0] < now - _MINUTE:
            self._errors.popleft()
        return len(self._errors)
