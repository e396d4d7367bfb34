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

    `reference`: the time of a packet, None before the first; `doubtful`: the last refused time
    after it. `is_settled`: another packet agrees with `reference`, so it stays. `earliest` and
    `latest`: the first and the last time that the next packet can have.
    """

    reference: float | None = None
    doubtful: float | None = None
    is_settled: bool = False
    earliest: float = -LONGEST
    latest: float = LATEST

    def after_packet(self, time: float) -> tuple[RecordingClock, bool]:
        """Return the clock after a packet of `time`, and whether that time is possible.

        If the first packet's time was the wrong one, the second is refused and decides with the
        third.
        """
        if not self.earliest <= time <= self.latest:
            return self, False
        if self.is_settled:
            return self, True
        if self.reference is None:
            return RecordingClock(time), True
        if _agree(time, self.reference):
            return _settled(self.reference), True
        if self.doubtful is not None and _agree(time, self.doubtful):
            return _settled(time), True
        return RecordingClock(self.reference, doubtful=time), False


def _settled(reference: float) -> RecordingClock:
    earliest, latest = max(-LONGEST, reference - LONGEST), min(LATEST, reference + LONGEST)
    return RecordingClock(reference, is_settled=True, earliest=earliest, latest=latest)


def _agree(one: float, other: float) -> bool:
    return abs(one - other) <= LONGEST
