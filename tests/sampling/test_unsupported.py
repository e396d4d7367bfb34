"""While the refused names are sorted out, a second or more each, everybody else has a turn."""

from __future__ import annotations

from contextlib import closing

import pytest
from sampling_harness import SimulatedPlug, make_sampler, of, take, wishes

from mikas.sampling.events import ParameterDropped, PlanChanged, Sampled
from mikas.virtual.quirks import GROUPS, EcuQuirks
from virtual_harness import make_bus


@pytest.fixture
def weeding():
    """A sampler of a unit that has fallen silent to twelve of its codes, of which some are asked
    again by now; and its plug.
    """
    bus = make_bus(quirks=EcuQuirks(missing=GROUPS["list"] | GROUPS["stream"]))
    plug = SimulatedPlug(bus)
    sampler = make_sampler(plug, method="batch")
    data = bus.ecu.responder.car.data

    def lose() -> None:
        for code in [code for code in data if code not in (0x29, 0x1A)][:12]:
            del data[code]

    with closing(sampler.run()) as events:
        take(events, lambda e: len(of(Sampled, e)) > 40)
        lose()
        lost_at = plug.now()
        take(events, lambda e: plug.now() > lost_at + 12)
        yield sampler, plug, events


def test_requests_of_others_go_in_between_while_refusals_are_looked_for(weeding):
    sampler, plug, events = weeding
    waited = []

    def ask() -> None:
        asked_at = plug.now()
        sampler.call(lambda _: waited.append(plug.now() - asked_at))
        plug.at(asked_at + 2, ask)

    ask()
    reported = take(events, lambda e: bool(of(ParameterDropped, e)))
    assert len(waited) > 8
    assert max(waited) < 5
    assert of(Sampled, reported)  # and so do the values of the others


def test_another_selection_starts_soon_while_refusals_are_looked_for(weeding):
    sampler, plug, events = weeding
    began = plug.now()
    sampler.reconfigure(["FREQ", "TWAT"], "batch")
    take(events, lambda e: bool(of(PlanChanged, e)) and bool(of(Sampled, e)))
    assert plug.now() - began < 3
    assert list(sampler.plan.parameters) == wishes("FREQ", "TWAT")


def test_stop_does_not_wait_until_refusals_are_found(weeding):
    sampler, plug, events = weeding
    began = plug.now()
    sampler.stop()
    list(events)
    assert plug.now() - began < 3
