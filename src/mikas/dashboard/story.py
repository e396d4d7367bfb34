"""What is known of the running connection: told by the sampling thread, asked by the event loop.

Two things come of each event: what is now so (state, unit, method, alarms, counts), and what is to
be passed on to those who look: rows of values and happenings, gathered until they are drained.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite

from mikas.catalog import Catalog, Level
from mikas.dashboard import happenings
from mikas.dashboard.advice import ADVICE
from mikas.dashboard.gaps import BY_HAND, JOB, PLAN, Gaps
from mikas.dashboard.happenings import Happening, Kept
from mikas.dashboard.history import History, row_of
from mikas.dashboard.session.meters import Meters
from mikas.errors import EcuRefused, LineError, MikasError, NoConnection
from mikas.i18n import Text
from mikas.sampling.alarms import AlarmChanged
from mikas.sampling.events import (
    CycleFailed,
    Event,
    LineState,
    MethodChosen,
    ParameterDropped,
    PlanChanged,
    Sampled,
    StateChanged,
    UnitFound,
)
from mikas.tester.statistics import Failure

_ERRORS = 1000  # remembered, to be told once; more than a tester remembers
_ROWS = 20_000  # gathered at most; more come only from a simulated clock

Row = tuple[float, Mapping[str, float]]


@dataclass(slots=True)
class Batch:
    """What came since the last one. `names`: the columns of `rows`, in the plan's order."""

    names: tuple[str, ...] = ()
    rows: list[Row] = field(default_factory=list)
    happenings: list[Happening] = field(default_factory=list)


class Story:
    """Follows one connection after the other. `lock` guards all of it, the meters too."""

    def __init__(self, catalog: Catalog, history: History) -> None:
        self.lock = threading.RLock()
        self.catalog = catalog
        self.history = history
        self.listened = False
        self._waiting: Callable[[], object] | None = None
        self._kept = Kept()
        self._batch = Batch()
        self._names: tuple[str, ...] = ()
        self._gaps = Gaps(self.tell)
        self.begin((), 0.0)

    def begin(self, names: Iterable[str], time: float) -> None:
        """A new connection: nothing is known of it."""
        with self.lock:
            self.line: LineState | None = None
            self.reason: Text | None = None
            self.reason_code: str | None = None
            self.since = time
            self.unit: UnitFound | None = None
            self.model: Text | None = None
            self.method: str | None = None
            self.rates: dict[str, float] = {}
            self.dropped: list[str] = []
            self.alarms: dict[str, AlarmChanged] = {}
            self.alarm_count = 0
            self.latest: dict[str, float] = {}
            self.meters = Meters()
            self._waited = False  # for a port or a unit, since the last values
            self._errors: deque[tuple[str, float | None, bytes | None]] = deque(maxlen=_ERRORS)
            self._newest: Failure | None = None
            self.names_are(names)

    def names_are(self, names: Iterable[str]) -> None:
        """The channels asked for, in their order: the columns from here on."""
        with self.lock:
            self._names = tuple(names)

    @property
    def alarms_seen(self) -> list[AlarmChanged]:
        """Of the channels asked for. The others' are kept: if they still are so when they are asked
        for again, nothing changed, and no event would tell.
        """
        return [it for name, it in self.alarms.items() if name in self._names]

    def silent(self, now: float) -> Text | None:
        """Why nothing has come for some seconds, though values should; None: all is well."""
        return self._gaps.silent(now) if self.line is LineState.SAMPLING else None

    def wait(self, wake: Callable[[], object]) -> bool:
        """Whether nothing has been gathered yet; then `wake` is called once when that changes."""
        with self.lock:
            nothing = not (self._batch.rows or self._batch.happenings)
            self._waiting = wake if nothing else None
            return nothing

    def stir(self) -> None:
        """Wakes who waits."""
        with self.lock:
            waiting, self._waiting = self._waiting, None
        if waiting is not None:
            waiting()

    def drain(self) -> Batch:
        """What came since the last call."""
        with self.lock:
            batch, self._batch = self._batch, Batch()
            batch.names = self._names
            return batch

    @property
    def events(self) -> list[Happening]:
        """What happened, in the order in which it was told."""
        with self.lock:
            return self._kept.all

    def tell(self, happening: Happening) -> None:
        """Something that happened beside the sampling."""
        with self.lock:
            self._kept.add(happening)
            if self.listened:
                self._batch.happenings.append(happening)
                self.stir()

    def take(self, event: Event | AlarmChanged) -> None:
        """What the sampler tells."""
        with self.lock:
            match event:
                case Sampled():
                    self._came(event)
                case CycleFailed():
                    self._failed(event)
                case StateChanged():
                    self._changed(event)
                case AlarmChanged():
                    self._alarm(event)
                case MethodChosen():
                    self.method = event.method
                    self.rates = {name: round(rate, 2) for name, rate in event.rates.items()}
                    self.tell(happenings.method(event))
                case ParameterDropped():
                    if event.name not in self.dropped:
                        self.dropped.append(event.name)
                        self.tell(happenings.dropped(event))
                case UnitFound():
                    self._found(event)
                case PlanChanged():
                    self.method = event.plan.method
                    self._gaps.pause(PLAN)

    def busy(self) -> None:
        """A request of somebody's has the line now."""
        with self.lock:
            self._gaps.pause(JOB)

    def over(self, time: float, error: MikasError | None, why: Text = BY_HAND) -> None:
        """The connection has ended; `error` if it did so by itself, else `why`."""
        with self.lock:
            self.line, self.since = None, time
            self._because(error)
            self.alarms.clear()
            self._gaps.part(time, ADVICE.text(error) if error else why)

    def _came(self, event: Sampled) -> None:
        values = {name: float(reading.value) for name, reading in event.fresh.items()}
        for name, derived in event.derived.items():
            if isfinite(derived.value):
                values[name] = derived.value
        self.meters.sample(event.time)
        self.latest.update(values)
        self.history.add(event.time, self._names, row_of(self._names, values))
        self._gaps.came(event.time)
        self._waited = False
        if self.listened and len(self._batch.rows) < _ROWS:
            self._batch.rows.append((event.time, values))
            self.stir()

    def spoilt(self, failures: Sequence[Failure], now: float) -> None:
        """`failures`: the latest of the tester, those that a repetition cured included."""
        if failures and failures[-1] is not self._newest:
            with self.lock:
                self._newest = failures[-1]
                for failure in failures:
                    if self._is_news(failure):
                        self._error(happenings.failure(failure, now))

    def _failed(self, event: CycleFailed) -> None:
        self._gaps.lost(event.time, ADVICE.text(event.error))
        # Each attempt to find a port or unit again fails alike: that is the gap, no more errors.
        nobody = isinstance(event.error, NoConnection)
        if not (nobody and self._waited):
            cause = event.error.__cause__  # of a verdict on exchanges, which the tester told
            told_as = cause if isinstance(cause, LineError) else event.error
            if self._is_news(told_as):
                told = happenings.error(event.time, event.error)
                # A refusal is an answer, even if it is silence: nothing is wrong with the line.
                tell = self.tell if isinstance(event.error, EcuRefused) else self._error
                tell(told)
        self._waited |= nobody

    def _is_news(self, error: MikasError | Failure) -> bool:
        """Whether it was not told yet: by the tester, or by a cycle that it ended."""
        code = error.code if isinstance(error, Failure) else type(error).__name__
        known = (code, error.time, error.received)
        news = error.time is None or known not in self._errors
        self._errors.append(known)
        return news

    def _error(self, happening: Happening) -> None:
        self.meters.error(happening["time"])
        self.tell(happening)

    def _changed(self, event: StateChanged) -> None:
        if event.error is not None:
            if self.line is LineState.SAMPLING:
                self._gaps.lost(event.time, ADVICE.text(event.error))
            self._gaps.because(ADVICE.text(event.error))
        self.line, self.since = event.state, event.time
        self._because(event.error)
        self.tell(happenings.state(event))

    def _because(self, error: MikasError | None) -> None:
        self.reason = ADVICE.text(error) if error else None
        self.reason_code = type(error).__name__ if error else None

    def _alarm(self, event: AlarmChanged) -> None:
        if event.level is Level.NONE:
            self.alarms.pop(event.channel.name, None)
        else:
            if event.channel.name not in self.alarms:
                self.alarm_count += 1
            self.alarms[event.channel.name] = event
        self.tell(happenings.alarm(event))

    def _found(self, event: UnitFound) -> None:
        self.unit = event
        self.model = self.catalog.model(event.version_code).text
        if event.another:
            self.dropped.clear()
            self.alarms.clear()
            self.rates, self.method = {}, None
        self.tell(happenings.unit(event, self.model))
