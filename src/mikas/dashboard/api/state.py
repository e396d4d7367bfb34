"""The state of everything as the band at the top of the page shows it: models and their values."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, Field

from mikas import unkept
from mikas.catalog.ignition_only import absent_channels
from mikas.client.parameters.polling import Method
from mikas.commands.unit import version_text
from mikas.dashboard.api.errors import OptionalTexts, TwoTexts, made_of, two
from mikas.dashboard.api.instruments.models import InstrumentNow, instruments_now
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.errors import ADVICE
from mikas.dashboard.security.control import Client
from mikas.dashboard.session.port_threads import SamplingThread
from mikas.dashboard.settings import PortSettings
from mikas.i18n import Text
from mikas.sampling.alarms import Side
from mikas.sampling.events import AlarmChanged

Line = Literal["off", "no-port", "no-echo", "echo-only", "ecu-alive", "sampling"]


class PlannedChannel(BaseModel):
    """A channel and its divisor: 1 means every cycle, 10 every tenth."""

    name: str = Field(min_length=1, max_length=40, examples=["TWAT"])
    every: int = Field(1, ge=1, le=1000)


class SampledChannel(PlannedChannel):
    """A channel of the plan, and in how many cycles it is read once."""

    cycles: int = Field(
        description="more than `every` where each channel costs time and others come first"
    )


class PlanInfo(BaseModel):
    """The plan of sampling. `first`: channels that come first where each costs time."""

    wanted: list[SampledChannel]
    first: list[str]
    method: Method
    rate: float | None = Field(description="readings a second at most; null: as fast as possible")


class RunningRecording(BaseModel):
    """The recording in progress."""

    file: str
    since: float | None
    bytes: int
    samples: int
    gaps: int
    failure: TwoTexts | None = Field(description="why it broke off; null: it did not")


class ActiveAlarm(BaseModel):
    """A channel beyond a limit."""

    name: str
    level: Literal["warning", "danger"]
    side: Side
    value: float
    limit: float
    since: float


class PauseNow(BaseModel):
    """The least time from a response to the next request, in seconds."""

    chosen: float | None = Field(description="null: found by trying")
    seconds: float | None = Field(description="in force; null: no unit has answered")


class ControlHolder(BaseModel):
    """The client in control. `you`: the client that asked."""

    id: str = Field(description="a mark of that client, new at each start; it gives no rights")
    name: str
    you: bool


class OwnState(BaseModel):
    """The fields that differ between clients, or change at every moment."""

    controller: ControlHolder | None = None
    rights: Literal["control", "view"] = "view"
    viewers: int = 0
    now: float = 0.0


class State(OwnState):
    """The state of everything. Times are UNIX seconds, by the present date."""

    line: Line
    text: TwoTexts
    reason: OptionalTexts = Field(description="the error with advice, while it lasts")
    reason_code: str | None = Field(description="the class of that error: NoEcho…")
    since: float
    port: str | None
    checking: bool = Field(description="a connection check has the port; line is off meanwhile")
    surveying: bool = Field(description="a survey has the port; line is off meanwhile")
    pause: PauseNow | None = Field(description="null: not connected")
    adapter: str
    model: OptionalTexts
    version_code: str | None = Field(description="hex, as 0A")
    passport: list[str | None] | None
    method: str | None = Field(description="in use; plan.method is the requested one")
    rates: dict[str, float] = Field(description="readings a second of each measured method")
    rate: float
    bus_load: float
    errors_minute: int
    errors: int
    samples: int
    plan: PlanInfo
    dropped_parameters: list[str]
    absent: list[str] = Field(
        description="channels that the unit does not have, as found from the values: it controls "
        "the ignition alone; empty: it has them all, or that is not certain"
    )
    recording: RunningRecording | None
    alarms: list[ActiveAlarm]
    alarm_count: int = Field(description="alarms that began since the connection was made")
    catalog: str = Field(description="the version of the catalog in use")
    fault_count: int | None = Field(description="as last read; null: not read yet")
    fault_time: float | None = Field(description="of that reading")
    unlocked_until: float | None
    instruments: list[InstrumentNow] = Field(description="beside the unit")
    instruments_version: int = Field(
        description="counts the changes of the instruments and their definitions"
    )
    demo: bool
    lan: bool
    unkept: int = Field(
        description="kinds of things that can't be saved: a sentence for each is in `problems` of "
        "`/api/about`"
    )


_NO_LINE: Line = "off"
_OFF = Text("not connected", "не подключено")
_OPENING = Text("opening the port", "открываем порт")
_STOPPED = Text("stopped", "остановлено")
_CHECKING = Text("connection check", "проверка связи")
_SURVEYING = Text("survey of the unit", "обследование блока")


def state_of(dashboard: Dashboard, client: Client) -> State:
    """Return the state of everything, as `client` sees it."""
    return shared_state(dashboard).model_copy(update=dict(own_state(dashboard, client)))


def own_state(dashboard: Dashboard, client: Client) -> OwnState:
    """Return the part of the state that `client` alone sees so, or only now."""
    held = dashboard.control.holder
    return OwnState(
        controller=ControlHolder(id=held.handle, name=held.name, you=held.id == client.id)
        if held
        else None,
        rights="control" if client.may_control else "view",
        viewers=dashboard.control.viewers,
        now=dashboard.connection.date(),
    )


def shared_state(dashboard: Dashboard) -> State:
    """Return the part of the state that is the same for all clients."""
    monitor, connection, request = dashboard.monitor, dashboard.connection, dashboard.plan.request
    # Read each of these once: another thread may set it to None.
    thread, now, port = connection.thread, connection.now(), connection.port
    later = connection.later
    stored, unlocked = dashboard.fault_history.latest, dashboard.write_lock.left
    cycles = dashboard.plan.cycles(thread.acquisition.plan if thread is not None else None)
    instruments = instruments_now(dashboard)
    recording = _recording(dashboard)  # not under the monitor's lock: the recorder logs files there
    with monitor.lock:
        checking = dashboard.diagnosis is not None
        surveying = dashboard.surveys.runs
        text, line = _CHECKING if checking else _SURVEYING if surveying else _OFF, _NO_LINE
        if thread is not None and thread.ended:
            text = _STOPPED
        elif thread is not None:
            line = monitor.line.value if monitor.line else "no-port"
            text = monitor.line.text if monitor.line else _OPENING
        sampling = line == "sampling"
        silent, unit, error = monitor.silent(now), monitor.unit, monitor.error
        return made_of(
            State,
            monitor,
            **dict(OwnState()),
            line=line,
            text=text,
            reason=ADVICE.text(error) if error else silent,
            since=monitor.since + later,
            reason_code=type(error).__name__ if error else None,
            port=port.shown if port else None,
            checking=checking,
            surveying=surveying,
            pause=_pause(dashboard, port, thread),
            adapter=thread.adapter if thread else "",
            model=unit.model if unit else None,
            version_code=version_text(unit.version_code) if unit else None,
            passport=[*unit.passport.program, *unit.passport.data]
            if unit and unit.passport
            else None,
            rate=round(monitor.meters.rate(now), 2) if sampling and not silent else 0.0,
            bus_load=round(monitor.meters.load(thread.baud if thread else 9600), 3),
            errors_minute=monitor.meters.errors_minute(now),
            errors=monitor.meters.errors,
            samples=monitor.session.samples,
            plan=PlanInfo(
                wanted=[
                    SampledChannel(name=name, every=every, cycles=cycles.get(name, every))
                    for name, every in request.every.items()
                ],
                first=list(request.first),
                method=request.method,
                rate=request.rate,
            ),
            dropped_parameters=list(monitor.dropped),
            absent=list(absent_channels(dashboard.catalog))
            if monitor.injection.ignition_only
            else [],
            recording=recording,
            alarms=[_alarm(dashboard, it.moved(later)) for it in monitor.shown_alarms],
            catalog=dashboard.catalog.version,
            fault_count=len(stored.faults) if stored else None,
            fault_time=stored.time + later if stored else None,
            unlocked_until=None if unlocked is None else now + later + unlocked,
            instruments=instruments,
            instruments_version=dashboard.instruments.version,
            demo=connection.is_demo,
            lan=dashboard.lan,
            unkept=len(unkept.sentences()),
        )


def _recording(dashboard: Dashboard) -> RunningRecording | None:
    status = dashboard.recorder.recorder.status
    if status is None:
        return None
    failure = two(ADVICE.text(status.failure)) if status.failure else None
    since = None if status.since is None else status.since + dashboard.connection.later
    return made_of(RunningRecording, status, file=status.path.name, since=since, failure=failure)


def _pause(
    dashboard: Dashboard, port: PortSettings | None, thread: SamplingThread | None
) -> PauseNow | None:
    if port is None:
        return None
    setting = port.applied(dashboard.settings.connection).pause
    ecu = thread.acquisition.ecu if thread is not None else None
    return PauseNow(
        chosen=None if setting == "auto" else setting,
        seconds=None if ecu is None else ecu.tester.pauses.seconds,
    )


def _alarm(dashboard: Dashboard, event: AlarmChanged) -> ActiveAlarm:
    latest = dashboard.monitor.latest.get(event.name)
    value = event.value if latest is None else float(latest.value)
    return made_of(ActiveAlarm, event, value=value, since=event.time)
