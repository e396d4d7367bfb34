"""Names that are all wanted less often than in every cycle: most cycles ask for nothing.

Such a cycle is as long as any other, so that every tenth one is what it says; the wire is left
alone in it, and so is the computer.
"""

from __future__ import annotations

from contextlib import closing
from itertools import pairwise

import pytest
from sampling_harness import (
    SimulatedPlug,
    assert_values_are_the_units,
    enough,
    make_sampler,
    of,
    run,
    take,
    wishes,
)

from mikas.sampling.events import CycleFailed, MethodChosen, Sampled, UnitFound
from mikas.sampling.plan import Plan
from mikas.sampling.running.plan_runner import PlanCycles
from mikas.virtual.quirks import GROUPS, EcuQuirks
from virtual_harness import make_bus


def apart(events, name: str = "TWAT") -> list[float]:
    """Seconds between one value of `name` and the next, once the unit is identified."""
    found = [event.time for event in of(UnitFound, events)]
    identified = found[0] if found else 0.0
    samples = [s for s in of(Sampled, events) if s.time >= identified]
    times = [s.fresh[name].time for s in samples if name in s.fresh]
    return [after - before for before, after in pairwise(times)]


@pytest.fixture
def ran(monkeypatch):
    """How many cycles were run by 61 or 63."""
    numbers: list[int] = []
    through = PlanCycles.run

    def counted(self, number, **how):
        numbers.append(number)
        return through(self, number, **how)

    monkeypatch.setattr(PlanCycles, "run", counted)
    return numbers


@pytest.mark.parametrize("method", ["single", "batch", "list"])
def test_every_tenth_cycle_is_ten_times_as_long_as_every_cycle(method, ran):
    usual = apart(run(make_bus(), "TWAT", method=method))[-1]
    ran.clear()
    events = run(make_bus(), "TWAT/10", method=method)
    assert apart(events)[2:] == pytest.approx([10 * usual] * len(apart(events)[2:]), rel=0.15)
    assert len(ran) <= len(of(Sampled, events))
    assert_values_are_the_units(events)


@pytest.mark.parametrize("method", ["batch", "list"])
def test_several_slow_parameters_have_their_own_cycles(method):
    events = run(make_bus(), "TWAT/10", "TAIR/10", "UACC/4", method=method)
    slow, slower = apart(events, "UACC"), apart(events)
    assert sum(slower) / len(slower) == pytest.approx(2.5 * sum(slow) / len(slow), rel=0.1)


@pytest.mark.parametrize("method", ["single", "batch", "list"])
def test_a_rate_is_that_of_the_cycles(method, ran):
    events = run(make_bus(), "TWAT/10", method=method, rate=5.0)
    assert apart(events) == pytest.approx([2.0] * len(apart(events)), abs=0.05)
    assert len(ran) <= len(of(Sampled, events))


def test_only_cycles_with_requests_are_measured(ran):
    """Else a second of measuring would run through a million empty ones."""
    lacks = GROUPS["stream"]
    events = run(make_bus(quirks=EcuQuirks(missing=lacks)), "TWAT/1000", "TAIR/1000")
    (chosen,) = of(MethodChosen, events)
    alone = of(MethodChosen, run(make_bus(quirks=EcuQuirks(missing=lacks)), "TWAT"))[0]
    assert chosen.rates["batch"] == pytest.approx(alone.rates["batch"], rel=0.1)
    assert len(ran) < 1000
    after = of(Sampled, events[events.index(chosen) :])
    assert apart(after)[1] == pytest.approx(1000 / chosen.rates[chosen.method], rel=0.15)


def test_jobs_and_stop_do_not_wait_for_the_next_cycle():
    plug = SimulatedPlug(make_bus())
    sampler = make_sampler(plug, "TWAT/100", method="batch", rate=1.0)
    asked = []
    plug.at(20, lambda: asked.append(sampler.call(lambda ecu: (plug.now(), ecu.faults()))))
    plug.at(50, sampler.stop)
    events = list(sampler.run())
    (future,) = asked
    assert future.result(0)[0] < 21
    assert plug.now() < 52
    assert not of(CycleFailed, events)


def test_a_failed_first_cycle_does_not_set_the_length_of_the_next():
    bus = make_bus()
    plug = SimulatedPlug(bus)
    with closing(make_sampler(plug, "TWAT/10", method="batch").run()) as events:
        take(events, enough)
        bus.ecu.responder.car.on = False
        take(events, lambda e: bool(of(CycleFailed, e)))
        bus.ecu.responder.car.on = True
        back = take(events, enough)
    assert apart(back)[-1] == pytest.approx(apart(back)[3], rel=0.1)
    assert apart(back)[-1] < 0.3


def test_a_slow_parameter_costs_its_share_of_a_cycle():
    every = Plan(tuple(wishes("TWAT", "TAIR")))
    tenth = Plan(tuple(wishes("TWAT/10", "TAIR/10")))
    one = Plan(tuple(wishes("TWAT"))).price()
    assert tenth.price().bytes == pytest.approx(one.bytes / 5)
    assert tenth.price().requests == pytest.approx(0.2)
    assert tenth.price().seconds == pytest.approx(one.seconds)  # a cycle is as long as one of them
    assert tenth.price().rate == pytest.approx(one.rate)
    assert tenth.with_method("list").price().rate == pytest.approx(
        every.with_method("list").price().rate
    )
    assert tenth.busy_share == pytest.approx(0.2)
    assert every.busy_share == 1
