"""Connections and diagnoses that were stopped, and the state while they change."""

from __future__ import annotations

import threading
from math import inf
from types import SimpleNamespace

import pytest

from mikas.dashboard.api.state import shared_state
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.errors import InternalError
from mikas.dashboard.security.control import Client
from mikas.dashboard.session.history import StoredFaults
from mikas.dashboard.session.port_threads import Diagnosis, SamplingThread
from mikas.dashboard.settings import PlanSettings, PortSettings, Settings
from mikas.errors import LinkLost
from mikas.link import open_link
from mikas.recording.recorder import Recorder
from mikas.sampling.events import LineState, Sampled, StateChanged


class OneThat:
    """A session that lives on a clock that stands."""

    adapter, baud, ended = "", 9600, False
    acquisition = SimpleNamespace(ecu=None)

    def now(self):
        return 5.0


def dashboard_of(tmp_path, **more):
    return Dashboard(Settings(tmp_path, state=tmp_path, **more))


def test_events_of_an_earlier_session_are_not_of_this_one(tmp_path):
    dashboard = dashboard_of(tmp_path)
    dashboard.connection.state_known = lambda: None
    dashboard.connection.thread, before = OneThat(), OneThat()
    dashboard._on_event(before, StateChanged(1.0, LineState.NO_ECHO, None))  # noqa: SLF001
    dashboard._on_end(before, None)  # noqa: SLF001
    assert dashboard.monitor.line is None
    assert dashboard.monitor.logged == []
    dashboard._on_event(dashboard.connection.thread, StateChanged(2.0, LineState.SAMPLING, None))  # noqa: SLF001
    assert dashboard.monitor.line is LineState.SAMPLING


class Opening:
    """Opens a simulated port; meanwhile it stops whoever wanted that."""

    def __init__(self, tmp_path):
        self.settings = Settings(tmp_path, state=tmp_path, open_port=self.open_port)
        self.sent = []

    def open_port(self, url):
        self.link = open_link("sim:?clock=simulated")
        self.link.bus.send = lambda data, now: self.sent.append(data)
        self.wanting.stop()
        return self.link


def test_a_port_that_opens_after_the_end_of_sampling_is_closed_at_once(tmp_path):
    opening = Opening(tmp_path)
    opening.wanting = SamplingThread(
        PortSettings("sim:"),
        opening.settings,
        PlanSettings({"FREQ": 1}),
        sink=Recorder(),
        confirm=lambda _: False,
        on_event=lambda *_: None,
        on_end=lambda *_: None,
    )
    link = opening.wanting._stoppable.open("sim:")  # noqa: SLF001
    with pytest.raises(LinkLost):
        link.write(b"\x00")


@pytest.mark.parametrize("method", ["stream", "stroke0"])
@pytest.mark.parametrize("stopped", ["while the unit sends", "before it sends"])
def test_the_unit_sends_no_stream_when_sampling_has_ended(tmp_path, method, stopped):
    """The next program would find a busy line (D12)."""
    link = open_link("sim:?clock=simulated")
    write, to_stop = link.write, threading.Event()

    def written(data):
        write(data)
        if data[:1] in (b"\x71", b"\x7f") and stopped == "before it sends":
            to_stop.set()
            thread._stoppable.stopping.wait(60)  # noqa: SLF001

    def look(_, event):
        if isinstance(event, Sampled) and link.bus.ecu.next_transmission() < inf:
            to_stop.set()

    link.write = written
    thread = SamplingThread(
        PortSettings("sim:"),
        Settings(tmp_path, state=tmp_path, open_port=lambda _: link),
        PlanSettings({"FREQ": 1, "TWAT": 1}, method),
        sink=Recorder(),
        confirm=lambda _: False,
        on_event=look,
        on_end=lambda *_: None,
    )
    thread.start()
    assert to_stop.wait(60)
    thread.stop()
    link.bus.advance(link.now() + 1)  # what was sent arrives
    assert link.bus.ecu.next_transmission() == inf
    with pytest.raises(LinkLost):
        link.write(b"\x00")


def test_a_port_that_opens_after_the_end_of_the_doctor_is_not_used(tmp_path):
    opening, reported = Opening(tmp_path), []
    opening.wanting = Diagnosis(PortSettings("sim:"), opening.settings)
    opening.wanting.run(reported.append)
    assert (reported, opening.sent) == ([], [])


def test_a_lock_that_closes_while_it_is_looked_at_is_open_or_closed(tmp_path):
    dashboard, times = dashboard_of(tmp_path), iter((0.0, 59.0, 61.0))
    dashboard.write_lock.clock = lambda: next(times)
    dashboard.write_lock.open(Client("me", "", True), 60.0)
    state = shared_state(dashboard)
    assert state.unlocked_until is not None
    assert state.unlocked_until > 0


def test_faults_that_are_forgotten_while_they_are_looked_at_are_counted_or_not(tmp_path):
    class Forgetful:
        pages = iter((StoredFaults(1.0, (), {}), None))
        latest = property(lambda self: next(self.pages))

    dashboard = dashboard_of(tmp_path)
    dashboard.fault_history = Forgetful()
    assert shared_state(dashboard).fault_count == 0


def test_a_bug_at_the_end_of_sampling_leaves_its_reason_and_a_free_port(tmp_path, caplog):
    def broken(thread, error):
        raise ValueError("the bug of this test")

    thread = SamplingThread(
        PortSettings("sim:"),
        Settings(tmp_path, state=tmp_path, open_port=open_link),
        PlanSettings({"FREQ": 1}),
        sink=Recorder(),
        confirm=lambda _: False,
        on_event=broken,
        on_end=broken,
    )
    thread.run()
    assert thread.ended
    assert isinstance(thread.failure, InternalError)
    assert "the bug of this test" in caplog.text
