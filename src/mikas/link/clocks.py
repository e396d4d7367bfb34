"""The clocks of links in real time, which never run back."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Final


def _steady(system: str = sys.platform) -> Callable[[], float]:
    """Return a steady clock that goes on while the computer sleeps.

    On macOS CLOCK_MONOTONIC is of the calendar, in whole µs, and may step back with it. On Windows
    it is `perf_counter`; `monotonic` has steps of 15.6 ms there up to Python 3.12.
    """
    name = {"linux": "CLOCK_BOOTTIME", "darwin": "CLOCK_MONOTONIC_RAW"}.get(system, "")
    number = getattr(time, name, None)
    return time.perf_counter if number is None else partial(time.clock_gettime, number)


_STEADY: Final = _steady()


class WallClock:
    """The clock of links in real time: UNIX time at its creation, steady from there.

    Changes of the system's date do not affect it, so intervals are exact. It may drift from UNIX
    time over hours. `steady` counts the seconds, `date` is the computer's, in UNIX time.
    """

    __slots__ = ("_offset", "_steady", "date")

    def __init__(
        self,
        steady: Callable[[], float] = _STEADY,
        date: Callable[[], float] | None = None,
    ) -> None:
        self._steady = steady
        self.date: Callable[[], float] = date or time.time
        """Returns the computer's date, in UNIX time."""
        self._offset = self.date() - steady()

    def now(self) -> float:
        """Return the seconds since 1970; a float resolves about 0.25 µs."""
        return self._offset + self._steady()

    def skip(self, seconds: float) -> None:
        """Add the seconds of a sleep in which the steady clock stood still, as in a browser."""
        self._offset += seconds


_LONGEST_STEP: Final = 600.0  # s that a virtual car catches up at once, in about a second


class AwakeClock(WallClock):
    """As `WallClock`, but it stands still while the computer sleeps: a virtual car's.

    On some systems `steady` runs on in a sleep. So no step is longer than `_LONGEST_STEP`; a car
    that is used asks every second.
    """

    __slots__ = ("_latest", "_lock")

    def __init__(self, steady: Callable[[], float] = time.perf_counter) -> None:
        super().__init__(steady)
        self._lock = threading.Lock()
        self._latest = super().now()

    def now(self) -> float:
        """Return the seconds since 1970, without those of a sleep."""
        with self._lock:
            now = super().now()
            if (slept := now - self._latest - _LONGEST_STEP) > 0:
                self.skip(-slept)
                now -= slept
            self._latest = now
            return now
