"""A session: what follows from several events, on one connection and from one to the next."""

from __future__ import annotations

from contextlib import closing

import pytest

from mikas.client import Passport
from mikas.client.connecting import ConnectionOptions
from mikas.client.identity import UnitIdentity
from mikas.errors import NoResponse
from mikas.i18n import Text
from mikas.link.reconnecting import ReconnectingPort
from mikas.recording.recorder import Recorder
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import (
    CycleFailed,
    Event,
    FaultReading,
    Gap,
    LineState,
    Sampled,
    StateChanged,
    UnitFound,
)
from mikas.sampling.session import SamplingSession

OPTIONS = ConnectionOptions()
LOST = NoResponse(seconds=0.5)
LEFT = Text("left", "закрыто")


def follow(session: SamplingSession, *events: Event) -> list[Event]:
    return [each for event in events for each in session.events_of(event)]


def run(session: SamplingSession, recorder: Recorder, *, seconds: float, settings: str = ""):
    port = ReconnectingPort(f"sim:?clock=simulated{settings}", sink=recorder)
    acquisition = Acquisition(
        port, OPTIONS.create_ecu, OPTIONS.catalog, ["FREQ", "MINERR"], method="batch", rate=5
    )
    with closing(session.run(acquisition)) as events:
        for event in events:
            yield event
            if event.time > seconds:
                return


def test_a_gap_comes_before_the_event_that_begins_or_ends_it_and_is_recorded_before():
    got: list[Event] = []
    session = SamplingSession(got.append)
    values, failed, back = Sampled(1.0, {}, {}), CycleFailed(2.0, LOST), Sampled(4.0, {}, {})
    began, ended = Gap(1.0, 1.0, None, LOST.reason), Gap(4.0, 1.0, 4.0, LOST.reason)
    assert follow(session, values, failed, back) == [values, began, failed, ended, back]
    assert got == [values, began, failed, ended, back]
    assert session.samples == 2


def test_the_recorder_gets_an_open_gap_again_with_a_better_reason():
    got: list[Event] = []
    session = SamplingSession(got.append)
    broken = StateChanged(3.0, LineState.NO_PORT)
    seen = follow(session, Sampled(1.0, {}, {}), CycleFailed(2.0, LOST), broken)
    assert [it.reason for it in seen if isinstance(it, Gap)] == [LOST.reason]
    recorded = [it.reason for it in got if isinstance(it, Gap)]
    assert recorded == [LOST.reason, LineState.NO_PORT.text]


def test_the_gap_between_two_connections_has_its_reason():
    session = SamplingSession()
    follow(session, Sampled(1.0, {}, {}))
    assert session.leave(2.0, LEFT) == []
    gap, _ = follow(session, Sampled(9.0, {}, {}))
    assert gap == Gap(9.0, 1.0, 9.0, LEFT)


def test_the_unit_is_known_for_the_next_connection():
    session = SamplingSession()
    follow(session, UnitFound(1.0, 0x0A, Passport(("A", "B", "C"), ("D",))))
    assert session.unit == UnitIdentity(0x0A, Passport(("A", "B", "C"), ("D",)))


@pytest.mark.parametrize("echo", ["1", "0"])
def test_the_wire_carries_a_request_once_with_an_echo_or_without(echo):
    recorder = Recorder()
    session = SamplingSession(recorder.record_event)
    list(run(session, recorder, seconds=5.0, settings=f"&echo={echo}"))
    assert session.samples > 20
    assert 350 < session.wire_bytes < 450  # 600 if the echo were counted, too


def test_faults_are_read_when_they_may_have_changed_and_come_before_the_next_event():
    recorder = Recorder()
    events = list(
        run(SamplingSession(recorder.record_event), recorder, seconds=8.0, settings="&faults=13")
    )
    readings = [it for it in events if isinstance(it, FaultReading)]
    assert {it.codes for it in readings} == {(13,)}
    assert len(readings) == 2
    for reading in readings:
        following = events[events.index(reading) + 1]
        assert following.time >= reading.time


def test_faults_are_not_read_where_they_are_not_wanted():
    recorder = Recorder()
    session = SamplingSession(recorder.record_event)
    session.wants_faults = lambda: False
    events = run(session, recorder, seconds=8.0, settings="&faults=13")
    assert not [it for it in events if isinstance(it, FaultReading)]
