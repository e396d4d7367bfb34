"""One session: the acquisition's events, and those that follow from several of them.

    Acquisition ── events ──► SamplingSession ──► the recorder, then the consumer
                ◄── jobs ───  gaps, stored faults, another unit, counts

Commands, the dashboard and recordings only match the events: gaps, whether another unit answers,
when the faults are read, and what the computer's date does is decided here alone. A session has one
connection after the other; a gap may last from one to the next.
"""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Future
from contextlib import closing
from functools import partial

from mikas.client import Ecu
from mikas.client.identity import UnitIdentity
from mikas.errors import MikasError
from mikas.i18n import Text
from mikas.sampling import events
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.date_watch import DateWatch, Jump
from mikas.sampling.fault_watch import IN_STREAMS, FaultWatch
from mikas.sampling.gaps import GapTracker

_logger = logging.getLogger("mikas.sampling")
_logger.addHandler(logging.NullHandler())


class SamplingSession:
    """`record`: takes each event before the consumer, a recorder's method; an open gap comes again
    when another reason is found. `in_streams`: as of `FaultWatch`. `on_faults`: gets each reading
    at once, in its job; without it a reading is recorded in its job, and yielded before the next
    event.

    One thread takes the events; any thread may call `silence`, `read_now` and `conclude`.
    """

    def __init__(
        self,
        record: Callable[[events.Event], object] = lambda _: None,
        *,
        in_streams: float | None = IN_STREAMS,
        on_faults: Callable[[events.FaultReading], None] | None = None,
    ) -> None:
        self.unit: UnitIdentity | None = None
        """The unit found last, on any connection: `before` of the next acquisition."""
        self.unit_port: str = ""
        """The URL at which that unit was found."""
        self.samples: int = 0
        """Of the present connection, or the last one."""
        self.wants_faults: Callable[[], bool] = lambda: True
        """Whether the stored faults are read when they may have changed."""
        self.record = record
        """To be set before the first event."""
        self.later: float = 0.0
        """The seconds that the date is later than the link's clock, as far as it was set since."""
        self._acquisition: Acquisition | None = None
        self._answers = False  # a unit, on the present connection
        self._on_faults = on_faults or self._keep
        self.faults: FaultWatch = FaultWatch(in_streams)
        """Knows the readings that it did not make by `know`, in the sampling thread."""
        self._made: deque[events.Event] = deque()  # by jobs, to be yielded
        self._dates = DateWatch()
        self._sleep: tuple[Jump, Future[None]] | None = None  # to be added between two cycles
        self._gaps = GapTracker()
        self._open: events.Gap | None = None  # as the recorder has it
        self._lock = threading.Lock()  # of the tracker and the dates

    def run(self, acquisition: Acquisition) -> Generator[events.Event, None, None]:
        """Yield the events of a connection, recorded before. Raises as `Acquisition.run`."""
        self.begin(acquisition)
        with closing(acquisition.run()) as found:
            for event in found:
                yield from self.events_of(event)

    def begin(self, acquisition: Acquisition) -> None:
        """Begin a connection: `acquisition` gives the events for `events_of` from here on."""
        self._acquisition, self.samples, self._answers = acquisition, 0, False

    def events_of(self, event: events.Event) -> Iterator[events.Event]:
        """Yield the events before `event` that it completes, and `event`; to be exhausted.

        All are recorded before the first is yielded. Afterwards the faults are read, if due.
        """
        if isinstance(event, events.Sampled):
            self.samples += 1
        else:
            log(event)
        if isinstance(event, events.StateChanged):
            self._answers = not event.is_broken
        elif isinstance(event, events.UnitFound):
            self.unit = event.identity
            if self._acquisition is not None:
                self.unit_port = self._acquisition.port.url
                self._acquisition.port.wire.echoes = event.echo is not False
        with self._lock:
            gaps = self._gaps.gaps_of(event)
        if gaps or self._gaps.open is not self._open:
            self._record(gaps)
        self.record(event)
        if self._made:
            yield from self.readings()
        yield from gaps
        yield event
        yield from self._follow_date(broken=bool(gaps) or not self._answers)
        if self._acquisition is not None and self.wants_faults() and self.faults.is_due(event):
            self._read(routine=True)

    @property
    def wire_bytes(self) -> int:
        """The bytes on the wire of the present connection, or the last one."""
        return 0 if self._acquisition is None else self._acquisition.port.wire.bytes

    def leave(self, time: float, reason: Text, error: MikasError | None = None) -> list[events.Gap]:
        """End a connection, by `error` or for `reason`; return the gap that ends with it.

        The time until the values of the next connection is a gap for that reason.
        """
        self._answers = False
        with self._lock:
            gaps = self._gaps.disconnect(time, reason, error)
        self._record(gaps)
        return gaps

    def pause(self, reason: Text) -> None:
        """Let the time until the next values be a gap for `reason`, if it gets long."""
        with self._lock:
            self._gaps.pause(reason)

    def silence(self, now: float) -> events.Gap | None:
        """Return the present gap if the last values are too old at `now` while connected.

        Its reason is None if it is not known yet.
        """
        with self._lock:
            return self._gaps.silence(now)

    # The computer's date

    def _follow_date(self, *, broken: bool) -> Iterator[events.ClockChanged]:
        """Yield the change of the clock that is certain by now; `broken`: no values come."""
        if self._acquisition is None:
            return
        port = self._acquisition.port
        if self._sleep is not None:
            jump, added = self._sleep
            lost = not self._answers and added.cancel()  # then nothing is on the line
            if lost or added.done():
                self._sleep = None
                if lost or added.exception() is not None:
                    yield self._slept(jump)
        elif (dated := port.dated()) is not None:
            with self._lock:
                found = self._dates.look(*dated, broken=broken or self._gaps.open is not None)
            if found is None and (stood := port.stood_still):
                found = Jump(dated[0], stood, dated[1] - stood, dated[1], slept=True)
            if found is None:
                return
            if not found.slept:
                yield self._changed(found, dated[0])
            elif self._answers:  # a request may be under way
                self._sleep = found, self._acquisition.call(partial(self._sleep_between, found))
            else:
                yield self._slept(found)

    def _sleep_between(self, jump: Jump, _: Ecu) -> None:
        self._made.append(self._slept(jump))

    def _slept(self, jump: Jump) -> events.ClockChanged:
        assert self._acquisition is not None
        port = self._acquisition.port
        port.slept(jump.seconds)
        with self._lock:
            self._gaps.slept(events.SLEPT)
        self._record([])
        return self._changed(jump, port.now())

    def _changed(self, jump: Jump, time: float) -> events.ClockChanged:
        changed = events.ClockChanged(time, jump.seconds, jump.slept, jump.before, jump.after)
        self.later += changed.later
        log(changed)
        self.record(changed)
        return changed

    def conclude(self) -> None:
        """Record a change of the date that is not certain yet: a recording, or the session, ends.

        It is yielded before the next event.
        """
        port = None if self._acquisition is None else self._acquisition.port
        with self._lock:
            jump = None
            if port is not None and self._sleep is None and (dated := port.dated()) is not None:
                jump = self._dates.look(*dated, broken=False)
            jump = jump or self._dates.conclude()
        if jump is not None:
            self._made.append(self._changed(jump, jump.time))

    # The stored faults

    def read_now(self) -> Future[None] | None:
        """Read the stored faults for the begin or the end of a recording, between two cycles.

        None: they are not wanted, the unit refuses to give them, or none answers.
        """
        if not (self._answers and self.wants_faults()) or self.faults.refused:
            return None
        return self._read(routine=False)

    def _read(self, *, routine: bool) -> Future[None]:
        assert self._acquisition is not None
        return self._acquisition.call(partial(self.read_between, routine=routine))

    def read_between(self, ecu: Ecu, *, routine: bool = True) -> None:
        """Read the stored faults, in a job; `routine`: as of `FaultReading`.

        Raises a `NoConnection`.
        """
        if not self.faults.refused and (reading := self.faults.read(ecu, routine=routine)):
            self._on_faults(reading)

    def readings(self) -> Iterator[events.Event]:
        """Yield the readings and changes of the clock that were made since the last event."""
        while self._made:
            yield self._made.popleft()

    def _keep(self, reading: events.FaultReading) -> None:
        self.record(reading)
        self._made.append(reading)

    def _record(self, gaps: list[events.Gap]) -> None:
        """Record the gaps that are over, and the open one if it or its reason is new."""
        for gap in gaps:
            log(gap)
        before, self._open = self._open, self._gaps.open
        for gap in gaps:
            if gap.ended is not None:
                self.record(gap)
        if self._open is not None and self._open is not before:
            self.record(self._open)


def log(event: events.Event) -> None:
    """Log `event` at INFO: a state, a unit, a method, a refused parameter, a gap.

    Values and single failed cycles are not logged; `mikas.tester` logs the frames at DEBUG. With
    the logger off, an event costs one comparison.
    """
    if not _logger.isEnabledFor(logging.INFO):
        return
    match event:
        case events.Gap(ended=None, reason=reason):
            _logger.info("gap began: %s", reason.en if reason else "unknown")
        case events.Gap(began=began, ended=float() as ended, reason=reason):
            why = reason.en if reason else "unknown"
            _logger.info("gap ended after %.1f s: %s", ended - began, why)
        case events.StateChanged(text=text, reason=reason):
            _logger.info("state: %s%s", text.en, f" ({reason.en})" if reason else "")
        case events.AdapterMoved(text=text) | events.ClockChanged(text=text):
            _logger.info("%s", text.en)
        case events.UnitFound(version_code=code, passport=passport, another=another):
            pieces = ", ".join(filter(None, passport.pieces)) if passport else ""
            new = "another unit" if another else "unit"
            _logger.info("%s: version %02X, passport: %s", new, code or 0, pieces or "none")
        case events.MethodChosen(method=method, rates=rates):
            measured = ", ".join(f"{name} {rate:.1f}/s" for name, rate in rates.items())
            _logger.info("method: %s%s", method, f" (measured: {measured})" if measured else "")
        case events.ParameterDropped(name=name):
            _logger.info("no valid answer for %s: dropped", name)
        case events.ParameterReturned(name=name):
            _logger.info("%s is answered again", name)
        case _:
            pass
