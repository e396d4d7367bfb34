"""The computer's date against the clock of the links, which is never set.

The clock runs evenly from the date that it was made at. When the difference from the date moves,
either the computer slept and the clock stood still (a browser's, a paused virtual machine's): time
has passed, so the clock is behind. Or the date was set (a Pi's first NTP, a person): no time has
passed, the clock is right, and all dates were wrong until now.

Two clocks can't distinguish them, but the line can: no computer sleeps while values come.
Forward, and while none come, or shortly before they stop, it was a sleep; else the date was set.

Differences below `LEAST` are no jump. A clock that drifts from the date, as fast as NTP may slew
one, is followed: its drift is noted as a set date when it has added up to `_MOST_DRIFT`. A date
that is slewed faster is noted once, when it rests.
"""

from __future__ import annotations

from typing import Final, NamedTuple

LEAST: Final = 1.0  # s
_DRIFT: Final = 0.001  # twice the 500 ppm of NTP: the crystal has a drift of its own
_MOST_DRIFT: Final = 10.0  # s; of a crystal with 50 ppm in two days
_REST: Final = 0.02  # s in `_PATIENCE`; the slews of w32time and chrony are faster
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
        self._difference = 0.0  # of date and clock, without the jumps so far: it began as the date
        self._drift = 0.0  # in it, not noted yet
        self._looked: float | None = None
        self._jump: Jump | None = None  # as first seen, not judged yet

    def look(self, now: float, date: float, *, broken: bool) -> Jump | None:
        """Return the jump that is certain by now. `broken`: no values come at present.

        After a sleep, `now` is to have it in it from the next look on.
        """
        elapsed, self._looked = 0.0 if self._looked is None else now - self._looked, now
        most = _DRIFT * max(0.0, elapsed)
        moved = date - now - self._difference
        if abs(moved) < LEAST + most:
            self._jump = None
            return self._drifted(min(max(moved, -most), most), now, date)
        seconds = in_grains(moved)
        if self._jump is None or abs(seconds - self._jump.seconds) >= _REST:
            self._jump = Jump(now, seconds, now + self._difference, date, slept=False)
        slept = broken and 0 < seconds <= _LONGEST_SLEEP
        if not slept and not broken and now - self._jump.time < _PATIENCE:
            return None
        return self._judged(slept=slept)

    def _drifted(self, seconds: float, now: float, date: float) -> Jump | None:
        """Follow a drift of `seconds`; return all of it once it is too much."""
        self._difference += seconds
        self._drift += seconds
        if abs(self._drift) < _MOST_DRIFT:
            return None
        drift = in_grains(self._drift)
        self._drift -= drift
        return Jump(now, drift, date - drift, date, slept=False)

    def conclude(self) -> Jump | None:
        """Return the jump that was not certain yet, at the end of a recording: the date was set.

        Not if it may be a sleep, and was first seen by the latest look: no values came since.
        """
        jump = self._jump
        if jump is None or (jump.time == self._looked and 0 < jump.seconds <= _LONGEST_SLEEP):
            return None
        return self._judged(slept=False)

    def _judged(self, *, slept: bool) -> Jump:
        assert self._jump is not None
        jump, self._jump = self._jump._replace(slept=slept), None
        if not slept:
            self._difference += jump.seconds
        return jump


def in_grains(seconds: float) -> float:
    """Return `seconds` as a correction of a date has them."""
    return round(seconds * GRAIN) / GRAIN
