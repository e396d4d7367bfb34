"""The state of everything as the band at the top of the page shows it: models and their values."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, Field

from mikas.client.polling import Method
from mikas.dashboard.advice import ADVICE
from mikas.dashboard.api.errors import TwoTexts, two, two_or_none
from mikas.dashboard.dashboard import Hub
from mikas.dashboard.security.control import Client
from mikas.i18n import Text
from mikas.sampling.alarms import Side
from mikas.sampling.events import AlarmChanged

Line = Literal["off", "no-port", "no-echo", "echo-only", "ecu-alive", "sampling"]


class PlannedChannel(BaseModel):
    """A channel, and in which cycles it is asked: 1 is every one, 10 every tenth."""

    name: str = Field(min_length=1, max_length=40, examples=["TWAT"])
    every: int = Field(1, ge=1, le=1000)


class PlanInfo(BaseModel):
    """What is asked."""

    wanted: list[PlannedChannel]
    method: Method
    rate: float | None = Field(description="sets a second at most; null: as fast as it goes")


class RunningRecording(BaseModel):
    """The recording that is being made."""

    file: str
    since: float | None
    bytes: int
    samples: int
    gaps: int
    failure: TwoTexts | None = Field(description="why it broke off, if it did")


class ActiveAlarm(BaseModel):
    """A channel that is beyond a limit now."""

    name: str
    level: Literal["warning", "danger"]
    side: Side
    value: float
    limit: float
    since: float


class ControlHolder(BaseModel):
    """Who decides what the line does."""

    id: str
    name: str
    you: bool


class State(BaseModel):
    """Everything at a glance. Times are UNIX seconds of the link's clock."""

    line: Line
    text: TwoTexts
    reason: TwoTexts | None = Field(description="what is wrong and what to try, while it is")
    reason_code: str | None = Field(description="the same as the class of the error: NoEcho…")
    since: float
    port: str | None
    adapter: str
    model: TwoTexts | None
    version_code: int | None
    passport: list[str | None] | None
    method: str | None = Field(description="in use; plan.method is what was asked for")
    rates: dict[str, float] = Field(description="sets a second of each method that was measured")
    rate: float
    bus_load: float
    errors_minute: int
    errors: int
    samples: int
    plan: PlanInfo
    dropped_parameters: list[str]
    recording: RunningRecording | None
    alarms: list[ActiveAlarm]
    alarm_count: int = Field(description="alarms that began since the connection was made")
    fault_count: int | None = Field(description="when they were last read; null: not yet")
    unlocked_until: float | None
    demo: bool
    lan: bool
    controller: ControlHolder | None = None
    rights: Literal["control", "view"] = "view"
    viewers: int = 0
    now: float = 0.0


OWN = ("controller", "rights", "viewers", "now")
"""What differs from client to client, or from moment to moment."""

_NO_LINE: Line = "off"
_OFF = Text("not connected", "не подключено")
_OPENING = Text("opening the port", "открываем порт")
_STOPPED = Text("stopped", "остановлено")


def state_of(hub: Hub, client: Client | None = None) -> State:
    """Everything at a glance, as `client` sees it."""
    state = _shared(hub)
    if client is not None:
        state.rights = "control" if client.may_control else "view"
        state.controller = holder_of(hub, client)
    state.viewers = hub.seat.viewers
    state.now = hub.now()
    return state


def holder_of(hub: Hub, client: Client) -> ControlHolder | None:
    """Who has the seat; `client` is told whether it is itself."""
    held = hub.seat.holder
    if held is None:
        return None
    return ControlHolder(id=held.id, name=held.name, you=held.id == client.id)


def _shared(hub: Hub) -> State:
    """What is the same for all."""
    monitor, session, now = hub.monitor, hub.session, hub.now()
    # Any of these may be gone at a second look.
    way, stored, unlocked = hub.way, hub.fault_history.latest, hub.lock.left
    recording = _recording(hub)  # not under the monitor's lock: the recorder logs its files there
    with monitor.lock:
        text, line = _OFF, _NO_LINE
        if session is not None and session.ended:
            text = _STOPPED
        elif session is not None:
            line = monitor.line.value if monitor.line else "no-port"
            text = monitor.line.text if monitor.line else _OPENING
        sampling = line == "sampling"
        silent = monitor.silent(now)
        unit = monitor.unit
        return State(
            line=line,
            text=two(text),
            reason=two_or_none(monitor.reason or silent),
            reason_code=monitor.reason_code,
            since=monitor.since,
            port=way.url if way else None,
            adapter=session.adapter if session else "",
            model=two_or_none(unit.model if unit else None),
            version_code=unit.version_code if unit else None,
            passport=[*unit.passport.program, *unit.passport.data]
            if unit and unit.passport
            else None,
            method=monitor.method,
            rates=monitor.rates,
            rate=round(monitor.meters.rate(now), 2) if sampling and not silent else 0.0,
            bus_load=round(monitor.meters.load(session.baud if session else 9600), 3),
            errors_minute=monitor.meters.errors_minute(now),
            errors=monitor.meters.errors,
            samples=monitor.meters.samples,
            plan=PlanInfo(
                wanted=[PlannedChannel(name=n, every=every) for n, every in hub.wish.every.items()],
                method=hub.wish.method or "auto",
                rate=hub.wish.rate,
            ),
            dropped_parameters=list(monitor.dropped),
            recording=recording,
            alarms=[_alarm(hub, it) for it in monitor.shown_alarms],
            alarm_count=monitor.alarm_count,
            fault_count=len(stored.faults) if stored else None,
            unlocked_until=None if unlocked is None else now + unlocked,
            demo=hub.is_demo,
            lan=hub.lan,
        )


def _recording(hub: Hub) -> RunningRecording | None:
    status = hub.recording.recorder.status
    if status is None:
        return None
    return RunningRecording(
        file=status.path.name,
        since=status.since,
        bytes=status.bytes,
        samples=status.samples,
        gaps=status.gaps,
        failure=two_or_none(ADVICE.text(status.failure) if status.failure else None),
    )


def _alarm(hub: Hub, event: AlarmChanged) -> ActiveAlarm:
    value = hub.monitor.latest.get(event.name, event.value)
    return ActiveAlarm.model_validate(event.as_json() | {"value": value, "since": event.time})
