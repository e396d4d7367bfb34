"""Connecting to the ECU: the states reported, the unit found, and that time goes on."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from itertools import pairwise

import pytest
from sampling_harness import (
    SAMPLES,
    SimulatedPlug,
    assert_values_are_the_units,
    ecu_factory,
    enough,
    make_sampler,
    of,
    settled,
    take,
)

from mikas.errors import (
    AnotherAdapter,
    EchoOnly,
    LineError,
    LinkLost,
    NoEcho,
    NotAKLineAdapter,
    PortBusy,
    PortNotFound,
)
from mikas.link import Link, Port
from mikas.link.reconnecting import ReconnectingPort, _SteadyLink
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import (
    AdapterMoved,
    CycleFailed,
    LineState,
    MethodChosen,
    PlanChanged,
    Sampled,
    StateChanged,
    UnitFound,
)
from mikas.virtual.bus import AdapterKind
from mikas.virtual.fault_injector import FaultInjector, LineFault
from mikas.virtual.quirks import EcuQuirks
from mikas.virtual.responder import Identity
from protocol_codes import SECTION_4
from virtual_harness import IDENTITY, PASSPORTS, make_bus


class TestStrict:
    def test_a_strict_run_without_a_port_ends_with_its_error(self):
        plug = SimulatedPlug(make_bus())
        plug.plugged_in = False
        with pytest.raises(PortNotFound):
            list(make_sampler(plug, strict=True).run())

    def test_a_strict_run_without_supply_ends_with_its_error(self):
        plug = SimulatedPlug(make_bus(adapter=AdapterKind(supplied=False)))
        with pytest.raises(NoEcho):
            list(make_sampler(plug, strict=True).run())

    def test_a_strict_run_without_ignition_ends_with_its_error(self):
        bus = make_bus()
        bus.ecu.responder.car.on = False
        with pytest.raises(EchoOnly):
            list(make_sampler(SimulatedPlug(bus), strict=True).run())

    def test_a_strict_run_on_a_bad_line_ends_with_its_error(self):
        bus = make_bus(fault_injector=FaultInjector({LineFault.DAMAGED: 1.0}))
        with pytest.raises(LineError):
            list(make_sampler(SimulatedPlug(bus), strict=True).run())

    def test_a_strict_run_waits_once_it_had_a_sample(self):
        plug = SimulatedPlug(make_bus())
        car = plug.bus.ecu.responder.car
        with closing(make_sampler(plug, method="batch", strict=True).run()) as events:
            take(events, lambda e: bool(of(Sampled, e)))
            car.on = False
            plug.at(plug.now() + 10, lambda: setattr(car, "on", True))
            take(events, enough)
            plug.pull()
            plug.at(plug.now() + 10, plug.mend)
            take(events, enough)

    def test_the_port_is_let_go(self):
        bus = make_bus()
        bus.ecu.responder.car.on = False
        plug = SimulatedPlug(bus)
        with pytest.raises(EchoOnly):
            list(make_sampler(plug, strict=True).run())
        with pytest.raises(Exception, match="closed"):
            plug.link.read(0)


def test_every_state_on_the_way_is_reported_once():
    plug = SimulatedPlug(make_bus())
    car = plug.bus.ecu.responder.car
    plug.plugged_in = car.on = False
    plug.unsupply()
    plug.at(5, lambda: setattr(plug, "plugged_in", True))
    plug.at(20, plug.mend)
    plug.at(40, lambda: setattr(car, "on", True))
    with closing(make_sampler(plug, method="batch").run()) as events:
        reported = take(events, enough)
    assert [e.state for e in of(StateChanged, reported)] == list(LineState)
    for event in of(StateChanged, reported)[:3]:
        assert event.error is not None
        assert event.state.text.en
        assert event.state.text.ru
    times = [event.time for event in reported]
    assert times == sorted(times)


def test_the_same_state_with_another_error_is_reported():
    plug = SimulatedPlug(make_bus())
    problem = [PortNotFound(url="sim:", found=""), PortBusy(url="sim:"), PortBusy(url="sim:")]
    opened = plug.open

    def open_link():
        if problem:
            raise problem.pop(0)
        return opened()

    plug.open = open_link
    with closing(make_sampler(plug, method="batch").run()) as events:
        reported = take(events, enough)
    assert [type(e.error) for e in of(StateChanged, reported)[:2]] == [PortNotFound, PortBusy]
    assert of(StateChanged, reported)[2].state is LineState.ECU_ALIVE


def test_an_elm327_ends_it():
    from mikas.link.urls import open_link

    plug = ReconnectingPort("sim:?adapter=elm327&clock=simulated", open_port=open_link)
    with pytest.raises(NotAKLineAdapter):
        list(Acquisition(plug, ecu_factory(), SECTION_4, ["FREQ"]).run())


def test_a_lost_adapter_is_a_gap_with_its_reason():
    plug = SimulatedPlug(make_bus())
    with closing(make_sampler(plug, method="batch").run()) as events:
        take(events, enough)
        plug.pull()
        reported = take(events, lambda e: bool(of(StateChanged, e)))
    assert of(CycleFailed, reported)[-1].error is of(StateChanged, reported)[0].error


class TestAnotherCar:
    def moved(self, identity: Identity, **changes: object):
        """The adapter is carried to another car, and stays in the computer."""
        plug = SimulatedPlug(make_bus())
        with closing(make_sampler(plug).run()) as events:
            take(events, settled)
            plug.bus.ecu.responder.car.on = False
            take(events, lambda e: bool(of(StateChanged, e)))
            responder = plug.bus.ecu.responder
            responder.identity = identity
            responder.quirks = replace(responder.quirks, **changes)
            responder.car.on = True
            return take(events, settled)

    def test_another_car_of_the_same_model_is_measured_again(self):
        reported = self.moved(Identity(0x0A, ("ANOTHER", *PASSPORTS[1:])), max_list=5)
        assert [u.another for u in of(UnitFound, reported)] == [True]
        assert of(UnitFound, reported)[0].passport.program[0] == "ANOTHER"
        assert of(PlanChanged, reported)  # a new recording begins with it
        assert of(MethodChosen, reported)[0].method == "batch"  # measured again
        assert_values_are_the_units(reported)

    def test_another_car_of_another_model_is_found(self):
        reported = self.moved(Identity(0x09, PASSPORTS))
        assert [(u.version_code, u.another) for u in of(UnitFound, reported)] == [(0x09, True)]
        assert_values_are_the_units(reported)

    def test_the_same_unit_with_a_damaged_passport_is_no_other_car(self):
        plug = SimulatedPlug(make_bus())
        with closing(make_sampler(plug, method="batch").run()) as events:
            take(events, enough)
            for _ in range(6):
                plug.bus.ecu.responder.car.on = False
                take(events, lambda e: bool(of(StateChanged, e)))
                plug.bus.ecu.responder.car.on = True
                plug.bus.fault_injector.rates = {LineFault.LOST: 0.15, LineFault.DAMAGED: 0.1}
                reported = take(events, lambda e: bool(of(UnitFound, e)))
                plug.bus.fault_injector.rates = {}
                reported += take(events, enough)
                assert [u.another for u in of(UnitFound, reported)] == [False]


def test_after_a_cranking_dip_values_go_on_by_the_same_method():
    """The supply is gone for less than a response takes; the list is gone with it."""
    for method in ("list", "stream"):
        plug = SimulatedPlug(make_bus())
        car = plug.bus.ecu.responder.car
        with closing(make_sampler(plug, method=method).run()) as events:
            take(events, enough)
            car.on = False
            plug.at(plug.now() + 0.3, lambda car=car: setattr(car, "on", True))
            reported = take(events, enough)
        assert of(CycleFailed, reported)
        assert not of(MethodChosen, reported)
        assert_values_are_the_units(reported)


@pytest.mark.parametrize("hours", [-1, 1])
@pytest.mark.parametrize("method", ["batch", "list", "stream"])
def test_a_date_set_while_the_adapter_is_out_makes_no_time_run_back(method, hours):
    socket = SimulatedPlug(make_bus())
    shift = [0.0]

    def open_link(url: str) -> Link:
        return _SteadyLink(socket.open(), shift[0])

    plug = ReconnectingPort("sim:", open_port=open_link, clock=socket.now, wait=socket.wait)
    reported = []
    with closing(
        Acquisition(plug, ecu_factory(), SECTION_4, ["FREQ", "INJ"], method=method).run()
    ) as events:
        for _ in range(3):
            reported += take(events, enough)
            socket.pull()
            shift[0] += hours * 3600
            reported += take(events, lambda e: bool(of(StateChanged, e)))
            socket.plugged_in = True
    times = [event.time for event in reported]
    assert times == sorted(times)
    samples = [s.time for s in of(Sampled, reported)]
    assert len(set(samples)) == len(samples) == 3 * SAMPLES
    assert_values_are_the_units(reported)


def test_the_right_adapter_is_taken_under_another_name_and_a_strangers_car_is_never_asked():
    def cable(name: str, number: str) -> Port:
        return Port(name, "FT232R", vid=0x0403, pid=0x6001, serial_number=number)

    ours, strangers = SimulatedPlug(make_bus()), SimulatedPlug(make_bus())
    plugged, opened = [cable("/dev/ttyUSB0", "A1")], []

    def open_port(url: str) -> Link:
        opened.append(url)
        number = next(p.serial_number for p in plugged if p.url == url.partition("?")[0])
        return ours.open() if number == "A1" else strangers.open()

    plug = ReconnectingPort(
        "/dev/ttyUSB0?baud=9600",
        find=lambda: list(plugged),
        open_port=open_port,
        clock=ours.now,
        wait=ours.wait,
    )
    with closing(
        Acquisition(plug, ecu_factory(), SECTION_4, ["FREQ"], method="batch").run()
    ) as events:
        take(events, enough)
        plugged[:] = [cable("/dev/ttyUSB0", "B2")]
        ours.pull()
        ours.at(ours.now() + 20, lambda: plugged.append(cable("/dev/ttyUSB1", "A1")))
        ours.at(ours.now() + 20, ours.mend)
        reported = take(events, enough)
    errors = [type(event.error) for event in of(StateChanged, reported) if event.error]
    assert errors == [LinkLost, AnotherAdapter]
    (moved,) = of(AdapterMoved, reported)
    assert (moved.port, moved.before) == ("/dev/ttyUSB1", "/dev/ttyUSB0")
    assert opened == ["/dev/ttyUSB0?baud=9600", "/dev/ttyUSB1?baud=9600"]
    assert strangers.link is None
    (unit,) = of(UnitFound, reported)
    assert not unit.another
    assert_values_are_the_units(reported)


@pytest.mark.parametrize("lost_by", ["port", "silence"])
def test_a_unit_lost_before_its_passports_were_read_is_never_taken_for_the_next(lost_by):
    plug = SimulatedPlug(make_bus())
    with closing(make_sampler(plug, "FREQ", method="batch").run()) as events:
        first = take(events, lambda e: bool(of(Sampled, e)))
        assert not of(UnitFound, first)  # values come before the passports
        if lost_by == "port":
            plug.pull()
        else:
            plug.unsupply()
        plug.at(plug.now() + 5, plug.mend)
        found = take(events, lambda e: bool(of(UnitFound, e)))
        later = take(events, enough)
    assert of(UnitFound, found)[0].another
    assert not of(Sampled, found)
    assert not of(UnitFound, later)


def test_a_run_can_be_stopped_while_it_waits():
    plug = SimulatedPlug(make_bus())
    plug.plugged_in = False
    sampler = make_sampler(plug)
    plug.at(30, sampler.stop)
    (reported,) = list(sampler.run())  # it ends by itself
    assert reported.state is LineState.NO_PORT
    assert plug.now() < 33
    silent = SimulatedPlug(make_bus(quirks=EcuQuirks()))
    silent.bus.ecu.responder.car.on = False
    sampler = make_sampler(silent)
    silent.at(30, sampler.stop)
    assert [e.state for e in sampler.run()] == [LineState.ECHO_ONLY]
    assert silent.now() < 40


@pytest.mark.parametrize("method", ["batch", "stream"])
def test_a_run_can_be_stopped_while_it_samples(method):
    plug = SimulatedPlug(make_bus())
    sampler = make_sampler(plug, method=method)
    plug.at(3, sampler.stop)
    reported = list(sampler.run())
    assert 3 - 0.1 < of(Sampled, reported)[-1].time < 3.5
    assert sampler.ecu is None
    carried = plug.bus.bytes_carried
    plug.bus.advance(plug.now() + 5)
    assert plug.bus.bytes_carried == carried


def test_the_units_passport_is_reported():
    with closing(make_sampler(SimulatedPlug(make_bus()), method="batch").run()) as events:
        (found,) = of(UnitFound, take(events, enough))
    assert found.passport.pieces == IDENTITY.passports


@pytest.mark.parametrize("spoil", ["pull", "unsupply"])
def test_the_wait_reports_an_error_each_second(spoil):
    """One gap an attempt, so that whoever runs it can stop; they are one hole in a recording."""
    plug = SimulatedPlug(make_bus())
    with closing(make_sampler(plug, method="batch").run()) as events:
        take(events, enough)
        getattr(plug, spoil)()
        began = plug.now()
        reported = take(events, lambda e: plug.now() > began + 60)
    times = [gap.time for gap in of(CycleFailed, reported)]
    assert times == sorted(times)
    assert max(later - before for before, later in pairwise([began, *times])) < 4
    assert len(of(StateChanged, reported)) == (2 if spoil == "pull" else 1)  # lost, then not found


def test_an_answer_to_01_that_is_lost_after_an_outage_ends_nothing():
    """The unit answered 01 when it was met: it does know it."""
    plug = SimulatedPlug(make_bus())
    with closing(make_sampler(plug, method="batch").run()) as events:
        take(events, enough)
        plug.bus.ecu.responder.car.on = False
        take(events, lambda e: bool(of(StateChanged, e)))
        plug.bus.ecu.responder.car.on = True
        # The step is found again, and then 01 is asked for: lost each time.
        plug.bus.fault_injector.next(None, LineFault.LOST, None, LineFault.LOST, None)
        assert of(Sampled, take(events, enough))
