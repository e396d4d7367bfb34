"""How long nothing has come, by a clock: a table is drawn also while nothing tells it anything.

A wire that has fallen silent is told by an event only after the attempts to wake it; until then the
last values would stand there as if they were of now.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

_LEAST = 1.0  # s that are no silence yet, however fast samples came
_STEPS = 3  # usual ones that are none either
_GONE = 2  # times as long, and the last values are no values any more
_USUAL = 20  # latest steps, of which the longest is a usual one


@dataclass(frozen=True, slots=True)
class Silence:
    """`seconds` since the last sample, 0 while that is usual; `gone`: its values are too old."""

    seconds: float = 0.0
    gone: bool = False


class Arrivals:
    """When samples came, by `clock`, and how long a step from one to the next usually is."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._latest: float | None = None
        self._steps: deque[float] = deque(maxlen=_USUAL)

    def came(self) -> None:
        """A sample is here."""
        now = self._clock()
        if self._latest is not None:
            self._steps.append(now - self._latest)
        self._latest = now

    def broke(self) -> None:
        """None is to be expected now, and it was told why."""
        self._latest = None

    def silence(self) -> Silence:
        """The silence of now; none before it is known how long a step is."""
        if self._latest is None or not self._steps:
            return Silence()
        seconds = self._clock() - self._latest
        most = max(_LEAST, _STEPS * max(self._steps))
        return Silence(seconds, seconds >= _GONE * most) if seconds >= most else Silence()
