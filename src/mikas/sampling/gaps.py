"""Gaps: how long no values came, and why. The one rule, for recordings, live data and commands.

A gap begins with a failed cycle, or when the line of a running session breaks. It reaches from the
last values before it to the first after it. Its reason is that of the latest broken state, as first
reported: a pulled adapter is gone, though the next look finds no port. Until there is a broken
state, it is the reason of the first failed cycle. Waiting for a session's first values is no gap.

A pause that somebody wants (another plan, another connection, a job on the line) is a gap if it
lasts longer than values usually take.

The logger `mikas.sampling`, at INFO: states, units, methods, refused parameters, gaps.

Values and single failed cycles are not logged; the frames are, by `mikas.tester` at DEBUG.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Final

from mikas.errors import MikasError
from mikas.i18n import Text
from mikas.sampling.events import (
    CycleFailed,
    Event,
    Gap,
    LineState,
    MethodChosen,
    ParameterDropped,
    Sampled,
    StateChanged,
    UnitFound,
)

_SHORTEST: Final = 1.0  # s without values that are no silence yet, however fast they came
_STEPS: Final = 3  # usual steps that are no silence either
_TOO_OLD: Final = 2  # times a usual silence: the last values are not valid any more
_USUAL: Final = 20  # latest steps; the longest of them is the usual one


@dataclass(frozen=True, slots=True)
class Silence:
    """`seconds` since the last values, 0 while that is usual; `gone`: these values are too old."""

    seconds: float = 0.0
    gone: bool = False


class Arrivals:
    """How long a step from one row of values to the next usually is, by the caller's clock."""

    def __init__(self) -> None:
        self._latest: float | None = None
        self._steps: deque[float] = deque(maxlen=_USUAL)

    def add(self, time: float) -> None:
        """Values came at `time`."""
        if self._latest is not None:
            self._steps.append(time - self._latest)
        self._latest = time

    def interrupt(self) -> None:
        """No values are expected now; how long that lasts is no step."""
        self._latest = None

    @property
    def longest_usual(self) -> float:
        """Seconds without values that are usual."""
        return max(_SHORTEST, _STEPS * max(self._steps, default=0.0))

    def silence(self, now: float) -> Silence:
        """Return the silence at `now`; none before two rows came without interruption."""
        if self._latest is None or not self._steps:
            return Silence()
        seconds, usual = now - self._latest, self.longest_usual
        return Silence(seconds, seconds >= _TOO_OLD * usual) if seconds >= usual else Silence()


class GapTracker:
    """Follows a session's events, or several sessions one after the other.

    Each method returns the gaps that began (`ended` None) or ended with it. `reason_of`: which text
    of an error is a gap's reason.
    """

    def __init__(self, reason_of: Callable[[MikasError], Text] = attrgetter("reason")) -> None:
        self.open: Gap | None = None
        """The gap that has not ended."""
        self._reason_of = reason_of
        self._arrivals = Arrivals()
        self._sampling = False
        self._state: LineState | str | None = (
            None  # of the open gap's reason; None: a failed cycle's
        )
        self._last: float | None = None  # the time of the latest values, or the end of a later gap
        self._pause: Text | None = None  # why somebody wants one
        self._disconnected = False

    def take(self, event: Event) -> list[Gap]:
        """Follow `event`."""
        match event:
            case Sampled():
                return self._sampled(event.time)
            case CycleFailed():
                return self.begin(event.time, self._reason_of(event.error))
            case StateChanged(error=error):
                was_sampling, self._sampling = self._sampling, event.state is LineState.SAMPLING
                if event.is_broken and (was_sampling or self.open):
                    reason = self._reason_of(error) if error else event.text
                    began = self.begin(event.time, reason)
                    assert self.open is not None
                    if event.state is not self._state:
                        self.open = replace(self.open, reason=reason)
                        self._state = event.state
                    return began
        return []

    def begin(self, time: float, reason: Text) -> list[Gap]:
        """Begin a gap, unless one is open: no values come, for `reason`."""
        if self.open is not None:
            return []
        told = []
        if self._disconnected and (told := self._paused(time)):
            self._last = time
        self._pause, self._disconnected = None, False
        self._arrivals.interrupt()
        began = time if self._last is None else min(time, self._last)
        self.open, self._state = Gap(began, began, None, reason), None
        return [*told, self.open]

    def pause(self, reason: Text) -> None:
        """Note why values may stay away for a while; the first of several reasons counts."""
        if self._pause is None:
            self._pause = reason

    def disconnect(self, time: float, reason: Text) -> list[Gap]:
        """End a connection: a gap ends with it, and the next connection's values end the pause."""
        told = []
        self._sampling = False
        self._arrivals.interrupt()
        if self.open is not None:
            told = self._end(time)
            self._last = time
        if not self._disconnected:
            self._pause, self._disconnected = reason, True
        return told

    def restart(self, time: float) -> None:
        """Begin a new recording at `time`: what came before does not count, a gap goes on."""
        self._last = None
        if self.open is not None:
            self.open = replace(self.open, time=time, began=time)

    def silent(self, now: float) -> bool:
        """Return whether the last values are too old at `now`, though a connection is there."""
        if self._last is None or self._disconnected:
            return False
        return now - self._last >= _TOO_OLD * self._arrivals.longest_usual

    @property
    def reason(self) -> Text | None:
        """Why no values come, as far as that is known."""
        return self.open.reason if self.open is not None else self._pause

    def _sampled(self, time: float) -> list[Gap]:
        told = self._end(time) if self.open is not None else self._paused(time)
        if told:
            self._arrivals.interrupt()
        self._arrivals.add(time)
        self._pause, self._disconnected, self._last = None, False, time
        return told

    def _paused(self, time: float) -> list[Gap]:
        """A pause that somebody wanted and that ends at `time`, if it was a long one."""
        if self._pause is None or self._last is None:
            return []
        usual = 0.0 if self._disconnected else self._arrivals.longest_usual
        if time - self._last <= usual:
            return []
        return [Gap(time, self._last, time, self._pause)]

    def _end(self, time: float) -> list[Gap]:
        assert self.open is not None
        ended = max(self.open.began, time)
        gap, self.open = replace(self.open, time=ended, ended=ended), None
        return [gap]


_logger = logging.getLogger("mikas.sampling")
_logger.addHandler(logging.NullHandler())


class EventLogger:
    """Logs one run of a sampler. With the logger off, an event costs one comparison."""

    def __init__(self) -> None:
        self._gaps = GapTracker()

    def take(self, event: Event) -> None:
        """Log `event`, and the gap that begins or ends with it."""
        if not _logger.isEnabledFor(logging.INFO):
            return
        for gap in self._gaps.take(event):
            reason = gap.reason.en if gap.reason else "unknown"
            if gap.ended is None:
                _logger.info("gap began: %s", reason)
            else:
                _logger.info("gap ended after %.1f s: %s", gap.ended - gap.began, reason)
        if not isinstance(event, Sampled):
            self._log(event)

    def _log(self, event: Event) -> None:
        match event:
            case StateChanged(text=text, reason=reason):
                _logger.info("state: %s%s", text.en, f" ({reason.en})" if reason else "")
            case UnitFound(version_code=code, passport=passport, another=another):
                pieces = ", ".join(filter(None, passport.pieces)) if passport else ""
                new = "another unit" if another else "unit"
                _logger.info("%s: version %02X, passport: %s", new, code or 0, pieces or "none")
            case MethodChosen(method=method, rates=rates):
                measured = ", ".join(f"{name} {rate:.1f}/s" for name, rate in rates.items())
                _logger.info("method: %s%s", method, f" (measured: {measured})" if measured else "")
            case ParameterDropped(name=name):
                _logger.info("the unit refuses %s", name)
            case _:
                pass
