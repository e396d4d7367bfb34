"""When the stored faults (02) are read while sampling, and when a fault appeared.

MINERR is the lowest stored fault number (§4), and is sampled with the other values: when it changes
the faults are read at once. A fault with a higher number than one that is stored does not change
it, so while any is stored the faults are read every few seconds as well. 02 costs one exchange
(some 15 ms); a running stream has to be ended and started again for it (0.3 s without values, 0.5 s
with a latency timer of 16 ms), so there it is read less often, or not at all.

A unit that refuses 02, or is silent to it, is not asked again until the next connection.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isnan
from typing import Final

from mikas.client import Ecu
from mikas.client.parameters.polling import STREAMS
from mikas.commands import ReadFaults
from mikas.errors import MikasError, NoConnection, NoResponse, NotSupported
from mikas.sampling.events import Event, FaultReading, PlanChanged, Sampled, UnitFound

MINERR: Final = "MINERR"
_PERIOD: Final = 5.0  # s between readings by requests while a fault is stored
IN_STREAMS: Final = 15.0
_MOST_FAILURES: Final = 2  # in a row


class FaultWatch:
    """Says after each event of a session whether the faults are to be read; reads them as a job.

    `in_streams`: seconds between two readings under a stream, None: only when MINERR changes. One
    thread calls `is_due` and `read`.
    """

    def __init__(self, in_streams: float | None = IN_STREAMS) -> None:
        self._in_streams = in_streams
        self._found = False  # its first values may come before its identity
        self._begin_unit()

    def _begin_unit(self) -> None:
        self.latest: FaultReading | None = None
        """The latest reading of this unit."""
        self._lowest: float | None = None  # the latest MINERR
        self._streams = False
        self._tried = -inf
        self._not_before = -inf  # after a failure
        self._waits = False  # a job is queued
        self._failures = 0
        self._changed = True

    @property
    def refused(self) -> bool:
        """Whether the unit refuses to give its faults, or is silent each time."""
        return self._failures >= _MOST_FAILURES

    def is_due(self, event: Event) -> bool:
        """Follow `event`; return whether a job with `read` is to be queued now."""
        match event:
            case UnitFound():
                self._begin_unit()
                self._found = True
            case PlanChanged(plan=plan):
                self._streams = plan.method in STREAMS
                self._lowest = None  # it may not be sampled any more
            case Sampled(fresh=fresh):
                if (reading := fresh.get(MINERR)) is not None:
                    self._follow_lowest(float(reading.value))
            case _:
                return False
        if not self._found or self._waits or self.refused:
            return False
        if event.time < self._not_before or not (self._changed or self._is_late(event.time)):
            return False
        self._waits = True
        return True

    def know(self, reading: FaultReading) -> None:
        """Take a reading that was made for another reason: the change that it shows is read."""
        self._changed, self.latest, self._tried = False, reading, reading.time

    def _follow_lowest(self, lowest: float) -> None:
        """Follow MINERR. A change to what the latest reading has as the lowest is known."""
        known = min(self.latest.codes, default=0) if self.latest else None
        self._changed |= self._lowest not in (None, lowest) and lowest != known
        self._lowest = lowest

    def _is_late(self, now: float) -> bool:
        """Whether a fault may be stored by now that MINERR does not show."""
        period = self._in_streams if self._streams else _PERIOD
        if self.latest is not None and not self.latest.codes and self._lowest == 0:
            return False  # nothing is stored, so the first fault changes MINERR
        return period is not None and now - self._tried >= period

    def read(self, ecu: Ecu, *, routine: bool = True) -> FaultReading | None:
        """Read the faults, by one attempt; a job between two cycles. None: the unit gave none.

        `routine`: as of `FaultReading`. Raises a `NoConnection`.
        """
        self._waits = False
        self._tried = ecu.tester.link.now()
        try:
            codes, _ = ecu.tester.exchange(ReadFaults(), retries=0, trial=True)
        except NoConnection:
            raise
        except MikasError as error:
            self._failures += isinstance(error, NotSupported | NoResponse)
            self._changed, self._not_before = True, self._tried + _PERIOD
        else:
            self._failures = 0
            self._changed = False
            self.latest = FaultReading(ecu.tester.link.now(), tuple(codes), routine=routine)
            return self.latest
        return None


def appeared(
    code: int,
    before: float,
    read: float,
    times: Sequence[float],
    lowest: Sequence[float],
) -> tuple[float, float]:
    """Return the times between which the fault `code` was stored: the last without, the first with.

    `before`, `read`: of the last reading without the fault and the first with it. `times` and
    `lowest`: rows and their MINERR (NaN: none). MINERR narrows it down where it becomes `code`: the
    lowest stored number was another, or none, in the row before. One that was lower hides it.
    """
    without = before
    for time, value in zip(times, lowest, strict=True):
        if isnan(value) or not before <= time <= read:
            continue
        if value == code:
            return without, time
        if value == 0 or value > code:
            without = time
    return without, read
