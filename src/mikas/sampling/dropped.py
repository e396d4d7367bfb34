"""When a dropped parameter is requested again, which may have been dropped by mistake (D10).

One at a time, as a silent one takes a second: after a reconnection, when values are missing anyway,
each in turn. One that was read before is also requested after a minute, then after two, four, …
So a parameter that a unit never had costs nothing while the connection lasts.
"""

from __future__ import annotations

from collections import Counter
from math import inf

from mikas.commands import Datum

_PAUSE = 60.0  # s; doubled after each request in vain


class DroppedParameters:
    """The turns of the data in `refused`, the set of all that are dropped."""

    def __init__(self, refused: set[Datum]) -> None:
        self._refused = refused
        self._read_before: set[Datum] = set()
        self._requests: Counter[Datum] = Counter()
        self._reconnected = False
        self._due, self._pause = inf, _PAUSE

    def add(self, datum: Datum, now: float, *, read_before: bool) -> None:
        """Note that `datum` is dropped."""
        if read_before:
            self._read_before.add(datum)
            self._due, self._pause = now + _PAUSE, _PAUSE

    def reconnected(self) -> None:
        """Note that the unit answers again."""
        self._reconnected = True

    def is_due(self, now: float) -> bool:
        """Whether one is to be requested again, during a connection."""
        return now >= self._due

    def next(self, now: float) -> Datum | None:
        """Return the one to request again now; None: none."""
        if self._reconnected:
            waiting = self._refused
        elif self.is_due(now):
            waiting = self._refused & self._read_before
        else:
            return None
        self._reconnected = False
        if self._due < inf:
            self._due = now + self._pause if self._refused & self._read_before else inf
            self._pause *= 2
        if not waiting:
            return None
        datum = min(waiting, key=self._turn)
        self._requests[datum] += 1
        return datum

    def _turn(self, datum: Datum) -> tuple[int, bool, int]:
        return self._requests[datum], datum not in self._read_before, datum.code
