"""Sampling by a program that was suspended: no old value, and one gap of the true length.

The same events are the notes of the recording, the lines of `watch`, the API's and MQTT's.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing

import numpy as np
import pytest
from sampling_harness import ecu_factory, of

from mikas.client.parameters.polling import FIXED_METHODS
from mikas.errors import ReadingSuspended
from mikas.link.reconnecting import ReconnectingPort
from mikas.link.suspension import SuspensionGuard
from mikas.publish.outbox import MessageKind
from mikas.publish.publication import Publication
from mikas.publish.topics import Topics
from mikas.recording.recorder import Recorder
from mikas.recording.recording import Recording
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import CycleFailed, Event, Gap, Sampled, UnitFound
from mikas.sampling.session import SamplingSession
from mikas.virtual.bus import Bus
from mikas.virtual.ecu import VirtualEcu
from mikas.virtual.quirks import EcuQuirks
from mikas.virtual.responder import Identity, Responder
from protocol_codes import SECTION_4
from suspended import PLACES, ClockCar, StoppingLink, age
from virtual_harness import DATA, IDENTITY

OLDEST = 0.6  # s; half a second, and the tenth in which the car gives the time
STOP = 30.0
NAMES = ["INJ", "JAIR", "UGB", "TWAT"]  # the first three are the car's time


def car(identity: Identity = IDENTITY) -> Bus:
    responder = Responder(ClockCar(DATA, faults=[13], rpm=850.0), identity, EcuQuirks())
    return Bus(VirtualEcu(responder))


class Session:
    """A session that records to `file`, with a port whose program stops."""

    def __init__(self, file, *stops, where="waiting", method="batch", rate=None, bus=None) -> None:
        self.bus = bus or car()
        self.recorder = Recorder()
        self.recorder.start(file, url="sim:")
        self.port = ReconnectingPort(
            "sim:?clock=simulated",
            open_port=lambda _: SuspensionGuard(StoppingLink(self.bus, stops, where)),
            clock=lambda: 0.0,
            sink=self.recorder,
        )
        self.session = SamplingSession(self.recorder.record_event)
        self.acquisition = Acquisition(
            self.port, ecu_factory(), SECTION_4, NAMES, method=method, rate=rate
        )

    def until(self, time: float) -> list[Event]:
        with closing(self.events(time)) as events:
            return list(events)

    def events(self, until: float) -> Iterator[Event]:
        with closing(self.session.run(self.acquisition)) as events:
            for event in events:
                yield event
                if event.time > until:
                    break
        self.recorder.stop()


def ages(events: list[Event]) -> list[float]:
    return [
        age(reading.raw, reading.time)
        for sample in of(Sampled, events)
        for name, reading in sample.fresh.items()
        if name != "TWAT"
    ]


def assert_one_gap(events: list[Event]) -> None:
    began, ended = of(Gap, events)
    assert began.ended is None
    assert isinstance(ended.error, ReadingSuspended)
    assert 8 < ended.began < 16  # a stream writes only for the faults, each 15 s
    assert STOP - 0.5 < ended.ended - ended.began < STOP + 4
    assert "did not run for 30." in ended.reason.en or "did not run for 29.9" in ended.reason.en
    times = [sample.time for sample in of(Sampled, events)]
    assert not [time for time in times if ended.began < time < ended.ended]


@pytest.mark.parametrize("method", [*FIXED_METHODS, "auto"])
@pytest.mark.parametrize("where", PLACES)
def test_no_value_is_old_and_the_gap_is_said_once(method, where, tmp_path):
    session = Session(tmp_path / "a.pcapng", (10.0, STOP), where=where, method=method)
    events = session.until(50.0)
    assert_one_gap(events)
    found = ages(events)
    assert len(found) > 100
    assert -0.2 < min(found) <= max(found) < OLDEST
    assert len(of(UnitFound, events)) == 1


@pytest.mark.parametrize("method", ["single", "batch", "list", "stream", "stroke0"])
def test_the_recording_has_no_old_value_and_the_gap(method, tmp_path):
    file = tmp_path / "a.pcapng"
    Session(file, (10.0, STOP), method=method).until(50.0)
    recording = Recording(file, SECTION_4)
    rows, _ = recording.window(*recording.span, 100_000, ["INJ"])
    (gap,) = [it for it in recording.events if isinstance(it, Gap) and it.ended is not None]
    old = rows.times - rows.values["INJ"] * 12.5
    assert len(old) > 100
    assert -0.2 < np.nanmin(old) <= np.nanmax(old) < OLDEST
    assert STOP - 0.5 < gap.ended - gap.began < STOP + 4
    assert "did not run" in gap.reason.en


def test_a_slow_rate_has_its_gap_too(tmp_path):
    session = Session(tmp_path / "a.pcapng", (10.2, STOP), rate=1.0)
    events = session.until(50.0)
    assert_one_gap(events)
    assert max(ages(events)) < OLDEST


@pytest.mark.parametrize("method", ["single", "batch", "list", "stream", "stroke0"])
@pytest.mark.parametrize("seconds", [0.3, 0.6, 0.9])
def test_a_busy_computer_causes_no_gap_and_no_value_older_than_half_a_second(
    method, seconds, tmp_path
):
    stops = [(6.0 + 1.7 * number, seconds) for number in range(6)]
    streams = method.startswith("str")  # these are used otherwise only to end them
    for where in ("waiting",) if streams else PLACES:
        session = Session(tmp_path / f"{where}.pcapng", *stops, where=where, method=method)
        events = session.until(20.0)
        assert not of(Gap, events)
        assert not of(CycleFailed, events)
        assert max(ages(events)) < OLDEST
        if not streams:  # one value is lost, and no passport is read
            times = [sample.time for sample in of(Sampled, events) if sample.time > 5.0]
            assert np.diff(times).max() < seconds + 0.8


@pytest.mark.parametrize("method", ["single", "batch", "list", "stream"])
def test_the_plug_in_another_car_meanwhile_gives_no_value_before_that_is_known(method, tmp_path):
    session = Session(tmp_path / "a.pcapng", (10.0, STOP), method=method)
    other = Identity(0x0A, ("ANOTHER", *IDENTITY.passports[1:]))
    events: list[Event] = []
    for event in session.events(60.0):
        events.append(event)
        if event.time > 9.5 and session.bus.ecu.responder.identity is IDENTITY:
            session.bus.ecu.responder.identity = other
            if method == "stream":  # that unit sends nothing of its own accord
                session.bus.ecu.__init__(session.bus.ecu.responder)
    _first, second = of(UnitFound, events)
    assert second.another
    assert not [it for it in of(Sampled, events) if 10.5 < it.time < second.time]


def test_a_stop_while_connecting_is_no_error_of_the_unit(tmp_path):
    for after in (0.0, 0.1, 0.3, 0.6, 0.8, 1.0):
        session = Session(tmp_path / f"{after}.pcapng", (after, STOP))
        events = session.until(STOP + 8)
        assert of(Sampled, events), after
        assert max(ages(events)) < OLDEST


@pytest.mark.parametrize("after", [1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0])
def test_a_stop_while_the_methods_are_measured_costs_none_of_them(after, tmp_path):
    session = Session(tmp_path / "a.pcapng", (after, STOP), method="auto")
    events = session.until(STOP + 15)
    assert session.acquisition.method == "stream"
    assert max(ages(events)) < OLDEST


def test_mqtt_gets_the_gap(tmp_path):
    session = Session(tmp_path / "a.pcapng", (10.0, STOP))
    publication = Publication(Topics("mikas"), SECTION_4, session.acquisition.channels)
    sent = [message for event in session.until(50.0) for message in publication.messages_of(event)]
    gaps = [it for it in sent if it.kind is MessageKind.EVENT and b'"kind":"gap"' in it.payload]
    assert len(gaps) == 2
    assert all(b"did not run" in it.payload for it in gaps)
