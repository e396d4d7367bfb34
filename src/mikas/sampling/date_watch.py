"""The computer's date against the clock of the links, which is never set.

The clock runs evenly from the date that it was made at. When the difference from the date moves,
either the computer slept and the clock stood still (a browser's, a paused virtual machine's): time
has passed, so the clock is behind. Or the date was set (a Pi's first NTP, a person): no time has
passed, the clock is right, and all dates were wrong until now.

Two clocks can't tell one from the other, but the line can: no computer sleeps while values come.
Forward, and while none come, or shortly before they stop, it was a sleep; else the date was set.
Differences below `_LEAST` are drift and no jump; drift adds up to one that is corrected as such.
"""

from __future__ import annotations

from typing import Final, NamedTuple

_LEAST: Final = 1.0  # s
_PATIENCE: Final = 4.0  # s in which values stop after a sleep: time-outs, an adapter that is reset
_LONGEST_SLEEP: Final = 30 * 86400.0  # s; a date without a battery lies years back
GRAIN: Final = 1024  # parts of a second: such a correction of a date can be taken back exactly


class Jump(NamedTuple):
    """The date moved by `seconds`, from `before` to `after`, at about `time` of the clock."""

    time: float
    seconds: float
    before: float
    after: float
    slept: bool


class DateWatch:
    """Compares the date with the clock, at each `look`."""

    def __init__(self) -> None:
        self._difference: float | None = None  # of date and clock, without the jumps so far
        self._jump: Jump | None = None  # as first seen, not judged yet

    def look(self, now: float, date: float, *, broken: bool) -> Jump | None:
        """Return the jump that is certain by now. `broken`: no values come at present.

        After a sleep, `now` is to have it in it from the next look on.
        """
        if self._difference is None:
            self._difference = date - now
            return None
        before = now + self._difference
        seconds = round((date - before) * GRAIN) / GRAIN
        if abs(seconds) < _LEAST:
            self._jump = None
            return None
        if self._jump is None or abs(seconds - self._jump.seconds) >= _LEAST:
            self._jump = Jump(now, seconds, before, date, slept=False)
        slept = broken and 0 < seconds <= _LONGEST_SLEEP
        if not slept and not broken and now - self._jump.time < _PATIENCE:
            return None
        return self._judged(slept=slept)

    def conclude(self) -> Jump | None:
        """Return the jump that was not certain yet, at the end of a session: the date was set."""
        return None if self._jump is None else self._judged(slept=False)

    def _judged(self, *, slept: bool) -> Jump:
        assert self._jump is not None
        assert self._difference is not None
        jump, self._jump = self._jump._replace(slept=slept), None
        if not slept:
            self._difference += jump.seconds
        return jump
