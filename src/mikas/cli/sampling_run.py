"""One run of `watch`, `log`, `publish` or a measurement: a session, with what the display needs.

    mikas.live.Session ──► SamplingRun.events ──► display

If the unit does not answer the first connection, the command ends with advice. Later the run waits
without limit for a lost link or unit.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.cli.advice import ADVICE
from mikas.cli.context import CommandContext
from mikas.cli.language import localized, tr
from mikas.errors import MikasError
from mikas.instruments.choosing import chosen_instruments
from mikas.live.progress import Length
from mikas.live.starting import prepared
from mikas.recording.recorder import Recorder
from mikas.sampling.events import ClockChanged, FaultReading, Gap, Sampled, StateChanged, UnitFound
from mikas.sampling.instrument_changes import InstrumentChanged

if TYPE_CHECKING:
    from concurrent.futures import Future

    from mikas.catalog import Derived, InstrumentChannel, Parameter
    from mikas.cli.options.sampling import SamplingOptions
    from mikas.cli.port_ahead import PortAhead
    from mikas.errors import RecordingOver
    from mikas.i18n import Text
    from mikas.live.session import Session
    from mikas.recording.capture.notes import Note
    from mikas.recording.recorder import RecordingStatus
    from mikas.sampling.acquisition import Acquisition
    from mikas.sampling.events import Event
    from mikas.sampling.session import SamplingSession


@dataclass(eq=False)
class SamplingRun:
    """The events of one run, to be iterated once, and what they say to a display."""

    live: Session
    options: SamplingOptions
    model: Text | None = None
    connected: bool = False  # to a unit that has given values, or that is identified
    waiting: StateChanged | None = None  # the broken state of the line
    _last_reading: Future[None] | None = None  # after Ctrl-C

    @property
    def session(self) -> SamplingSession:
        """The gaps and fault readings of the session."""
        return self.live.sampling

    @property
    def acquisition(self) -> Acquisition:
        """The loop that samples."""
        return self.live.acquisition

    @property
    def channels(self) -> tuple[Parameter | Derived | InstrumentChannel, ...]:
        """The channels of the unit, then those of the instruments."""
        return self.live.channels

    @property
    def recorder(self) -> Recorder:
        """The session's recorder."""
        return self.live.recorder

    @property
    def recording_over(self) -> RecordingOver | None:
        """The end of the played recording, which ended the events."""
        return self.live.recording_over

    @property
    def answered(self) -> bool:
        """Whether a unit has answered."""
        return self.live.progress.answered

    @property
    def samples(self) -> int:
        """The samples so far."""
        return self.live.progress.samples

    @property
    def gap_cycles(self) -> int:
        """The cycles so far that gave no sample."""
        return self.live.progress.failed_cycles

    @property
    def seconds(self) -> float:
        """The seconds from the first values to the latest event."""
        return self.live.progress.seconds

    @property
    def errors(self) -> int:
        """The number of exchanges that failed on the line."""
        return self.live.line_errors

    @property
    def later(self) -> float:
        """The seconds that the date is later than the events' clock."""
        return self.live.later

    @property
    def rate(self) -> float:
        """Samples a second, on average."""
        return self.live.progress.rate

    def events(self) -> Generator[Event, None, None]:
        """Yield events, after recording them, until the run is complete; failed cycles count.

        Raises as `Acquisition.run` does.
        """
        try:
            while (event := self.live.following()) is not None:
                self._follow(event)
                yield event
                if isinstance(event, FaultReading | Gap | ClockChanged | InstrumentChanged):
                    continue
                if self._last_reading is not None and self._last_reading.done():
                    raise KeyboardInterrupt
        finally:
            self.live.leave()

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

    def end_recording(self) -> RecordingStatus | None:
        """End the recording; return its progress, None if there is none."""
        return self.live.end_recording()

    def _follow(self, event: Event) -> None:
        match event:
            case UnitFound(model=model):
                self.connected, self.model = True, model
            case StateChanged():
                self.waiting = event if event.is_broken else None
            case Sampled():
                self.connected = True
            case _:
                pass


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
    instruments: Sequence[str] = (),
) -> Iterator[SamplingRun]:
    """Open a run on the port `ahead`; everything on the wire is recorded to `out`, if given.

    `patient`: the first connection is waited for, too. `in_streams`: as of `FaultWatch`; each
    reading interrupts a stream. `car`: gives the recording's note on a unit's car. `instruments`:
    beside the unit, as NAME=URL.
    """
    live = prepared(
        ahead.url,
        context.options,
        options.names,
        Length(options.count, options.duration, options.rate, cycles=True),
        method=options.method,
        recorder=Recorder(interpretation=context.options.interpretation, joined=joined, car=car),
        record=out,
        on_record_failure=lambda _: None,  # the notices say it
        keeps_unanswered=out == context.capture,
        wants_faults=lambda: False,
        in_streams=in_streams,
        patient=patient,
        open_port=ahead.open,
        instruments=chosen_instruments(instruments, context.options.catalog),
    )
    if context.relearn:
        live.acquisition.relearn()
    context.output.detail(tr("port", "порт"), ahead.url)
    try:
        yield SamplingRun(live, options)
    except MikasError as error:
        live.discard_after(error)
        raise
    finally:
        live.close()
        if live.acquisition.unended is not None:
            context.output.print_note(localized(ADVICE.text(live.acquisition.unended)))
