"""One session of `watch`, `log` or `publish`: the acquisition, the recorder and their end.

    link ──► Acquisition ──► SamplingSession, Recorder ──► SamplingRun.events ──► display

If the unit does not answer the first connection, the command ends with advice. Later the run waits
without limit for a lost link or unit.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.cli.advice import ADVICE
from mikas.cli.context import CommandContext
from mikas.cli.language import localized, tr
from mikas.errors import EngineStopped, MikasError, RecordingOver, UsageError
from mikas.link.reconnecting import ReconnectingPort
from mikas.recording.recorder import Recorder
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import (
    ClockChanged,
    CycleFailed,
    FaultReading,
    Gap,
    LineState,
    Sampled,
    StateChanged,
    UnitFound,
)
from mikas.sampling.session import SamplingSession

if TYPE_CHECKING:
    from concurrent.futures import Future

    from mikas.cli.options.sampling import SamplingOptions
    from mikas.client import Ecu
    from mikas.i18n import Text
    from mikas.link.ahead import PortAhead
    from mikas.recording.capture.notes import Note
    from mikas.sampling.events import Event

_ALIVE = (LineState.ECU_ALIVE, LineState.SAMPLING)
_LAST = 1.0  # s of samples that the end of a recording waits for its last reading of the faults
_SEARCH = 3  # failed cycles at the start that are not shown: another method may follow


@dataclass(eq=False)
class SamplingRun:
    """The events of one run, to be iterated once, and its counters."""

    session: SamplingSession
    acquisition: Acquisition
    recorder: Recorder
    options: SamplingOptions
    model: Text | None = None
    answered: bool = False  # a unit, at least once
    connected: bool = False  # to a unit that has given values, or that is identified
    waiting: StateChanged | None = None  # the broken state of the line
    samples: int = 0
    gap_cycles: int = 0
    seconds: float = 0.0
    recording_over: RecordingOver | None = None
    """The end of the played recording, which ended the events."""
    _last_reading: Future[None] | None = None  # after Ctrl-C
    _began: float | None = None
    _ecu: Ecu | None = None
    _identified: bool = False
    _works: bool = False  # sampled since the unit was identified
    _searched: int = 0  # failed cycles before that
    _failed_before: int = 0  # line errors on links that are gone

    @property
    def errors(self) -> int:
        """The number of exchanges that failed on the line."""
        return self._failed_before + (self._ecu.tester.statistics.failed if self._ecu else 0)

    @property
    def later(self) -> float:
        """The seconds that the date is later than the events' clock."""
        return self.session.later

    @property
    def rate(self) -> float:
        """Samples a second, on average."""
        return self.samples / self.seconds if self.seconds > 0 else 0.0

    def events(self) -> Generator[Event, None, None]:
        """Yield events, after recording them, until the run is complete; failed cycles count.

        The end of a played recording sets `recording_over`. Raises as `Acquisition.run` does.
        """
        options = self.options.with_count()
        period = 1 / options.rate if options.rate else 0.0
        due = -inf
        with closing(self._acquire()) as events:
            for event in events:
                if isinstance(event, FaultReading | Gap | ClockChanged):
                    yield event
                    continue
                if isinstance(event, CycleFailed) and self._is_searching(event):
                    continue
                if isinstance(event, Sampled) and period:
                    if event.time < due:  # methods are measured at full speed
                        continue
                    due = event.time + 0.75 * period
                self._follow(event)
                yield event
                if self._last_reading is not None and self._last_reading.done():
                    raise KeyboardInterrupt
                if self._is_complete(options) and not self.acquisition.has_more:
                    yield from self._end(events)
                    return

    def end_soon(self) -> bool:
        """End the run as Ctrl-C does, after a last reading of the faults; False: at once.

        Called by a signal's handler.
        """
        if self._last_reading is not None or not self.samples:
            return False
        self._last_reading = self.session.read_now()
        return self._last_reading is not None

    def is_recording(self) -> bool:
        """Return whether the run writes to a file."""
        status = self.recorder.status
        return status is not None and status.failure is None

    def _end(self, events: Iterator[Event]) -> Iterator[Event]:
        """Read the faults before the recording ends, for a second of events at most."""
        if not self.samples or (reading := self.session.read_now()) is None:
            return
        until: float | None = None
        with suppress(MikasError):
            for event in events:
                if isinstance(event, FaultReading):
                    yield event
                    continue
                until = event.time + _LAST if until is None else until
                if reading.done() or event.time > until:
                    break
        yield from self.session.readings()

    def _acquire(self) -> Generator[Event, None, None]:
        with closing(self.session.run(self.acquisition)) as events:
            try:
                yield from events
            except RecordingOver as error:
                if not self.samples:
                    raise
                self.recording_over = error

    def _is_searching(self, gap: CycleFailed) -> bool:
        """Return whether `gap` may be the refusal of a method, which is raised next."""
        if isinstance(gap.error, EngineStopped):
            return False
        self._searched += not self._works
        return not self._works and self._searched <= _SEARCH

    def _follow(self, event: Event) -> None:
        ecu = self.acquisition.ecu
        if ecu is not None and ecu is not self._ecu:
            self._failed_before, self._ecu = self.errors, ecu
        if isinstance(event, UnitFound):
            self.connected = self._identified = True
            self.model = event.model
        if isinstance(event, StateChanged):
            self.waiting = event if event.is_broken else None
            self.answered |= event.state in _ALIVE
            if event.state is LineState.SAMPLING and self._began is None:
                self._began = event.time
        if isinstance(event, Sampled):
            self.samples += 1
            self.connected = True
            self._works |= self._identified
        self.gap_cycles += isinstance(event, CycleFailed)
        if self._began is not None:
            self.seconds = max(self.seconds, event.time - self._began)

    def _is_complete(self, options: SamplingOptions) -> bool:
        if options.count is not None and self.samples + self.gap_cycles >= options.count:
            return True
        return options.duration is not None and self.seconds >= options.duration


@contextmanager
def sampling_session(
    context: CommandContext,
    options: SamplingOptions,
    ahead: PortAhead,
    out: Path | None = None,
    *,
    joined: bool = True,
    patient: bool = False,
    in_streams: float | None = None,
    car: Callable[[UnitFound], Note | None] | None = None,
) -> Iterator[SamplingRun]:
    """Open a run on the port `ahead`; everything on the wire is recorded to `out`, if given.

    `patient`: the first connection is waited for, too. `in_streams`: as of `FaultWatch`; each
    reading interrupts a stream. `car`: gives the recording's note on a unit's car.
    """
    port = ahead.url
    recorder = Recorder(interpretation=context.options.interpretation, joined=joined, car=car)
    acquisition = Acquisition(
        ReconnectingPort(
            port, open_port=ahead.open, sink=recorder, timeout=context.options.timeout
        ),
        context.options.create_ecu,
        context.options.catalog,
        options.names,
        method=options.method,
        rate=options.rate,
        strict=not patient,
    )
    if context.relearn:
        acquisition.relearn()
    if out is not None:
        recorder.start(out, url=port)
    context.output.detail(tr("port", "порт"), port)
    session = SamplingSession(recorder.record_event, in_streams=in_streams)
    session.wants_faults = lambda: False
    recorder.conclude = session.conclude
    run = SamplingRun(session, acquisition, recorder, options)
    try:
        yield run
    except MikasError as error:
        # The same `log` must work again. A capture shows why no unit answered.
        useless = isinstance(error, UsageError) or out != context.capture
        if out is not None and useless and not run.answered:
            recorder.stop()
            with suppress(OSError):
                out.unlink()
        raise
    finally:
        recorder.stop()
        if acquisition.unended is not None:
            context.output.print_note(localized(ADVICE.text(acquisition.unended)))
