"""The state, made of what the hub knows; and what of it belongs to one client."""

from __future__ import annotations

from mikas.catalog import Level
from mikas.dashboard.advice import ADVICE
from mikas.dashboard.api.errors import two, two_or_none
from mikas.dashboard.dashboard import Hub
from mikas.dashboard.happenings import passport
from mikas.dashboard.security.control import Client
from mikas.dashboard.state import (
    AlarmOfState,
    Holder,
    Line,
    PlanOfState,
    RecordingOfState,
    State,
    WantedOne,
)
from mikas.i18n import Text
from mikas.sampling.alarms import AlarmChanged

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


def holder_of(hub: Hub, client: Client) -> Holder | None:
    """Who has the seat; `client` is told whether it is itself."""
    held = hub.seat.holder
    if held is None:
        return None
    return Holder(id=held.id, name=held.name, you=held.id == client.id)


def _shared(hub: Hub) -> State:
    """What is the same for all."""
    story, session, now = hub.story, hub.session, hub.now()
    # Any of these may be gone at a second look.
    way, page, unlocked = hub.way, hub.fault_book.page, hub.lock.left
    recording = _recording(hub)  # not under the story's lock: the recorder tells the story of files
    with story.lock:
        text, line = _OFF, _NO_LINE
        if session is not None and session.ended:
            text = _STOPPED
        elif session is not None:
            line = story.line.value if story.line else "no-port"
            text = story.line.text if story.line else _OPENING
        sampling = line == "sampling"
        silent = story.silent(now)
        unit = story.unit
        return State(
            line=line,
            text=two(text),
            reason=two_or_none(story.reason or silent),
            reason_code=story.reason_code,
            since=story.since,
            port=way.url if way else None,
            adapter=session.adapter if session else "",
            model=two_or_none(story.model),
            version_code=unit.version_code if unit else None,
            passport=passport(unit) if unit else None,
            method=story.method,
            rates=story.rates,
            rate=round(story.meters.rate(now), 2) if sampling and not silent else 0.0,
            bus_load=round(story.meters.load(session.baud if session else 9600), 3),
            errors_minute=story.meters.errors_minute(now),
            errors=story.meters.errors,
            samples=story.meters.samples,
            plan=PlanOfState(
                wanted=[WantedOne(name=n, every=every) for n, every in hub.wish.every.items()],
                method=hub.wish.method or "auto",
                rate=hub.wish.rate,
            ),
            dropped_parameters=list(story.dropped),
            recording=recording,
            alarms=[_alarm(hub, it) for it in story.alarms_seen],
            alarm_count=story.alarm_count,
            fault_count=len(page.faults) if page else None,
            unlocked_until=None if unlocked is None else now + unlocked,
            demo=hub.is_demo,
            lan=hub.lan,
        )


def _recording(hub: Hub) -> RecordingOfState | None:
    status = hub.recording.recorder.status
    if status is None:
        return None
    return RecordingOfState(
        file=status.path.name,
        since=status.since,
        bytes=status.bytes,
        samples=status.samples,
        gaps=status.gaps,
        failure=two_or_none(ADVICE.text(status.failure) if status.failure else None),
    )


def _alarm(hub: Hub, event: AlarmChanged) -> AlarmOfState:
    name = event.channel.name
    return AlarmOfState(
        name=name,
        level="danger" if event.level is Level.DANGER else "warning",
        side=event.side.value,
        value=hub.story.latest.get(name, event.value),
        limit=event.limit,
        since=event.time,
    )
