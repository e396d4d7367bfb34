"""Sampling on simulated time: the chosen method, the events, and the values."""

from __future__ import annotations

from contextlib import closing

import pytest
from sampling_harness import (
    SAMPLES,
    SimulatedPlug,
    assert_values_are_the_units,
    enough,
    make_sampler,
    of,
    run,
    settled,
    take,
)

from mikas.client.parameters.polling import FIXED_METHODS
from mikas.errors import EchoOnly, LinkLost, NotSupported, UnknownParameter
from mikas.sampling.events import (
    CycleFailed,
    LineState,
    MethodChosen,
    ParameterDropped,
    Sampled,
    StateChanged,
    UnitFound,
)
from mikas.virtual.bus import AdapterKind
from mikas.virtual.fault_injector import FaultInjector, LineFault
from mikas.virtual.quirks import GROUPS, EcuQuirks, LongList, Unknown
from mikas.virtual.responder import Identity
from virtual_harness import IDENTITY, make_bus


def test_before_the_first_sample_the_unit_is_alive_then_sampled():
    events = run(make_bus(), method="batch")
    assert [e.state for e in of(StateChanged, events)] == [
        LineState.ECU_ALIVE,
        LineState.SAMPLING,
    ]
    (found,) = of(UnitFound, events)
    assert found.passport.program[0] == "МИКАС 7.1"
    assert not found.another


@pytest.mark.parametrize("method", FIXED_METHODS)
def test_every_method_gives_the_units_values(method):
    events = run(make_bus(rpm=5200), method=method)
    assert_values_are_the_units(events)
    assert len(of(Sampled, events)[-1].fresh) == 23
    assert not of(CycleFailed, events)


def test_the_fastest_is_chosen_where_everything_works():
    (chosen,) = of(MethodChosen, run(make_bus()))
    assert chosen.method == "stream"
    assert list(chosen.rates) == ["stream", "list", "batch"]
    assert chosen.rates["stream"] > chosen.rates["list"] > chosen.rates["batch"]


@pytest.mark.parametrize(
    ("missing", "method"),
    [
        (("stream",), "list"),
        (("stream", "list"), "batch"),
    ],
)
@pytest.mark.parametrize("unknown", Unknown)
def test_auto_falls_back_step_by_step(missing, method, unknown):
    lacks = frozenset().union(*(GROUPS[group] for group in missing))
    events = run(make_bus(quirks=EcuQuirks(missing=lacks, unknown=unknown)))
    assert of(MethodChosen, events)[0].method == method
    assert_values_are_the_units(events)


@pytest.mark.parametrize("long_list", LongList)
def test_a_unit_with_short_lists_gets_smaller_batches(long_list):
    quirks = EcuQuirks(max_list=4, long_list=long_list, missing=GROUPS["stream"] | GROUPS["list"])
    events = run(make_bus(quirks=quirks))
    assert of(MethodChosen, events)[0].method == "batch"
    assert_values_are_the_units(events)
    assert len(of(Sampled, events)[-1].fresh) == 23


def test_an_adapter_with_latency_is_measured_not_assumed():
    (chosen,) = of(MethodChosen, run(make_bus(adapter=AdapterKind(latency=0.016))))
    best = max(chosen.rates, key=lambda name: chosen.rates[name])
    assert chosen.method == best


def test_slow_ones_are_stale_between_their_turns_and_never_fresh():
    events = run(make_bus(), "FREQ", "TWAT/10", method="batch")
    samples = of(Sampled, events)
    with_coolant = [s for s in samples if "TWAT" in s.fresh]
    assert len(with_coolant) == pytest.approx(SAMPLES / 10, abs=1)
    for sample in samples:
        assert "FREQ" in sample.fresh
        assert not set(sample.fresh) & set(sample.stale)
        if "TWAT" in sample.stale:
            assert sample.stale["TWAT"].time < sample.time


def test_a_rate_is_kept():
    samples = of(Sampled, run(make_bus(), "FREQ", method="batch", rate=5.0))
    assert (samples[-1].time - samples[0].time) / (SAMPLES - 1) == pytest.approx(0.2, rel=0.02)


def test_a_refused_parameter_is_dropped_with_a_notice_and_the_others_go_on():
    bus = make_bus()
    del bus.ecu.responder.car.data[0x1A]
    events = run(bus)
    assert [d.name for d in of(ParameterDropped, events)] == ["TWAT"]
    assert "TWAT" not in of(Sampled, events)[-1].fresh
    assert len(of(Sampled, events)[-1].fresh) == 22


def test_if_all_parameters_are_refused_an_error_is_raised():
    with pytest.raises(NotSupported):
        run(make_bus(), "0x99", method="batch")


def test_an_unknown_name_is_refused_before_anything():
    with pytest.raises(UnknownParameter):
        run(make_bus(), "TWTA")


def test_line_faults_make_gaps_and_no_wrong_value():
    fault_injector = FaultInjector(
        {LineFault.DAMAGED: 0.1, LineFault.LATE: 0.02, LineFault.LOST: 0.02}, seed=3
    )
    events = run(make_bus(fault_injector=fault_injector))
    assert_values_are_the_units(events)


@pytest.mark.parametrize(("method", "most"), [("batch", 3.0), ("stream", 4.0)])
def test_ignition_off_is_reported_as_soon_as_certain(method, most):
    """Ending a stream proves as much as a new request would: no second request is sent."""
    bus = make_bus()
    with closing(make_sampler(SimulatedPlug(bus), method=method).run()) as events:
        last = take(events, enough)[-1].time
        bus.ecu.responder.car.on = False
        reported = take(events, lambda e: bool(of(StateChanged, e)))[-1]
    assert (reported.state, reported.time - last < most) == (LineState.ECHO_ONLY, True)


def test_after_ignition_off_and_on_again_sampling_goes_on():
    bus = make_bus()
    car = bus.ecu.responder.car
    with closing(make_sampler(SimulatedPlug(bus)).run()) as events:
        take(events, settled)
        car.on = False
        lost = take(events, lambda e: bool(of(StateChanged, e)))
        assert of(StateChanged, lost)[0].state is LineState.ECHO_ONLY
        assert isinstance(of(CycleFailed, lost)[-1].error, EchoOnly)
        car.on = True
        back = take(events, enough)
    assert [e.state for e in of(StateChanged, back)] == [LineState.ECU_ALIVE, LineState.SAMPLING]
    assert not of(UnitFound, back)[0].another
    assert not of(MethodChosen, back)  # what was found out once is not found out again
    assert_values_are_the_units(back)


def test_after_the_adapter_is_put_back_sampling_goes_on():
    plug = SimulatedPlug(make_bus())
    with closing(make_sampler(plug).run()) as events:
        take(events, settled)
        plug.pull()
        lost = take(events, lambda e: bool(of(StateChanged, e)))
        assert of(StateChanged, lost)[0].state is LineState.NO_PORT
        assert isinstance(of(StateChanged, lost)[0].error, LinkLost)
        plug.plugged_in = True
        back = take(events, enough)
    assert not of(UnitFound, back)[0].another
    times = [s.time for s in of(Sampled, lost + back)]
    assert times == sorted(times)


def test_another_car_is_detected_and_its_methods_are_measured():
    plug = SimulatedPlug(make_bus())
    with closing(make_sampler(plug).run()) as events:
        take(events, settled)
        plug.pull()
        take(events, lambda e: bool(of(StateChanged, e)))
        plug.bus = make_bus(quirks=EcuQuirks(missing=GROUPS["stream"]))
        plug.bus.ecu.responder.identity = Identity(0x09, IDENTITY.passports)
        plug.bus.advance(plug.now())
        plug.plugged_in = True
        back = take(events, settled)
    assert of(UnitFound, back)[0].another
    assert of(MethodChosen, back)[0].method == "list"


@pytest.mark.parametrize("method", ["batch", "list", "stream"])
def test_requests_of_others_go_in_between_samples(method):
    sampler = make_sampler(SimulatedPlug(make_bus()), method=method)
    with closing(sampler.run()) as events:
        take(events, enough)
        asked = sampler.call(lambda ecu: [fault.code for fault in ecu.faults()])
        failing = sampler.call(lambda ecu: ecu.read("nonsense"))
        cancelled = sampler.call(lambda ecu: ecu.faults())
        cancelled.cancel()
        after = take(events, enough)
    assert asked.result(0) == [0x0D, 0x35, 0x40, 0x0D]
    assert isinstance(failing.exception(0), UnknownParameter)
    assert_values_are_the_units(after)
    assert not of(CycleFailed, after)


@pytest.mark.parametrize("method", ["stream", "batch", "auto"])  # auto: while it is being measured
def test_closing_it_is_no_error_when_the_adapter_was_pulled_out_just_before(method):
    plug = SimulatedPlug(make_bus())
    events = make_sampler(plug, method=method).run()
    take(events, lambda e: len(of(Sampled, e)) == 10)
    plug.pull()
    events.close()
    assert not list(events)


@pytest.mark.parametrize("method", ["stream", "auto"])  # auto: while it is being measured
def test_closing_it_leaves_the_line_quiet(method):
    bus = make_bus()
    plug = SimulatedPlug(bus)
    with closing(make_sampler(plug, method=method).run()) as events:
        take(events, lambda e: len(of(Sampled, e)) == 10)
    carried = bus.bytes_carried
    bus.advance(plug.now() + 5)
    assert bus.bytes_carried == carried
