"""A sampling session for programs: what `mikas log` and the dashboard do, as one object.

    with mikas.session("sim:", channels=["FREQ", "TWAT/10", "FUEL_FLOW"], record="a.pcapng") as it:
        it.on(Gap, lambda gap: print("gap:", gap.reason))
        for sample in it:
            print(sample.values)

A lost adapter or unit is waited for and found again, the fastest method that works is chosen, the
derived channels, alarms and gaps are computed, the stored faults are watched. Whoever iterates
drives it: the listeners are called in that thread, and no other thread starts.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import CancelledError, Future
from contextlib import closing, suppress
from math import inf
from typing import TYPE_CHECKING, Any, Self, TypeVar

from mikas.cancellation import Cancellation, Cancelled
from mikas.client.parameters.polling import Method
from mikas.client.recorded import close_after
from mikas.errors import CaptureError, LinkClosed, MikasError, RecordingOver, UsageError
from mikas.live.progress import Length, RunProgress
from mikas.live.record_failures import RecordFailures
from mikas.options import check_number
from mikas.recording.recorder import Recorder, RecordingStatus
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.beside import SamplesBeside
from mikas.sampling.events import ClockChanged, CycleFailed, Event, FaultReading, Gap, Sampled
from mikas.sampling.instrument_changes import InstrumentChanged
from mikas.sampling.session import SamplingSession

if TYPE_CHECKING:
    import pandas as pd

    from mikas.catalog import Derived, InstrumentChannel, Parameter
    from mikas.client import Ecu
    from mikas.client.identity import UnitIdentity
    from mikas.instruments.session_instruments import SessionInstruments
    from mikas.sampling.events import AlarmChanged

E = TypeVar("E", bound=Event)
T = TypeVar("T")
_LAST = 1.0  # s of events that the end waits for the last reading of the faults


class Session(Iterator[Sampled]):
    """The samples of one run; iterate, and close it, or use it in a `with` statement.

    Iterating ends after `stop`, after `count` samples, after `duration` seconds from the first
    values, and with a recording that is replayed. It raises what prevents the first sample (no
    port, no unit, a refused method), unless `patient`; later such things are waited for. One thread
    iterates; any thread may call `stop`, `close`, `call`, `mark` and `reconfigure`.
    """

    def __init__(
        self,
        acquisition: Acquisition,
        recorder: Recorder,
        sampling: SamplingSession,
        length: Length,
        *,
        on_record_failure: Callable[[CaptureError], object] | None = None,
        keeps_unanswered: bool = False,
        instruments: SessionInstruments | None = None,
    ) -> None:
        self.instruments = instruments
        """The instruments beside the unit; None: there are none."""
        self.acquisition = acquisition
        """The loop that connects, plans and samples."""
        self.recorder = recorder
        """The recorder of the bytes and events."""
        self.sampling = sampling
        """The gaps, fault readings and units that follow from several events."""
        self.progress: RunProgress = RunProgress(length)
        """The counts so far."""
        self.recording_over: RecordingOver | None = None
        """The end of the played recording, which ended the iteration; None: it did not."""
        recorder.conclude = sampling.conclude
        self._period = _period(length.rate)
        self._due = -inf
        self._failures = RecordFailures(on_record_failure)
        self._keeps_unanswered = keeps_unanswered
        self._recorded: RecordingStatus | None = None  # of the recording that has ended
        self._listeners: list[tuple[type[Event], Callable[[Any], object]]] = []
        self._source: Generator[Event, None, None] | None = None
        self._ended = False
        self._job: Cancellation | None = None  # that runs now
        self._turn = threading.RLock()  # of the thread that uses the line
        self._ecu: Ecu | None = None
        self._alarms: list[AlarmChanged] = []  # of the instruments, by the latest sample
        self._failed_before = 0  # exchanges, on links that are gone

    # What it is doing

    @property
    def unit(self) -> UnitIdentity | None:
        """The unit found last: its version code and passports; None before the first."""
        return self.sampling.unit

    @property
    def method(self) -> str | None:
        """The present method of sampling; None before it is chosen."""
        return self.acquisition.method

    @property
    def channels(self) -> tuple[Parameter | Derived | InstrumentChannel, ...]:
        """The channels of the unit, then those of the instruments."""
        beside = () if self.instruments is None else self.instruments.channels
        return (*self.acquisition.channels, *beside)

    @property
    def line_errors(self) -> int:
        """The number of exchanges that failed on the line."""
        return self._failed_before + (self._ecu.tester.statistics.failed if self._ecu else 0)

    @property
    def later(self) -> float:
        """The seconds that the date is later than the times of the events: it was set since."""
        return self.sampling.later

    @property
    def recording(self) -> RecordingStatus | None:
        """The recording's progress: its path, bytes, samples, gaps; None without one."""
        return self.recorder.status or self._recorded

    # The events

    def __next__(self) -> Sampled:
        """Return the next sample. Raises `CaptureError` if the recording failed, see `session`."""
        for event in self.events():
            if isinstance(event, Sampled):
                return event
        raise StopIteration

    def events(self) -> Iterator[Event]:
        """Iterate over all events (`mikas.sampling.events`): samples, gaps, states, alarms, faults.

        It is the same iteration as that of the samples, which leaves the others out.
        """
        while (event := self.following()) is not None:
            yield event

    def on(self, kind: type[E], listener: Callable[[E], object]) -> Callable[[], None]:
        """Call `listener` with each event of this class, or of one below it; return its removal.

        `session.on(Sampled, queue.put)` feeds a queue; the classes are those of
        `mikas.sampling.events`. What a listener raises ends the iteration.
        """
        if not (isinstance(kind, type) and issubclass(kind, Event)):
            raise TypeError(f"a class of mikas.sampling.events, such as Sampled, not {kind!r}")
        if not callable(listener):
            raise TypeError(f"a function of one event, not {listener!r}")
        entry = (kind, listener)
        self._listeners.append(entry)

        def remove() -> None:
            if entry in self._listeners:
                self._listeners.remove(entry)

        return remove

    def run(self, duration: float | None = None) -> int:
        """Sample for the listeners and the recording, for `duration` seconds or to the end.

        The duration counts from the first sample, also while no unit answers. Returns the number
        of samples.
        """
        if duration is not None:
            check_number("duration", duration, lowest=0)
        samples, until = 0, inf
        for event in self.events():
            if isinstance(event, Sampled):
                samples += 1
                if samples == 1 and duration is not None:
                    until = event.time + duration
            if event.time >= until:
                break
        return samples

    def to_pandas(self, duration: float | None = None) -> pd.DataFrame:
        """Sample as `run` does; return a `pandas.DataFrame`: a row a sample, a column a channel.

        The index is the time with its zone (UTC); a value that was not read in a cycle is missing.
        Needs pandas.
        """
        from mikas.recording.table.dataframes import library  # which imports numpy

        found = library("pandas")
        times: list[float] = []
        rows: list[dict[str, float | bool]] = []

        def keep(sample: Sampled) -> None:
            times.append(sample.time)
            rows.append(sample.values)

        remove = self.on(Sampled, keep)
        try:
            self.run(duration)
        finally:
            remove()
        later = self.sampling.later  # of all times: also of those before the date was set
        index = found.to_datetime([time + later for time in times], unit="s", utc=True)
        names = [channel.name for channel in self.channels]
        frame: pd.DataFrame = found.DataFrame(rows, index=index, columns=names)
        return frame.rename_axis("time")

    # To be called from any thread

    def stop(self) -> None:
        """End the iteration within two seconds."""
        self.acquisition.stop()

    def call(self, job: Callable[[Ecu], T]) -> Future[T]:
        """Run `job(ecu)` between two cycles: `session.call(lambda ecu: ecu.faults()).result()`.

        The thread that iterates runs it, so only another one may wait for the result. `close` ends
        a long one between two requests, with a `CancelledError` of `concurrent.futures`. As
        `Acquisition.call`.
        """
        return self._cancellable(job)[0]

    def _cancellable(self, job: Callable[[Ecu], T]) -> tuple[Future[T], Cancellation]:
        """As `call`; return also what ends the job between two requests."""
        cancellation = Cancellation()

        def run(ecu: Ecu) -> T:
            self._job = cancellation
            try:
                return cancellation.run(lambda: job(ecu))
            except Cancelled:
                raise CancelledError from None
            finally:
                self._job = None

        return self.acquisition.call(run), cancellation

    def mark(self, label: str = "") -> float | None:
        """Mark this moment in the recording; return its time, None before any byte."""
        return self.recorder.marker(label=label)

    def reconfigure(
        self, channels: str | Iterable[str], method: Method = "auto", rate: float | None = None
    ) -> None:
        """Sample other channels from the next cycle on. Raises as `session` does."""
        self.acquisition.reconfigure(listed(channels), method, rate)
        self._period = _period(rate)

    def close(self) -> None:
        """Leave the line quiet, close the port, end the recording; a second call does nothing.

        If another thread iterates, its iteration ends first, within two seconds. Raises
        `CaptureError` if the end of the recording can't be written, see `session`.
        """
        self._ended = True
        self.stop()
        if (job := self._job) is not None:
            job.request()
        with self._turn:
            if self.acquisition.ecu is not None:
                self.acquisition.ecu.tester.end_calls()  # a stream ends the sooner
            try:
                self.leave()
            finally:
                if self._source is None:  # never iterated; the same call must work again
                    self.recorder.discard()
                self.end_recording()
        if self._recorded is not None:
            self._failures.report(self._recorded.failure)

    def leave(self) -> None:
        """Leave the line quiet and close the port; the recording has that, too."""
        if self._source is not None:
            self._source.close()
        if self.instruments is not None:
            self.instruments.close()
        self.acquisition.refuse_jobs()

    def end_recording(self) -> RecordingStatus | None:
        """End the recording; return its progress, None if there was none."""
        self._recorded = self.recorder.stop() or self._recorded
        return self._recorded

    def discard_after(self, error: MikasError) -> None:
        """Delete a recording in which no unit has answered: the same call must work again.

        One that `keeps_unanswered` shows why none did, unless `error` is a wrong use.
        """
        keeps = self._keeps_unanswered and not isinstance(error, UsageError)
        if not self.progress.answered and not keeps:
            self.recorder.discard()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        close_after(kind, self.close)

    # The loop

    def following(self) -> Event | None:
        """Return the next event, after its listeners; None: there is none any more."""
        if self._ended and self._source is None:
            raise LinkClosed(url=self.acquisition.port.url)
        if self._source is None:
            self._source = self._wanted()
        with self._turn:
            try:
                event = next(self._source, None)
            except MikasError as error:
                self.discard_after(error)
                raise
        if event is None:
            self.close()
            return None
        for kind, listener in tuple(self._listeners):
            if isinstance(event, kind):
                listener(event)
        self._failures.report(self.recorder.failure)
        return event

    def _wanted(self) -> Generator[Event, None, None]:
        """Yield the events until the run is complete; failed cycles of a search are none."""
        progress = self.progress
        if progress.is_complete:
            return
        with closing(self.sampling.run(self.acquisition)) as events:
            try:
                for event in self._with_instruments(events):
                    if isinstance(event, FaultReading | Gap | ClockChanged | InstrumentChanged):
                        yield event
                        continue
                    if isinstance(event, CycleFailed) and progress.is_searching(event):
                        continue
                    if isinstance(event, Sampled) and self._period:
                        if event.time < self._due:  # methods are measured at full speed
                            continue
                        self._due = event.time + self._period
                    self._count(event)
                    yield event
                    if progress.is_complete and not (self.acquisition.has_more or self._alarms):
                        yield from self._last_faults(events)
                        return
            except RecordingOver as error:
                if not progress.samples:
                    raise
                self.recording_over = error

    def _with_instruments(self, events: Iterator[Event]) -> Iterator[Event]:
        """Yield the events, the samples with what the instruments give; and their changes."""
        beside = self.instruments
        samples = SamplesBeside(beside.channels if beside else ())
        for event in events:  # no `yield from`: only the caller closes `events`
            if beside is not None:
                yield from map(InstrumentChanged.of, beside.follow())
            if beside is None or not isinstance(event, Sampled):
                yield event
                continue
            values = beside.fresh(event.time)
            made = samples.completed(event, values, self.acquisition.selection)
            self._alarms = samples.alarms(made)
            yield made
            while self._alarms:
                alarm = self._alarms.pop(0)
                self.recorder.record_event(alarm)
                yield alarm

    def _last_faults(self, events: Iterator[Event]) -> Iterator[Event]:
        """Read the faults before the run ends, for a second of events at most."""
        if not self.progress.samples or (reading := self.sampling.read_now()) is None:
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
        yield from self.sampling.readings()

    def _count(self, event: Event) -> None:
        ecu = self.acquisition.ecu
        if ecu is not None and ecu is not self._ecu:
            self._failed_before, self._ecu = self.line_errors, ecu
        self.progress.follow(event)


def _period(rate: float | None) -> float:
    """Return the least seconds from one sample to the next: a little less than a period."""
    return 0.75 / rate if rate else 0.0


def listed(channels: str | Iterable[str]) -> Iterable[str]:
    """Return the channels; a text is one, not its letters."""
    return [channels] if isinstance(channels, str) else channels
