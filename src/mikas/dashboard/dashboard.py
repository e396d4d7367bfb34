"""The dashboard: its parts composed around one connection.

    SamplingThread ── events ──► ConnectionMonitor ──► drained 20 times a second by the broadcaster
                   ◄── jobs ───  Connection.ask        awaited by the event loop, which never blocks
                   ── bytes ───► SessionRecorder

The routes decide which client may change anything (`security`).
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import replace

from mikas.catalog import Catalog
from mikas.client import Info, Support
from mikas.client.cars import CarBook, CarDetails
from mikas.client.connecting import EchoSetting, PauseSetting
from mikas.client.identity import UnitIdentity
from mikas.client.parameters.polling import Method
from mikas.dashboard.library.folder import RecordingFolder
from mikas.dashboard.library.service import RecordingService, References
from mikas.dashboard.security.control import (
    ConfirmationStore,
    ControlLease,
    WriteLock,
)
from mikas.dashboard.session.actions import SessionActions
from mikas.dashboard.session.catalog_in_use import (
    CatalogInUse,
    changed_channels,
    computing,
)
from mikas.dashboard.session.changes import UnitChanges
from mikas.dashboard.session.connection import (
    DIAGNOSIS,
    RECONNECTED,
    SURVEY,
    Connection,
    SamplingPlanner,
)
from mikas.dashboard.session.dump_jobs import DumpJobs
from mikas.dashboard.session.freeze_frames import FreezeFrameStore
from mikas.dashboard.session.guided_tests import GuidedTests
from mikas.dashboard.session.history import FaultHistory, History
from mikas.dashboard.session.instruments.beside import InstrumentsBeside
from mikas.dashboard.session.monitor import ConnectionMonitor
from mikas.dashboard.session.parameter_writing import ParameterWriting
from mikas.dashboard.session.port_threads import Diagnosis, SamplingThread
from mikas.dashboard.session.recorder import SessionRecorder
from mikas.dashboard.session.start_values import StartValues
from mikas.dashboard.session.surveys import Surveys
from mikas.dashboard.settings import PortSettings, Settings
from mikas.errors import MikasError
from mikas.i18n import Text
from mikas.link.urls import are_of_two_cars
from mikas.sampling import events
from mikas.sampling.session import SamplingSession


class Dashboard:
    """`port`: the URL to connect to when the application starts. `clock`: seconds that never run
    back, for leases, confirmations and locks, which last by people's time, not by the link's.
    """

    def __init__(
        self,
        settings: Settings,
        *,
        port: str | None = None,
        lan: bool = False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        options = settings.connection
        self.settings: Settings = settings
        self.lan: bool = lan
        self.clock: Callable[[], float] = clock
        self.saving: threading.Lock = threading.Lock()
        """Held while a list of the user is saved: requests come in threads."""
        self.catalogs: CatalogInUse = CatalogInUse(
            settings.own_catalog, options.catalog, self._use_catalog
        )
        self.write_lock: WriteLock = WriteLock(clock)
        self.control: ControlLease = ControlLease(clock, changed=self.write_lock.close)
        self.confirmations: ConfirmationStore = ConfirmationStore(clock)
        self.history: History = History()
        self.session: SamplingSession = SamplingSession(on_faults=self._add_faults)
        self.monitor: ConnectionMonitor = ConnectionMonitor(self.history, self.session)
        self.fault_history: FaultHistory = FaultHistory(self._on_faults)
        self.connection: Connection = Connection(
            settings,
            self.monitor,
            self._create_thread,
            self._on_request_end,
            PortSettings(port, options.echo) if port else None,
        )
        self.plan: SamplingPlanner = SamplingPlanner(self.connection, options)
        folder = RecordingFolder(settings.recordings)
        self.cars: CarBook = CarBook(
            settings.in_state("cars.json"), virtual_units=settings.virtual_units
        )
        self.car_now: tuple[UnitIdentity, CarDetails] | None = None
        """The details as last given since the start, with the unit."""
        self.freeze_frames: FreezeFrameStore = FreezeFrameStore(
            settings.in_state("freeze-frames"),
            self.history,
            self.connection.now,
            settings.virtual_units,
            lambda: self.connection.later,
        )
        self.recorder: SessionRecorder = SessionRecorder(
            self.connection, self.fault_history, folder, self.cars, options.interpretation
        )
        self.session.record = self.recorder.record_event
        self.recorder.recorder.conclude = self.session.conclude
        self.guided: GuidedTests = GuidedTests(
            settings,
            self.connection,
            self.plan,
            self.recorder.recorder,
            self.catalogs,
            lambda: self.formula_catalog,
        )
        self.library: RecordingService = RecordingService(
            folder,
            References(settings.in_state("references.json"), settings.virtual_recordings),
            options.catalog,
            options.interpretation,
            clock=clock,
            in_progress=lambda: self.recorder.file_name,
        )
        self.dump_jobs: DumpJobs = DumpJobs(self.connection, settings.dumps, clock)
        self.changes: UnitChanges = UnitChanges(self.connection, self.fault_history)
        self.writing: ParameterWriting = ParameterWriting(
            self.connection,
            self.changes.approval,
            options.interpretation,
            self.catalogs,
            StartValues(settings.in_state("start-values.json"), settings.virtual_units),
        )
        self.actions: SessionActions = SessionActions(
            settings.in_state("actions.toml"),
            settings.sockets,
            self.connection,
            self.recorder,
            lambda: self.formula_catalog,
            settings.language,
        )
        self.instruments: InstrumentsBeside = InstrumentsBeside(
            lambda: self.settings,
            self.connection,
            self.recorder.recorder,
            self._use_beside,
        )
        self.connection.taken = self.instruments.ports
        self.surveys: Surveys = Surveys(self.connection, lambda: self.settings)
        self.diagnosis: Diagnosis | None = None
        """The diagnosis that has the port."""
        self.info: Info | None = None
        self.supported: list[Support] | None = None

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Run as long as the application; at its end the recording and the port are closed."""
        await asyncio.to_thread(self.dump_jobs.find)
        await asyncio.to_thread(self.instruments.load)
        await asyncio.to_thread(self.actions.load)  # whose formulas may name instruments
        self.actions.start()
        self.connection.start()
        async with AsyncExitStack() as closing:  # from the last on, each whatever another raises
            closing.callback(self._follow_date)
            closing.callback(self.recorder.close)
            closing.push_async_callback(asyncio.to_thread, self.actions.close)
            closing.push_async_callback(self.connection.close)
            closing.push_async_callback(self.recorder.read_last)
            closing.push_async_callback(self._end_diagnosis)
            closing.push_async_callback(self.surveys.stop)
            closing.push_async_callback(self.dump_jobs.close)
            closing.push_async_callback(self.library.close)
            yield

    async def _end_diagnosis(self) -> None:
        if self.diagnosis is not None:
            await self.diagnosis.stop_and_wait()

    async def connect(
        self,
        url: str | None,
        *,
        echo: EchoSetting = "auto",
        pause: PauseSetting | None = None,
        method: Method = "auto",
        rate: float | None = None,
    ) -> None:
        """Connect as `Connection.connect`, sampling by `method`, at most at `rate`."""

        def accepted(url: str) -> None:
            self.plan.request = replace(self.plan.request, method=method, rate=rate)
            if self.connection.port is None or url != self.connection.port.url:
                self.recorder.change_port()

        await self.recorder.read_last()  # another port ends the recording
        await self.connection.connect(url, echo=echo, pause=pause, accepted=accepted)

    async def disconnect(self) -> None:
        """End the recording and close the port."""
        await self.recorder.read_last()
        await self.connection.disconnect()
        self.recorder.stop()

    @property
    def catalog(self) -> Catalog:
        """The catalog in use."""
        return self.catalogs.catalog

    @property
    def formula_catalog(self) -> Catalog:
        """The catalog in use with the channels of the instruments, for formulas of a person."""
        return self.catalog.with_beside(self.instruments.channels)

    def _use_beside(self, names: tuple[str, ...]) -> None:
        """Take the channels of other instruments."""
        self.monitor.set_beside(names)
        self.actions.instruments_changed()

    def _use_catalog(self, catalog: Catalog, before: Catalog) -> None:
        """Use another catalog on the running connection, for recordings and for what follows."""
        options = replace(self.settings.connection, catalog=catalog)
        self.settings = replace(self.settings, connection=options)
        self.library.use_catalog(catalog)
        self.actions.load()
        for alarm in self.instruments.use_catalog():
            self.monitor.add_event(alarm)
        changed = changed_channels(catalog, before)
        self.monitor.await_catalog(catalog.version, changed)
        self.plan.use_catalog(catalog)
        self.history.recompute(changed, computing(catalog, changed, options.interpretation))
        self.monitor.wake()

    def refresh(self) -> None:
        """Update the state that no event reports; called while there are viewers."""
        self.recorder.check()
        if (thread := self.connection.thread) is not None:
            self._measure(thread)

    def _create_thread(self, port: PortSettings) -> SamplingThread:
        request = self.plan.request
        thread = SamplingThread(
            port,
            self.settings,
            request,
            sink=self.recorder.recorder,
            confirm=self.changes.approval.confirm,
            on_event=self._on_event,
            on_end=self._on_end,
            before=self.session.unit,  # another unit may answer now
            moved=bool(last := self.session.unit_port) and are_of_two_cars(last, port.url),
        )
        thread.at_end = self.instruments.end
        self.instruments.begin(thread)
        self.session.begin(thread.acquisition)
        self.freeze_frames.begin_connection(thread.now())
        self.monitor.begin(request.every, thread.now())
        return thread

    def _on_request_end(self, thread: SamplingThread, why: Text) -> None:
        if why in (RECONNECTED, DIAGNOSIS, SURVEY):
            self.recorder.recorder.interrupt(thread.now(), why)
        self.monitor.end_connection(thread.now(), None, why)
        self._clear_unit()

    def _on_event(self, thread: SamplingThread, event: events.Event) -> None:
        """Pass on an event, after those that it completes; in the sampling thread."""
        if thread is not self.connection.thread:
            return
        for change in self.instruments.follow():
            self.monitor.log(change)
        for it in self.session.events_of(event):
            if isinstance(it, events.Sampled):
                it = self.instruments.with_values(it)  # noqa: PLW2901  (all that follows needs its values)
            if isinstance(it, events.AdapterMoved):
                self.connection.moved(it.port)
            self._measure(thread)
            self.monitor.add_event(it)
            self._alarm_beside(it)
            if isinstance(it, events.Sampled | events.UnitFound):
                self.guided.add_event(it)
            if isinstance(it, events.UnitFound):
                self.writing.starts.begin_unit(it)
            if isinstance(it, events.UnitFound) and it.another:
                self._clear_unit()
                self.fault_history.clear()
            self.actions.add_event(it)
            self.freeze_frames.add_event(it)
            self.freeze_frames.follow(it.time)
            if isinstance(it, events.StateChanged):
                self.connection.state_known()
            elif isinstance(it, events.ClockChanged):
                self._follow_date()

    def _alarm_beside(self, event: events.Event) -> None:
        """Log and record the alarms of the instruments; in the sampling thread."""
        if isinstance(event, events.Sampled):
            for alarm in self.instruments.alarms_of(event):
                self.monitor.add_event(alarm)
                self.recorder.record_event(alarm)

    def _follow_date(self) -> None:
        """Give what this program has kept its dates: the computer's date was set."""
        self.freeze_frames.follow_date()
        self.guided.follow_date()

    def _add_faults(self, reading: events.FaultReading) -> None:
        """Add a reading of the session's; in the sampling thread."""
        faults = [self.catalog.fault(code) for code in reading.codes]
        self.fault_history.add(faults, reading.time, routine=reading.routine)

    def _on_faults(self, reading: events.FaultReading, before: events.FaultReading | None) -> None:
        """Pass on a reading of the stored faults; in the sampling thread."""
        self.session.faults.know(reading)
        self.recorder.recorder.record_event(reading)
        self.freeze_frames.keep_frames_of(reading, before)
        if before is not None and set(reading.codes) != set(before.codes):
            added = tuple(code for code in reading.codes if code not in before.codes)
            self.monitor.log(replace(reading, added=added))

    def _on_end(self, thread: SamplingThread, error: MikasError | None) -> None:
        """Note that sampling ended by itself; in the sampling thread."""
        if thread is self.connection.thread:
            self.monitor.end_connection(thread.now(), error)
            self.connection.state_known()

    def _clear_unit(self) -> None:
        """Drop the data read from the unit, and the confirmations for it."""
        self.freeze_frames.finish()
        self.fault_history.disconnect()
        self.confirmations.clear()
        self.info = self.supported = None
        self.write_lock.close()

    def _measure(self, thread: SamplingThread) -> None:
        now, ecu = thread.now(), thread.acquisition.ecu
        with self.monitor.lock:
            self.monitor.meters.wire(now, self.session.wire_bytes)
            if ecu is not None:
                self.monitor.count_failures(tuple(ecu.tester.statistics.failures.copy()), now)
