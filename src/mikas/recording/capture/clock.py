"""The times that the packets of one port can have in a recording.

A stamp is 64 bits of the file: damaged, or made by somebody, it is any time at all. A time without
a date, or lifetimes from the other packets, is refused where it is read, so nothing after the
reader meets a span that no recording has. A clock that was set, and a laptop that slept, are usual:
jumps within `LONGEST` stay.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from mikas.cleaning import LATEST

# Seconds: a hundred years. A computer whose clock has no battery begins in 1970 and is set to today
# in the middle of a recording: all of its packets stay.
LONGEST: Final = 100 * 365.25 * 86400


class RecordingClock(NamedTuple):
    """The clock of one port in one recording, after some of its packets.

    `reference`: the time of a packet, None before the first; `is_settled`: another packet agrees
    with it, so it stays. `doubtful`: the last refused time before that.
    """

    reference: float | None = None
    is_settled: bool = False
    doubtful: float | None = None

    @property
    def limits(self) -> tuple[float, float]:
        """The first and the last time that the next packet can have."""
        if self.reference is None or not self.is_settled:
            return -LONGEST, LATEST
        return max(-LONGEST, self.reference - LONGEST), min(LATEST, self.reference + LONGEST)

    def take(self, time: float) -> tuple[RecordingClock, bool]:
        """Return the clock after a packet of `time`, and whether that time is possible.

        If the first packet's time was the wrong one, the second is refused and decides with the
        third.
        """
        first, last = self.limits
        if not first <= time <= last:
            return self, False
        if self.reference is None:
            return RecordingClock(time), True
        if self.is_settled:
            return self, True
        if _agree(time, self.reference):
            return RecordingClock(self.reference, is_settled=True), True
        if self.doubtful is not None and _agree(time, self.doubtful):
            return RecordingClock(time, is_settled=True), True
        return RecordingClock(self.reference, doubtful=time), False


def _agree(one: float, other: float) -> bool:
    return abs(one - other) <= LONGEST
