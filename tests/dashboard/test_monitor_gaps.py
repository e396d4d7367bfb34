"""Gaps: each has an end and a reason, also at the end of a connection."""

from __future__ import annotations

from dashboard.rig import ADAPTER
from mikas.dashboard.errors import ADVICE
from mikas.dashboard.session.connection import OTHER_REQUEST
from mikas.dashboard.session.history import History, reason_of
from mikas.dashboard.session.monitor import (
    DISCONNECTED,
    OTHER_PLAN,
    SILENT,
    ConnectionMonitor,
)
from mikas.errors import EchoOnly, NoResponse
from mikas.sampling.events import CycleFailed, LineState, PlanChanged, Sampled, StateChanged
from mikas.sampling.session import SamplingSession


def take(monitor, event):
    """Let the monitor take `event`, and the gaps that its session finds."""
    for each in monitor.session.events_of(event):
        monitor.add_event(each)


def connected():
    monitor = ConnectionMonitor(History(), SamplingSession())
    take(monitor, StateChanged(0.0, LineState.SAMPLING, None))
    return monitor


def gaps(monitor):
    return [
        (it.began, it.ended, reason_of(it).en)
        for it in monitor.logged
        if it.kind == "gap" and it.ended is not None
    ]


def sample(monitor, *times):
    for time in times:
        take(monitor, Sampled(time, {}, {}))


def test_two_sessions_have_a_gap_between_them_and_its_reason():
    monitor = connected()
    sample(monitor, 1.0, 1.1)
    monitor.end_connection(1.5, None, DISCONNECTED)
    monitor.begin((), 60.0)
    sample(monitor, 61.0, 61.1)
    assert gaps(monitor) == [(1.1, 61.0, DISCONNECTED.en)]


def test_a_gap_that_is_open_when_the_session_ends_ends_with_it():
    monitor = connected()
    sample(monitor, 1.0)
    take(monitor, CycleFailed(2.0, EchoOnly()))
    monitor.end_connection(5.0, None, DISCONNECTED)
    assert gaps(monitor) == [(1.0, 5.0, ADVICE.text(EchoOnly()).en)]
    monitor.begin((), 6.0)
    take(
        monitor, CycleFailed(7.0, NoResponse(seconds=0.5))
    )  # a cycle that failed before the first sample
    sample(monitor, 8.0)
    assert gaps(monitor)[1:] == [
        (5.0, 7.0, DISCONNECTED.en),
        (7.0, 8.0, ADVICE.text(NoResponse(seconds=0.5)).en),
    ]


def test_a_session_that_ended_by_itself_says_why():
    monitor = connected()
    sample(monitor, 1.0)
    monitor.end_connection(2.0, EchoOnly())
    monitor.end_connection(9.0, None, DISCONNECTED)
    monitor.begin((), 10.0)
    sample(monitor, 11.0)
    assert gaps(monitor) == [(1.0, 11.0, ADVICE.text(EchoOnly()).en)]


def test_a_long_pause_for_a_plan_is_reported_and_a_short_one_is_not():
    monitor = connected()
    sample(monitor, 1.0, 1.1)
    take(monitor, PlanChanged(1.3, _Plan()))
    sample(monitor, 1.5)
    assert gaps(monitor) == []
    take(monitor, PlanChanged(2.7, _Plan()))
    sample(monitor, 2.8)
    assert gaps(monitor) == [(1.5, 2.8, OTHER_PLAN.en)]
    sample(monitor, 9.0)  # seldom, and without a new plan
    assert len(gaps(monitor)) == 1


class _Plan:
    method = "batch"


def test_a_gap_that_begins_vaguely_ends_with_what_it_was():
    monitor = connected()
    sample(monitor, 1.0)
    take(monitor, CycleFailed(2.0, NoResponse(seconds=0.5)))
    take(monitor, StateChanged(3.0, LineState.ECHO_ONLY, EchoOnly()))
    sample(monitor, 9.0)
    assert gaps(monitor) == [(1.0, 9.0, ADVICE.text(EchoOnly()).en)]


def test_silence_is_reported_before_its_reason_is_known():
    monitor = connected()
    sample(monitor, 1.0, 1.2)
    assert monitor.silent(3.0) is None
    assert monitor.silent(3.7) == SILENT
    monitor.session.pause(OTHER_REQUEST)
    assert monitor.silent(3.7) == OTHER_REQUEST
    take(monitor, CycleFailed(4.0, NoResponse(seconds=0.5)))
    assert monitor.silent(4.1) == ADVICE.text(NoResponse(seconds=0.5))
    sample(monitor, 4.2)
    assert monitor.silent(4.3) is None
    sample(monitor, 14.2)  # a slow plan
    assert monitor.silent(30.0) is None
    take(monitor, StateChanged(50.0, LineState.ECHO_ONLY, EchoOnly()))
    assert monitor.silent(99.0) is None  # the state itself says it


def test_while_nothing_comes_the_state_says_so(idle):
    idle.dashboard.connection.thread.stop()
    idle.cars.clock.sleep(3600)
    state = idle.get("/state")
    assert (state["line"], state["rate"]) == ("sampling", 0)
    assert state["reason"]["ru"]


def _closed(it):
    events = it.get("/history", seconds=7200)["events"]
    found = [event for event in events if event["kind"] == "gap"]
    ended = {event["began"] for event in found if event["ended"] is not None}
    assert {event["began"] for event in found} == ended
    return [event for event in found if event["ended"] is not None]


def test_a_pulled_adapter_and_a_new_connection_are_gaps_in_a_row(idle):
    idle.cars.pull()
    idle.until(lambda it: it["state"]["line"] == "no-port")
    idle.post("/connect", {"port": ADAPTER.url})  # first: the other would come back otherwise
    idle.cars.put_back()
    idle.sampling()
    pulled, between, *_ = _closed(idle)
    assert pulled["ended"] == between["began"]
    assert "connection" in between["reason"]["en"]


def test_a_disconnection_is_a_gap_with_its_reason(idle):
    idle.post("/disconnect")
    idle.post("/connect", {"port": "sim:?scenario=warm-idle"})
    idle.sampling()
    (gap,) = _closed(idle)
    assert gap["reason"] == {"en": DISCONNECTED.en, "ru": DISCONNECTED.ru}
