"""Gaps in the values, with length and reason; `SamplingSession` follows them for all consumers.

A gap begins with a failed cycle, or when the line of a running session breaks, and lasts from the
last values before to the first after. Its reason is that of the latest broken state, as first
reported (an unplugged adapter, not the port missing at the next attempt), else that of the first
failed cycle. The time before the first values of a session is no gap.

A requested pause (another plan, another connection, a job on the line) is a gap if it is longer
than the usual time without values.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

from mikas.errors import MikasError
from mikas.i18n import Text
from mikas.sampling.events import CycleFailed, Event, Gap, LineState, Sampled, StateChanged

_SHORTEST: Final = 1.0  # s without values: never a silence, however fast they come
_STEPS: Final = 3  # usual steps without values: no silence
_TOO_OLD: Final = 2  # times the longest usual time without values: the values are invalid
_USUAL: Final = 20  # latest steps; the longest of them is the usual one

_Reason: TypeAlias = tuple[Text, MikasError | None]


@dataclass(frozen=True, slots=True)
class Silence:
    """`seconds` since the last values, 0 while usual; `gone`: the last values are too old."""

    seconds: float = 0.0
    gone: bool = False


class Arrivals:
    """The usual time from one row of values to the next, by the caller's clock."""

    def __init__(self) -> None:
        self._latest: float | None = None
        self._steps: deque[float] = deque(maxlen=_USUAL)

    def add(self, time: float) -> None:
        """Add a row of values at `time`."""
        if self._latest is not None:
            self._steps.append(time - self._latest)
        self._latest = time

    def interrupt(self) -> None:
        """Expect no values; the time until the next row is no step."""
        self._latest = None

    @property
    def longest_usual(self) -> float:
        """The longest usual time without values, in seconds."""
        return max(_SHORTEST, _STEPS * max(self._steps, default=0.0))

    def silence(self, now: float) -> Silence:
        """Return the silence at `now`; none before two rows without interruption."""
        if self._latest is None or not self._steps:
            return Silence()
        seconds, usual = now - self._latest, self.longest_usual
        return Silence(seconds, seconds >= _TOO_OLD * usual) if seconds >= usual else Silence()


class GapTracker:
    """Follows the events of one session, or of several in a row.

    Each method returns the gaps that begin (`ended` None) or end.
    """

    def __init__(self) -> None:
        self.open: Gap | None = None
        """The present gap."""
        self._arrivals = Arrivals()
        self._sampling = False
        # Of the open gap's reason; None: a failed cycle's.
        self._state: LineState | str | None = None
        self._last: float | None = None  # the latest values, or the end of a later gap
        self._pause: _Reason | None = None  # of the requested pause
        self._disconnected = False
        self._slept = False  # in the open gap

    def gaps_of(self, event: Event) -> list[Gap]:
        """Follow `event`."""
        match event:
            case Sampled():
                return self._sampled(event.time)
            case CycleFailed(error=error):
                return self._begin(event.time, error.reason, error)
            case StateChanged(error=error):
                was_sampling, self._sampling = self._sampling, event.state is LineState.SAMPLING
                if event.is_broken and (was_sampling or self.open):
                    reason = event.reason or event.text
                    began = self._begin(event.time, reason, error)
                    assert self.open is not None
                    if event.state is not self._state and not self._slept:
                        self.open = replace(self.open, reason=reason, error=error)
                        self._state = event.state
                    return began
        return []

    def pause(self, reason: Text) -> None:
        """Begin a requested pause; the first of several reasons counts."""
        if self._pause is None:
            self._pause = reason, None

    def slept(self, reason: Text) -> None:
        """Let the present gap be a sleep of the computer, or else the time until the next values.

        The states after it are none of its reasons.
        """
        if self.open is None:
            self.pause(reason)
        else:
            self.open, self._slept = replace(self.open, reason=reason, error=None), True

    def disconnect(self, time: float, reason: Text, error: MikasError | None = None) -> list[Gap]:
        """End a connection and its gap; a pause lasts until the next connection's values."""
        gaps = []
        self._sampling = False
        self._arrivals.interrupt()
        if self.open is not None:
            gaps = self._end(time)
            self._last = time
        if not self._disconnected:
            self._pause, self._disconnected = (reason, error), True
        return gaps

    def silence(self, now: float) -> Gap | None:
        """Return the present gap if the last values are too old at `now` while connected."""
        if self._last is None or self._disconnected:
            return None
        if now - self._last < _TOO_OLD * self._arrivals.longest_usual:
            return None
        return self.open or Gap(now, self._last, None, *(self._pause or (None, None)))

    def _begin(self, time: float, reason: Text, error: MikasError | None) -> list[Gap]:
        """Begin a gap by `reason`, unless one is open."""
        if self.open is not None:
            return []
        gaps = []
        if self._disconnected and (gaps := self._paused(time)):
            self._last = time
        self._pause, self._disconnected = None, False
        self._arrivals.interrupt()
        began = time if self._last is None else min(time, self._last)
        self.open, self._state = Gap(began, began, None, reason, error), None
        self._slept = False
        return [*gaps, self.open]

    def _sampled(self, time: float) -> list[Gap]:
        gaps = self._end(time) if self.open is not None else self._paused(time)
        if gaps:
            self._arrivals.interrupt()
        self._arrivals.add(time)
        self._pause, self._disconnected, self._last = None, False, time
        return gaps

    def _paused(self, time: float) -> list[Gap]:
        """Return the requested pause that ends at `time`, if it was long enough for a gap."""
        if self._pause is None or self._last is None:
            return []
        usual = 0.0 if self._disconnected else self._arrivals.longest_usual
        if time - self._last <= usual:
            return []
        return [Gap(time, self._last, time, *self._pause)]

    def _end(self, time: float) -> list[Gap]:
        assert self.open is not None
        ended = max(self.open.began, time)
        gap, self.open = replace(self.open, time=ended, ended=ended), None
        return [gap]
