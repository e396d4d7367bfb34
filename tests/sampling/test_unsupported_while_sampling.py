"""A unit that refuses in the middle what it gave before: the others go on, by what still works."""

from __future__ import annotations

from contextlib import closing
from itertools import pairwise
from random import Random

import pytest
from sampling_harness import (
    SimulatedPlug,
    assert_values_are_the_units,
    enough,
    make_sampler,
    of,
    run,
    settled,
    take,
)

from mikas.errors import EcuRefused, NotSupported
from mikas.framing import encode
from mikas.sampling.events import (
    CycleFailed,
    LineState,
    MethodChosen,
    ParameterDropped,
    ParameterReturned,
    PlanChanged,
    Sampled,
    StateChanged,
)
from mikas.virtual.bus import Bus
from mikas.virtual.ecu import VirtualEcu
from mikas.virtual.fault_injector import FaultInjector, LineFault, Sent
from mikas.virtual.quirks import GROUPS, EcuQuirks, LongList, Unknown
from mikas.virtual.responder import Responder
from virtual_harness import DATA, FAULTS, IDENTITY, TableCar, make_bus


def changing(sampler, bus: Bus, change):
    """`change` happens to the unit between two cycles, where no stream is running."""
    return sampler.call(lambda ecu: change(bus.ecu.responder))


def lacking(*groups: str, unknown: Unknown = Unknown.SILENT, **others: object):
    missing = frozenset().union(*(GROUPS[group] for group in groups))

    def change(responder):
        responder.quirks = EcuQuirks(missing=missing, unknown=unknown, **others)

    return change


def without(*codes: int):
    def change(responder):
        for code in codes:
            del responder.car.data[code]
        responder._list = ()  # it would be asked for what is not there  # noqa: SLF001

    return change


@pytest.mark.parametrize("unknown", Unknown)
@pytest.mark.parametrize("method", ["single", "batch", "list", "stream", "stroke0"])
def test_a_parameter_refused_midway_is_dropped_and_the_others_go_on(method, unknown):
    bus = make_bus(quirks=EcuQuirks(unknown=unknown), rpm=5200)
    sampler = make_sampler(SimulatedPlug(bus), "FREQ", "TWAT", "INJ", "THR", method=method)
    with closing(sampler.run()) as events:
        take(events, enough)
        changing(sampler, bus, without(0x3F))
        after = take(events, enough)
    assert [d.name for d in of(ParameterDropped, after)] == ["INJ"]
    (plan,) = of(PlanChanged, after)
    assert [w.parameter.name for w in plan.plan.parameters] == ["FREQ", "TWAT", "THR"]
    assert plan.plan.method == method  # it is not the method that is to blame
    at = after.index(plan)
    assert of(Sampled, after[at:])
    for sample in of(Sampled, after[at:]):
        assert set(sample.fresh) == {"FREQ", "TWAT", "THR"}
        assert not sample.stale
    assert_values_are_the_units(after)


def test_a_silent_one_among_many_is_found_soon():
    """A list of 21 is halved five times until the silent one is alone."""
    plug = SimulatedPlug(make_bus(quirks=EcuQuirks(unknown=Unknown.SILENT)))
    sampler = make_sampler(plug, method="batch")
    with closing(sampler.run()) as events:
        take(events, enough)
        changing(sampler, plug.bus, without(0x1A))
        began = plug.now()
        take(events, lambda e: bool(of(CycleFailed, e)))
    assert plug.now() - began < 10


@pytest.mark.parametrize("method", ["single", "batch", "list", "stream"])
def test_the_other_parameters_do_not_wait_for_the_silent_one(method):
    plug = SimulatedPlug(make_bus(quirks=EcuQuirks(unknown=Unknown.SILENT)))
    sampler = make_sampler(plug, method=method)
    with closing(sampler.run()) as events:
        take(events, enough)
        changing(sampler, plug.bus, without(0x3F, 0x72))
        after = take(events, enough)
    assert {d.name for d in of(ParameterDropped, after)} == {"INJ", "MINERR"}
    first = next(at for at, event in enumerate(after) if isinstance(event, CycleFailed))
    found = next(at for at, event in enumerate(after) if isinstance(event, ParameterDropped))
    times = [after[first].time, *(s.time for s in of(Sampled, after[first:found]))]
    assert len(times) > 4
    assert max(later - before for before, later in pairwise(times)) < 2
    assert_values_are_the_units(after)


@pytest.mark.parametrize(
    ("method", "wanted"),
    [
        *((method, "TWAT") for method in ("single", "batch", "list", "stream")),
        ("list", "TWAT/10"),  # asked for by itself, by 61
    ],
)
def test_a_refusal_01_is_no_datum(method, wanted):
    """D10 again: a unit that refuses with 01 refuses a one-byte parameter."""
    bus = make_bus(quirks=EcuQuirks(unknown=Unknown.ERROR))
    sampler = make_sampler(SimulatedPlug(bus), "FREQ", wanted, "THR", method=method)
    with closing(sampler.run()) as events:
        take(events, enough)
        changing(sampler, bus, without(0x1A))
        after = take(events, enough)
    assert [d.name for d in of(ParameterDropped, after)] == ["TWAT"]
    assert_values_are_the_units(after)


@pytest.mark.parametrize("unknown", Unknown)
@pytest.mark.parametrize("method", ["single", "batch"])
def test_common_parameters_may_be_refused(method, unknown):
    """Neither FREQ nor any other is promised to anybody."""
    bus = make_bus(quirks=EcuQuirks(unknown=unknown))
    sampler = make_sampler(SimulatedPlug(bus), "FREQ", "TWAT", "UACC", "THR", method=method)
    with closing(sampler.run()) as events:
        take(events, enough)
        changing(sampler, bus, without(0x29, 0x2C, 0x1A, 0x1E))
        after = take(events, enough)
    assert {d.name for d in of(ParameterDropped, after)} == {"FREQ", "TWAT", "UACC"}
    assert list(of(Sampled, after)[-1].fresh) == ["THR"]
    assert_values_are_the_units(after)


@pytest.mark.parametrize("unknown", Unknown)
def test_auto_falls_back_step_by_step_as_methods_fail(unknown):
    bus = make_bus(quirks=EcuQuirks(unknown=unknown))
    sampler = make_sampler(SimulatedPlug(bus))
    with closing(sampler.run()) as events:
        reported = take(events, settled)
        for lost in (
            lacking("stream", unknown=unknown),
            lacking("stream", "list", unknown=unknown),
            lacking("stream", "list", unknown=unknown, max_list=5),
            lacking("stream", "list", unknown=unknown, max_list=1),
        ):
            done = changing(sampler, bus, lost)
            reported += take(events, enough)
            assert done.done()
            reported += take(events, enough)
    assert [c.method for c in of(MethodChosen, reported)][:3] == ["stream", "list", "batch"]
    assert not of(ParameterDropped, reported)
    assert_values_are_the_units(reported)
    last = of(Sampled, reported)[-1]
    assert len(last.fresh) == 23
    assert {s.state for s in of(StateChanged, reported)} == {
        LineState.ECU_ALIVE,
        LineState.SAMPLING,
    }  # the ignition was never off


@pytest.mark.parametrize("long_list", LongList)
def test_lists_that_became_too_long_make_smaller_batches(long_list):
    bus = make_bus()
    sampler = make_sampler(SimulatedPlug(bus), method="batch")
    with closing(sampler.run()) as events:
        take(events, enough)
        changing(sampler, bus, lacking("stream", "list", max_list=6, long_list=long_list))
        after = take(events, enough)
        limits = sampler.call(lambda ecu: ecu.limits())
        after += take(events, enough)
    assert limits.result(0).max_list == 6
    assert not of(ParameterDropped, after)
    assert_values_are_the_units(after)
    assert len(of(Sampled, after)[-1].fresh) == 23


@pytest.mark.parametrize("method", ["list", "stream"])
def test_a_requested_method_that_fails_is_replaced(method):
    bus = make_bus()
    sampler = make_sampler(SimulatedPlug(bus), method=method)
    with closing(sampler.run()) as events:
        take(events, enough)
        changing(sampler, bus, lacking("stream", "list"))
        after = take(events, settled)
        changing(sampler, bus, lacking())
        sampler.reconfigure([], method)  # asked for once more, it is tried once more
        again = take(events, enough)
    assert of(PlanChanged, again)[-1].plan.method == method
    assert of(MethodChosen, after)[0].method == "batch"
    assert any(
        isinstance(gap.error, EcuRefused) or gap.error.received for gap in of(CycleFailed, after)
    )


@pytest.mark.parametrize("method", ["list", "stream"])
@pytest.mark.parametrize("unknown", Unknown)
def test_a_method_that_is_refused_from_the_beginning_is_an_error_or_replaced(method, unknown):
    bus = make_bus(quirks=EcuQuirks(missing=GROUPS[method], unknown=unknown))
    with pytest.raises(EcuRefused):
        run(bus, method=method, strict=True)
    bus = make_bus(quirks=EcuQuirks(missing=GROUPS[method], unknown=unknown))
    with closing(make_sampler(SimulatedPlug(bus), method=method).run()) as events:
        reported = take(events, settled)
    assert isinstance(of(CycleFailed, reported)[0].error, EcuRefused)  # said, and then got over
    assert of(MethodChosen, reported)[0].method == {"list": "stream", "stream": "list"}[method]


def test_ignition_off_is_no_refusal():
    bus = make_bus()
    sampler = make_sampler(SimulatedPlug(bus))
    with closing(sampler.run()) as events:
        take(events, settled)
        for _ in range(3):
            bus.ecu.responder.car.on = False
            reported = take(events, lambda e: bool(of(StateChanged, e)))
            bus.ecu.responder.car.on = True
            reported += take(events, enough)
            assert not of(MethodChosen, reported)
            assert not of(ParameterDropped, reported)
            assert not of(PlanChanged, reported)


def test_a_bad_line_is_no_refusal():
    rates = {
        LineFault.LOST: 0.02,
        LineFault.DAMAGED: 0.05,
        LineFault.LATE: 0.01,
        LineFault.CUT: 0.02,
    }
    bus = make_bus(fault_injector=FaultInjector(rates, seed=5))
    sampler = make_sampler(SimulatedPlug(bus), method="batch")
    with closing(sampler.run()) as events:
        reported = take(events, lambda e: len(of(Sampled, e)) >= 600)
    assert not of(ParameterDropped, reported)
    assert not of(MethodChosen, reported)
    assert_values_are_the_units(reported)


def test_when_all_are_refused_it_reports_and_waits_for_another_request():
    bus = make_bus()
    sampler = make_sampler(SimulatedPlug(bus), "TWAT", "INJ", method="batch")
    with closing(sampler.run()) as events:
        take(events, enough)
        changing(sampler, bus, without(0x1A, 0x3F))
        reported = take(events, lambda e: bool(of(StateChanged, e)))
        assert {d.name for d in of(ParameterDropped, reported)} == {"TWAT", "INJ"}
        assert isinstance(of(CycleFailed, reported)[-1].error, NotSupported)
        assert of(StateChanged, reported)[-1].state is LineState.ECU_ALIVE
        asked = sampler.call(lambda ecu: len(ecu.faults()))
        sampler.reconfigure(["FREQ"])
        after = take(events, enough)
    assert asked.result(0) == 4
    assert list(of(Sampled, after)[-1].fresh) == ["FREQ"]


def test_a_gate_that_lets_no_list_through_leaves_the_other_methods():
    bus = make_bus(quirks=EcuQuirks(missing=GROUPS["stream"]))
    sampler = make_sampler(SimulatedPlug(bus), confirm=lambda change: False)
    with closing(sampler.run()) as events:
        reported = take(events, settled)
    assert of(MethodChosen, reported)[0].method == "batch"


class StreamLine(FaultInjector):
    """A line with a fault of its own for every response of one stream."""

    def __init__(self, body: bytes) -> None:
        super().__init__()
        self._wire = encode(body)
        self.line_fault: LineFault | None = None

    def respond(self, wire: bytes) -> list[Sent]:
        if wire == self._wire:
            self.next(self.line_fault)
        return super().respond(wire)


def test_damage_in_a_stream_that_was_silent_before_is_no_refusal():
    line = StreamLine(DATA[0x1A] + DATA[0x29])
    plug = SimulatedPlug(make_bus(fault_injector=line))
    sampler = make_sampler(plug, "TWAT", "FREQ", method="stream")
    with closing(sampler.run()) as events:
        take(events, lambda taken: of(Sampled, taken))
        line.line_fault = LineFault.LOST
        take(events, lambda taken: len(of(CycleFailed, taken)) == 2)
        line.line_fault = LineFault.DAMAGED
        take(events, lambda taken: of(CycleFailed, taken))
        line.line_fault = None
        taken = take(events, enough)
    assert of(ParameterDropped, taken) == []


class Losing(Responder):
    """Loses answers to `code` while `active`, and with `all_codes` a third of the others."""

    def __init__(self, code: int, *, all_codes: bool = False, times: int = 10**6) -> None:
        super().__init__(TableCar(DATA, faults=FAULTS, rpm=850), IDENTITY, EcuQuirks())
        self.code = code
        self.all_codes = all_codes
        self.times = times
        self.active = False
        self._random = Random(1)

    def answer(self, body: bytes, now: float) -> bytes | None:
        answer = super().answer(body, now)
        if not self.active or body[0] != 0x61:
            return answer
        if self.code in body[1:] and self.times:
            self.times -= 1
            return None
        return None if self.all_codes and self._random.random() < 0.33 else answer


def sampling(unit: Responder, *names: str, method: str):
    plug = SimulatedPlug(Bus(VirtualEcu(unit)))
    return plug, make_sampler(plug, *names, method=method)


@pytest.mark.parametrize("method", ["single", "batch"])
def test_lost_answers_are_no_refusal_on_a_line_that_loses_others_too(method):
    """Seven in a row, with every third response of the other codes: nothing is dropped."""
    unit = Losing(0x3F, all_codes=True, times=7)
    _, sampler = sampling(unit, "FREQ", "TWAT", "INJ", method=method)
    with closing(sampler.run()) as events:
        take(events, enough)
        unit.active = True
        after = take(events, lambda _: not unit.times)
        after += take(events, enough)
    assert not of(ParameterDropped, after)
    assert "INJ" in of(Sampled, after)[-1].fresh


def test_a_silent_parameter_is_dropped_on_a_line_that_loses_answers_too():
    """It takes longer, but not for ever."""
    unit = Losing(0x3F, all_codes=True)
    plug, sampler = sampling(unit, "FREQ", "TWAT", "INJ", method="batch")
    with closing(sampler.run()) as events:
        take(events, enough)
        unit.active, began = True, plug.now()
        after = take(events, lambda e: bool(of(ParameterDropped, e)))
    assert [each.name for each in of(ParameterDropped, after)] == ["INJ"]
    assert plug.now() - began < 60


@pytest.mark.parametrize("reconnects", [False, True])
def test_a_dropped_parameter_comes_back_with_a_notice(reconnects):
    """After a reconnection at once; without, one that was read before after a minute."""
    unit = Losing(0x3F)
    plug, sampler = sampling(unit, "FREQ", "TWAT", "INJ", method="single")
    with closing(sampler.run()) as events:
        take(events, enough)
        unit.active = True
        take(events, lambda e: bool(of(PlanChanged, e)))
        unit.active, dropped = False, plug.now()
        if reconnects:
            unit.car.on = False
            plug.at(plug.now() + 3, lambda: setattr(unit.car, "on", True))
        after = take(events, lambda e: bool(of(ParameterReturned, e)))
        assert plug.now() - dropped < (8 if reconnects else 62)
        after += take(events, enough)
    assert [each.name for each in of(ParameterReturned, after)] == ["INJ"]
    assert list(of(PlanChanged, after)[-1].plan.divisors) == [(0x29, 1), (0x1A, 1), (0x3F, 2)]
    assert "INJ" in of(Sampled, after)[-1].fresh
    assert_values_are_the_units(after)


def test_a_parameter_that_the_unit_never_had_costs_no_second_again():
    bus = make_bus(quirks=EcuQuirks(unknown=Unknown.SILENT))
    del bus.ecu.responder.car.data[0x3F], bus.ecu.responder.car.data[0x1A]
    plug = SimulatedPlug(bus)
    sampler = make_sampler(plug, "FREQ", "TWAT", "INJ", "THR", rate=5, method="batch")
    with closing(sampler.run()) as events:
        take(events, lambda e: len(of(ParameterDropped, e)) == 2)
        later = plug.now() + 300
        reported = take(events, lambda e: plug.now() > later)
        times = [sample.time for sample in of(Sampled, reported)]
        assert max(after - before for before, after in pairwise(times)) < 0.3
