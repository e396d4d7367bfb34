"""Measuring the methods delays no call: looks between two cycles, on a slow unit too."""

from __future__ import annotations

from contextlib import closing

import pytest
from sampling_harness import SimulatedPlug, make_sampler, of, settled, take

from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import CycleFailed, Event, MethodChosen, PlanChanged, Sampled, UnitFound
from mikas.virtual.quirks import EcuQuirks
from virtual_harness import make_bus

CYCLE = 0.6  # s, and a little more: one of batch takes 0.46 s, one of list 0.43


def trying(events: list[Event]) -> bool:
    """The first sample since the unit was identified: the trial has begun."""
    return bool(of(UnitFound, events)) and isinstance(events[-1], Sampled)


def slow() -> tuple[SimulatedPlug, Acquisition]:
    """Measures batch first, then list: a rate is wanted. Each takes 3 s."""
    plug = SimulatedPlug(make_bus(quirks=EcuQuirks(turn_round=0.4)))
    return plug, make_sampler(plug, rate=50.0)


@pytest.mark.parametrize("after", [0.1, 1.3, 2.1, 4.2])
def test_stop_does_not_wait_for_a_trial(after):
    plug, sampler = slow()
    with closing(sampler.run()) as events:
        take(events, trying)
        stop_at = plug.now() + after
        plug.at(stop_at, sampler.stop)
        reported = list(events)
    assert not of(MethodChosen, reported)
    assert plug.now() - stop_at < CYCLE


def test_another_request_does_not_wait_for_a_trial():
    plug, sampler = slow()
    with closing(sampler.run()) as events:
        take(events, trying)
        began = plug.now()
        sampler.reconfigure([p.parameter.name for p in sampler.plan.parameters[:2]], "batch")
        take(events, lambda e: bool(of(PlanChanged, e)))
    assert plug.now() - began < 2 * CYCLE  # all that is wanted was asked for once


def test_jobs_run_between_cycles_of_a_trial():
    plug, sampler = slow()
    waited = []

    def ask() -> None:
        asked_at = plug.now()
        sampler.call(lambda _: waited.append(plug.now() - asked_at))
        if asked_at < began + 5:
            plug.at(asked_at + 0.7, ask)

    with closing(sampler.run()) as events:
        take(events, trying)
        began = plug.now()
        ask()
        reported = take(events, lambda e: plug.now() > began + 6)
    assert len(waited) > 5
    assert max(waited) < 2 * CYCLE
    assert not of(CycleFailed, reported)


def test_jobs_do_not_change_the_measured_rate():
    """A steady flow of them neither keeps it from ending nor makes a method look slow."""

    def rates(*, busy: bool) -> dict[str, float]:
        sampler = make_sampler(SimulatedPlug(make_bus()))

        def one(ecu):
            ecu.faults()
            sampler.call(one)

        with closing(sampler.run()) as events:
            if busy:
                take(events, lambda e: bool(of(PlanChanged, e)))
                sampler.call(one)
            return of(MethodChosen, take(events, settled))[0].rates

    assert rates(busy=True) == pytest.approx(rates(busy=False), rel=0.05)
