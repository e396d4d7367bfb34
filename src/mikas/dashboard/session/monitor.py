"""The state of the running connection: set by the sampling thread, read by the event loop.

Each event updates the state (unit, method, alarms, counts) and is gathered for the clients'
messages (`drain`), with the rows that the history has got since the message before.
"""

from __future__ import annotations

import threading
from array import array
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import nan
from typing import Final

from mikas.catalog import Level
from mikas.catalog.ignition_only import SPEED, WITNESSES, InjectionWatch
from mikas.client import Reading
from mikas.client.parameters.derived import DerivedValue
from mikas.dashboard.session.history import EventLog, ExchangeFailed, History, reason_of
from mikas.errors import EcuRefused, LineError, MikasError, NoConnection
from mikas.i18n import Text
from mikas.instruments.reading import InstrumentReading
from mikas.sampling import events
from mikas.sampling.session import SamplingSession
from mikas.tester import Failure

DISCONNECTED: Final = Text(
    "The connection was closed by the user.", "Соединение закрыто пользователем."
)
OTHER_PLAN: Final = Text("The sampling plan was changed.", "План опроса изменён.")
SILENT: Final = Text(
    "No values for two seconds. If the unit does not answer soon: is the ignition on, is the "
    "adapter plugged in?",
    "Уже две секунды нет данных. Если блок скоро не ответит: включено ли зажигание, подключён ли "
    "адаптер?",
)

_RATE_SPAN = _LOAD_SPAN = 3.0  # s
_MINUTE: Final = 60.0
_BITS_PER_BYTE: Final = 10  # §1
_ERRORS: Final = 1000  # remembered, so that each is logged once; more than a tester remembers
_ROWS: Final = 20_000  # gathered at most; more come only from a simulated clock

_WATCHED: Final = (SPEED, *WITNESSES)
_NOTHING: Final[tuple[str, frozenset[str]]] = ("", frozenset())


@dataclass(slots=True)
class Batch:
    """What came since the last one. `columns`: over `times`, by channel in the plan's order."""

    times: array[float]
    columns: Mapping[str, array[float]]
    events: Sequence[events.Event]


class Meters:
    """Rates of the line by the link's clock; the caller holds the monitor's lock."""

    def __init__(self) -> None:
        self.errors: int = 0
        self._times: deque[float] = deque()
        self._wire: deque[tuple[float, int]] = deque()
        self._errors: deque[float] = deque(maxlen=10_000)

    def sample(self, time: float) -> None:
        """Take the time of one sample."""
        self._times.append(time)
        while self._times[0] < time - _RATE_SPAN:
            self._times.popleft()

    def error(self, time: float) -> None:
        """Count one failed exchange."""
        self.errors += 1
        self._errors.append(time)

    def wire(self, time: float, total: int) -> None:
        """Note that `total` bytes have passed on the wire so far."""
        if not self._wire or time - self._wire[-1][0] >= 0.2:
            self._wire.append((time, total))
        while len(self._wire) > 2 and self._wire[1][0] < time - _LOAD_SPAN:
            self._wire.popleft()

    def rate(self, now: float) -> float:
        """Return samples a second; 0 without any in the last seconds."""
        times = self._times
        while times and times[0] < now - _RATE_SPAN:
            times.popleft()
        if len(times) < 2:
            return 0.0
        seconds = max(times[-1] - times[0], now - times[0] - 1.0)
        return (len(times) - 1) / seconds if seconds > 0 else 0.0

    def load(self, baud: int) -> float:
        """Return the share of time in which the wire carries bytes."""
        if len(self._wire) < 2:
            return 0.0
        (began, before), (ended, after) = self._wire[0], self._wire[-1]
        if ended <= began:
            return 0.0
        return min(1.0, (after - before) * _BITS_PER_BYTE / baud / (ended - began))

    def errors_minute(self, now: float) -> int:
        """Return the failed exchanges of the last minute."""
        while self._errors and self._errors[0] < now - _MINUTE:
            self._errors.popleft()
        return len(self._errors)


class ConnectionMonitor:
    """Follows one connection after the other. `lock` guards all of it, the meters too."""

    def __init__(self, history: History, session: SamplingSession) -> None:
        self.lock: threading.RLock = threading.RLock()
        self.history = history
        self.session = session
        self.listened = False
        self._waiting: Callable[[], object] | None = None
        self._log = EventLog()
        self._events: list[events.Event] = []
        self._drained = history.count  # rows
        self._wanted: tuple[str, ...] = ()
        self._beside: tuple[str, ...] = ()
        self.begin((), 0.0)

    def begin(self, names: Iterable[str], time: float) -> None:
        """Begin a new connection with an empty state."""
        with self.lock:
            self.line: events.LineState | None = None
            self.error: MikasError | None = None
            self.since: float = time
            self.unit: events.UnitFound | None = None
            self.method: str | None = None
            self.rates: dict[str, float] = {}
            self.dropped: list[str] = []
            self.alarms: dict[str, events.AlarmChanged] = {}
            self.alarm_count: int = 0
            self.latest: dict[str, Reading | DerivedValue | InstrumentReading] = {}
            self.injection: InjectionWatch = InjectionWatch()
            """Whether the unit of this connection controls the ignition alone."""
            self.meters: Meters = Meters()
            self._awaited = _NOTHING
            self._searched = False  # for a port or a unit, since the last values
            self._errors: deque[tuple[str, float | None, bytes | None]] = deque(maxlen=_ERRORS)
            self._newest: Failure | None = None
            self.set_names(names)

    def set_names(self, names: Iterable[str]) -> None:
        """Take the wanted channels, in their order: the columns from here on."""
        with self.lock:
            self._wanted = tuple(names)

    def set_beside(self, names: Iterable[str]) -> None:
        """Take the channels of the instruments beside the unit: further columns from here on."""
        with self.lock:
            for name in self._beside:
                self.latest.pop(name, None)
                self.alarms.pop(name, None)
            self._beside = tuple(names)

    @property
    def _names(self) -> tuple[str, ...]:
        """The columns."""
        return self._wanted + self._beside

    def await_catalog(self, version: str, changed: Iterable[str]) -> None:
        """Drop the values of the `changed` channels until the sampler uses that catalog."""
        with self.lock:
            self._awaited = version, frozenset(changed)
            for name in self._awaited[1]:
                self.latest.pop(name, None)

    @property
    def shown_alarms(self) -> list[events.AlarmChanged]:
        """The alarms of the wanted channels, while the unit answers. The others stay in `alarms`:
        no event repeats an unchanged alarm when its channel is read again.
        """
        if self.line not in (events.LineState.SAMPLING, events.LineState.ECU_ALIVE):
            return []  # an unplugged adapter: the values are unknown, and so are their alarms
        return [alarm for name, alarm in self.alarms.items() if name in self._names]

    def silent(self, now: float) -> Text | None:
        """Return why expected values are missing for some seconds; None: they are not."""
        if self.line is not events.LineState.SAMPLING or (gap := self.session.silence(now)) is None:
            return None
        return reason_of(gap) or SILENT

    def wait(self, wake: Callable[[], object]) -> bool:
        """Return whether nothing is gathered; if so, `wake` is called once when that changes."""
        with self.lock:
            nothing = not self._events and self._drained == self.history.count
            self._waiting = wake if nothing else None
            return nothing

    def wake(self) -> None:
        """Wake the waiting caller of `wait`."""
        with self.lock:
            waiting, self._waiting = self._waiting, None
        if waiting is not None:
            waiting()

    def drain(self) -> Batch:
        """Return what was gathered since the last call."""
        with self.lock:
            gathered, self._events = self._events, []
            first, self._drained = self._drained, self.history.count
            last = min(self._drained, first + _ROWS)
            return Batch(*self.history.added(first, last, self._names), gathered)

    @property
    def logged(self) -> list[events.Event]:
        """The logged events, in their order."""
        with self.lock:
            return self._log.all

    def log(self, event: events.Event) -> None:
        """Log an event, and gather it for the clients."""
        with self.lock:
            self._log.add(event)
            if self.listened:
                self._events.append(event)
                self.wake()

    def add_event(self, event: events.Event) -> None:
        """Take an event of the session."""
        with self.lock:
            match event:
                case events.Sampled():
                    self._sampled(event)
                case events.CycleFailed():
                    self._failed(event)
                case events.StateChanged(state=events.LineState() as state):
                    self.line, self.since, self.error = state, event.time, event.error
                    self.log(event)
                case events.AlarmChanged():
                    self._alarm(event)
                case events.MethodChosen():
                    self.method = event.method
                    self.rates = {name: round(rate, 2) for name, rate in event.rates.items()}
                    self.log(event)
                case events.AdapterMoved() | events.ClockChanged() | events.Gap():
                    self.log(event)
                case events.ParameterDropped() | events.ParameterReturned():
                    self._dropped(event)
                case events.UnitFound():
                    self._found(event)
                case events.PlanChanged():
                    if event.catalog == self._awaited[0]:
                        self._awaited = _NOTHING
                    self.method = event.plan.method
                    self.session.pause(OTHER_PLAN)

    def end_connection(
        self, time: float, error: MikasError | None, why: Text = DISCONNECTED
    ) -> None:
        """End the connection: by itself, because of `error`, or for the reason `why`."""
        # Not under the lock: the recorder gets these gaps, and logs its files here.
        gaps = self.session.leave(time, error.reason if error else why, error)
        with self.lock:
            self.line, self.since, self.error = None, time, error
            self.alarms.clear()
            for gap in gaps:
                self.log(gap)

    def count_failures(self, failures: Sequence[Failure], now: float) -> None:
        """Log the new ones of the tester's latest `failures`, also those cured by a repetition."""
        if failures and failures[-1] is not self._newest:
            with self.lock:
                self._newest = failures[-1]
                for failure in failures:
                    if self._is_new(failure):
                        time = now if failure.time is None else failure.time
                        self._log_error(ExchangeFailed.of(time, failure))

    def _sampled(self, event: events.Sampled) -> None:
        values: dict[str, Reading | DerivedValue | InstrumentReading] = {
            **event.fresh, **event.derived, **event.instruments
        }  # fmt: skip
        for outdated in self._awaited[1]:
            values.pop(outdated, None)
        self.meters.sample(event.time)
        for name in self._beside:  # an instrument's value that is too old is none
            self.latest.pop(name, None)
        self.latest.update(values)
        fresh = event.fresh
        self.injection.add_row(
            {name: float(fresh[name].value) for name in _WATCHED if name in fresh}
        )
        names = self._names
        row = [values[name].value if name in values else nan for name in names]
        self.history.add(event.time, names, row)
        self._searched = False
        if self.listened:
            self.wake()
        else:
            self._drained = self.history.count

    def _failed(self, event: events.CycleFailed) -> None:
        # Each attempt to find a port or unit again fails alike: that is the gap, not more errors.
        no_unit = isinstance(event.error, NoConnection)
        if not (no_unit and self._searched):
            cause = event.error.__cause__  # of a verdict on exchanges, which the tester counted
            counted_as = cause if isinstance(cause, LineError) else event.error
            if self._is_new(counted_as):
                failed = ExchangeFailed.of(event.time, event.error)
                # A refusal is an answer, even if it is silence: the line is not at fault.
                log = self.log if isinstance(event.error, EcuRefused) else self._log_error
                log(failed)
        self._searched |= no_unit

    def _is_new(self, error: MikasError | Failure) -> bool:
        """Return whether `error` is not logged yet: from the tester, or from a failed cycle."""
        code = error.code if isinstance(error, Failure) else type(error).__name__
        known = (code, error.time, error.received)
        new = error.time is None or known not in self._errors
        self._errors.append(known)
        return new

    def _log_error(self, event: ExchangeFailed) -> None:
        self.meters.error(event.time)
        self.log(event)

    def _alarm(self, event: events.AlarmChanged) -> None:
        if event.level == Level.NONE:
            self.alarms.pop(event.name, None)
        else:
            if event.name not in self.alarms:
                self.alarm_count += 1
            self.alarms[event.name] = event
        self.log(event)

    def _dropped(self, event: events.ParameterDropped | events.ParameterReturned) -> None:
        is_dropped = isinstance(event, events.ParameterDropped)
        if is_dropped is (event.name in self.dropped):
            return
        if is_dropped:
            self.dropped.append(event.name)
        else:
            self.dropped.remove(event.name)
        self.log(event)

    def _found(self, event: events.UnitFound) -> None:
        self.unit = event
        if event.another:
            self.dropped.clear()
            self.alarms.clear()
            self.latest.clear()  # of another car
            self.rates, self.method = {}, None
            self.injection = InjectionWatch()
        self.log(event)
