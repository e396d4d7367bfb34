"""A sampling session for programs: what `mikas log` and the dashboard do, as one object.

    with mikas.session("sim:", channels=["FREQ", "TWAT/10", "FUEL_FLOW"], record="a.pcapng") as it:
        it.on(Gap, lambda gap: print("gap:", gap.reason))
        for sample in it:
            print(sample.values)

A lost adapter or unit is waited for and found again, the fastest method that works is chosen, the
derived channels, alarms and gaps are computed, the stored faults are watched. Whoever iterates
drives it: the listeners are called in that thread, and no other thread is begun.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Future
from contextlib import closing
from math import inf
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar, Unpack

from mikas.catalog import load
from mikas.client.connecting import ConnectionKeywords, ConnectionOptions, StrPath, named_port
from mikas.client.parameters.polling import Method
from mikas.errors import CaptureError, LinkClosed, RecordingOver, usage_error
from mikas.link import choose_port, open_link
from mikas.link.reconnecting import ReconnectingPort
from mikas.recording.recorder import Recorder, RecordingStatus
from mikas.recording.table.dataframes import library
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import Event, Sampled
from mikas.sampling.session import SamplingSession

if TYPE_CHECKING:
    import pandas as pd

    from mikas.client import Ecu
    from mikas.client.identity import UnitIdentity
    from mikas.link import Link

E = TypeVar("E", bound=Event)
T = TypeVar("T")


class Session(Iterator[Sampled]):
    """The samples of one run; iterate, and close it, or use it in a `with` statement.

    Iterating ends after `stop`, after `count` samples, after `duration` seconds of samples, and
    with a recording that is replayed. It raises what prevents the first sample (no port, no unit,
    a refused method), unless `patient`; later such things are waited for. One thread iterates; any
    thread may call `stop`, `call`, `mark` and `reconfigure`.
    """

    def __init__(
        self,
        acquisition: Acquisition,
        recorder: Recorder,
        *,
        rate: float | None = None,
        count: int | None = None,
        duration: float | None = None,
        faults: bool = True,
        on_record_failure: Callable[[CaptureError], object] | None = None,
    ) -> None:
        self.acquisition = acquisition
        """The loop that samples, with its plan, catalog and statistics."""
        self._recorder = recorder
        self._sampling = SamplingSession(recorder.record_event)
        self._sampling.wants_faults = lambda: faults
        recorder.conclude = self._sampling.conclude
        self._period = 0.75 / rate if rate else 0.0
        self._due = -inf
        self._left = inf if count is None else count
        self._duration = inf if duration is None else duration
        self._began: float | None = None
        self._on_record_failure = on_record_failure
        self._reported: CaptureError | None = None
        self._recorded: RecordingStatus | None = None  # of the recording that has ended
        self._listeners: list[tuple[type[Event], Callable[[Any], object]]] = []
        self._source: Generator[Event, None, None] | None = None
        self._ended = False

    # What it is doing

    @property
    def unit(self) -> UnitIdentity | None:
        """The unit found last: its version code and passports; None before the first."""
        return self._sampling.unit

    @property
    def method(self) -> str | None:
        """The present method of sampling; None before it is chosen."""
        return self.acquisition.method

    @property
    def recording(self) -> RecordingStatus | None:
        """The recording's progress: its path, bytes, samples, gaps; None without one."""
        return self._recorder.status or self._recorded

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

        `session.on(Sampled, queue.put)` feeds a queue. What a listener raises ends the iteration.
        """
        entry = (kind, listener)
        self._listeners.append(entry)

        def remove() -> None:
            if entry in self._listeners:
                self._listeners.remove(entry)

        return remove

    def run(self, duration: float | None = None) -> int:
        """Sample for the listeners and the recording, for `duration` seconds or to the end.

        Returns the number of samples.
        """
        samples, until = 0, None
        for sample in self:
            samples += 1
            if duration is not None:
                until = sample.time + duration if until is None else until
                if sample.time >= until:
                    break
        return samples

    def to_pandas(self, duration: float | None = None) -> pd.DataFrame:
        """Sample as `run` does; return a `pandas.DataFrame`: a row a sample, a column a channel.

        The index is the time with its zone (UTC); a value that was not read in a cycle is missing.
        Needs pandas.
        """
        found = library("pandas")
        times: list[float] = []
        rows: list[dict[str, float | bool]] = []

        def keep(sample: Sampled) -> None:
            times.append(sample.time + self._sampling.later)
            rows.append(sample.values)

        remove = self.on(Sampled, keep)
        try:
            self.run(duration)
        finally:
            remove()
        index = found.to_datetime(times, unit="s", utc=True)
        names = [channel.name for channel in self.acquisition.channels]
        frame: pd.DataFrame = found.DataFrame(rows, index=index, columns=names)
        return frame.rename_axis("time")

    # To be called from any thread

    def stop(self) -> None:
        """End the iteration within two seconds."""
        self.acquisition.stop()

    def call(self, job: Callable[[Ecu], T]) -> Future[T]:
        """Run `job(ecu)` between two cycles: `session.call(lambda ecu: ecu.faults()).result()`.

        The thread that iterates runs it, so only another one may wait for the result. As
        `Acquisition.call`.
        """
        return self.acquisition.call(job)

    def mark(self, label: str = "") -> float | None:
        """Mark this moment in the recording; return its time, None before any byte."""
        return self._recorder.marker(label=label)

    def reconfigure(
        self, channels: Iterable[str], method: Method = "auto", rate: float | None = None
    ) -> None:
        """Sample other channels from the next cycle on. Raises as `session` does."""
        self.acquisition.reconfigure(channels, method, rate)
        self._period = 0.75 / rate if rate else 0.0

    def close(self) -> None:
        """Leave the line quiet, close the port, end the recording; a second call does nothing."""
        self._ended = True
        try:
            if self._source is not None:
                self._source.close()
        finally:
            self._recorded = self._recorder.stop() or self._recorded

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # The loop

    def following(self) -> Event | None:
        """Return the next event, after its listeners; None: there is none any more."""
        if self._ended and self._source is None:
            raise LinkClosed(url=self.acquisition.port.url)
        if self._source is None:
            self._source = self._wanted()
        event = next(self._source, None)
        if event is None:
            self.close()
            return None
        for kind, listener in tuple(self._listeners):
            if isinstance(event, kind):
                listener(event)
        self._look_at_recording()
        return event

    def _wanted(self) -> Generator[Event, None, None]:
        if self._left <= 0:
            return
        with closing(self._sampling.run(self.acquisition)) as events:
            try:
                for event in events:
                    if not isinstance(event, Sampled):
                        yield event
                    elif event.time >= self._due:  # methods are measured at full speed
                        self._due = event.time + self._period
                        yield event
                        if self._is_last(event):
                            return
            except RecordingOver:
                if self._began is None:
                    raise

    def _is_last(self, sample: Sampled) -> bool:
        self._left -= 1
        self._began = sample.time if self._began is None else self._began
        is_over = self._left <= 0 or sample.time - self._began >= self._duration
        return is_over and not self.acquisition.has_more

    def _look_at_recording(self) -> None:
        failure = self._recorder.failure
        if failure is None or failure is self._reported:
            return
        self._reported = failure
        if self._on_record_failure is None:
            raise failure
        self._on_record_failure(failure)


def session(
    url: str | None = None,
    channels: Iterable[str] = (),
    *,
    method: Method = "auto",
    rate: float | None = None,
    count: int | None = None,
    duration: float | None = None,
    record: StrPath | None = None,
    on_record_failure: Callable[[CaptureError], object] | None = None,
    faults: bool = True,
    patient: bool = False,
    catalogs: StrPath | Iterable[StrPath] = (),
    open_port: Callable[[str], Link] = open_link,
    **options: Unpack[ConnectionKeywords],
) -> Session:
    """Prepare a session; its port is opened when it is iterated.

    `url`: as of `connect`. `channels`: names, codes (`0x1A`) and derived channels, each with `/10`
    for every tenth cycle; none: all parameters. `method`: auto is the fastest that works. `rate`:
    most samples a second. `record`: the recording's file, which must not exist; if it fails,
    `on_record_failure` gets the error and sampling goes on, else it is raised. `faults`: read the
    stored faults from time to time. `patient`: wait for the first port and unit as well.
    `catalogs`: the user's own files. `open_port`: opens the port, for tests and links of your own.
    The other `options` are those of `ConnectionOptions`.

    Raises `UsageError` for an invalid option, `UnknownParameter`, `CaptureError` for the file.
    """
    files = [catalogs] if isinstance(catalogs, str | PathLike) else catalogs
    connection = ConnectionOptions(catalog=load(*files), **options)
    for name, value in (("count", count), ("duration", duration)):
        if value is not None and not value >= 0:
            raise usage_error(f"{name} is {value}; at least 0", f"{name}: {value}; не меньше 0")
    port = url or named_port() or choose_port()
    recorder = Recorder(interpretation=connection.interpretation)
    acquisition = Acquisition(
        ReconnectingPort(port, open_port=open_port, sink=recorder, timeout=connection.timeout),
        connection.create_ecu,
        connection.catalog,
        channels,
        method=method,
        rate=rate,
        strict=not patient,
    )
    made = Session(
        acquisition,
        recorder,
        rate=rate,
        count=count,
        duration=duration,
        faults=faults,
        on_record_failure=on_record_failure,
    )
    if record is not None:
        recorder.start(Path(record), url=port)
    return made
