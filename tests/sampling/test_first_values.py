"""The first value: a unit that answers is sampled before its passports and methods are known."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from itertools import pairwise
from math import inf

import pytest
from sampling_harness import (
    SimulatedPlug,
    assert_values_are_the_units,
    make_sampler,
    of,
    run,
    settled,
    take,
)

from mikas import tester
from mikas.client import Passport
from mikas.client.identity import UnitIdentity
from mikas.sampling.events import (
    CycleFailed,
    ParameterDropped,
    PlanChanged,
    Sampled,
    StateChanged,
    UnitFound,
)
from mikas.virtual.bus import AdapterKind
from mikas.virtual.quirks import GROUPS, EcuQuirks, Unknown
from virtual_harness import PASSPORTS, make_bus


def first_at(events) -> int:
    """Where the first sample is."""
    return events.index(of(Sampled, events)[0])


@pytest.mark.parametrize("adapter", [AdapterKind(), AdapterKind(echo=False)])
@pytest.mark.parametrize("method", ["auto", "batch"])
def test_the_first_value_comes_soon_after_the_port_is_open(adapter, method):
    events = run(make_bus(adapter=adapter), method=method)
    first, found = events[first_at(events)], of(UnitFound, events)[0]
    assert first.time < 0.6
    assert len(first.fresh) == 23
    assert found.time > first.time
    assert events.index(of(PlanChanged, events)[0]) < first_at(events)
    assert_values_are_the_units(events)


class PortOpenBefore(SimulatedPlug):
    """Its links were opened long before they are used."""

    def open(self):
        link = super().open()
        link.opened = link.now()
        self.wait(0.4)
        return link


def test_the_first_value_comes_sooner_if_the_port_was_open_before():
    opened_now, before = SimulatedPlug(make_bus()), PortOpenBefore(make_bus())
    first, sooner = (first_sample(plug) for plug in (opened_now, before))
    assert sooner.time - 0.4 < first.time - 0.15


def first_sample(plug) -> Sampled:
    with closing(make_sampler(plug).run()) as events:
        return of(Sampled, take(events, lambda seen: bool(of(Sampled, seen))))[0]


def test_the_next_unit_on_the_same_link_is_listened_to_in_full(monkeypatch):
    since = []
    connect = tester.Tester.connect

    def watched(connecting, *, listening_since):
        since.append(listening_since)
        return connect(connecting, listening_since=listening_since)

    monkeypatch.setattr(tester.Tester, "connect", watched)
    plug = PortOpenBefore(make_bus())
    with closing(make_sampler(plug).run()) as events:
        take(events, settled)
        assert since == [0.0]
        responder = plug.bus.ecu.responder
        responder.identity = replace(responder.identity, version_code=0x09)
        plug.unsupply()
        take(events, lambda seen: bool(of(StateChanged, seen)))
        plug.mend()
        assert of(UnitFound, take(events, settled))[0].another
    assert set(since[1:]) == {inf}


@pytest.mark.parametrize("unknown", list(Unknown))
def test_values_go_on_while_unknown_passports_are_tried(unknown):
    quirks = EcuQuirks(missing=GROUPS["passports"], unknown=unknown)
    events = run(make_bus(quirks=quirks), "TWAT", "FREQ", method="batch")
    times = [sample.time for sample in of(Sampled, events)]
    assert times[0] < 0.6
    assert max(after - before for before, after in pairwise(times)) < 3.5
    assert not of(CycleFailed, events)


@pytest.mark.parametrize("unknown", list(Unknown))
def test_a_parameter_that_is_refused_is_found_as_ever(unknown):
    bus = make_bus(quirks=EcuQuirks(unknown=unknown))
    del bus.ecu.responder.car.data[0x1A]
    events = run(bus)
    assert [dropped.name for dropped in of(ParameterDropped, events)] == ["TWAT"]
    assert not of(CycleFailed, events)
    assert_values_are_the_units(events)


@pytest.mark.parametrize("method", ["single", "list", "stream"])
def test_no_first_value_comes_by_another_method_than_the_requested(method):
    events = run(make_bus(), method=method)
    assert events.index(of(UnitFound, events)[0]) < first_at(events)


def test_no_first_value_comes_if_another_unit_may_have_been_sampled_before():
    events = run(make_bus(), before=UnitIdentity(0x0A, Passport(PASSPORTS[:3], PASSPORTS[3:])))
    assert events.index(of(UnitFound, events)[0]) < first_at(events)


def test_no_first_value_comes_if_a_unit_is_known_that_takes_no_long_list(tmp_path):
    short = EcuQuirks(max_list=8)
    run(make_bus(quirks=short), state=tmp_path)
    events = run(make_bus(quirks=short), state=tmp_path)
    assert events.index(of(UnitFound, events)[0]) < first_at(events)


def test_a_stop_ends_it_between_two_passports():
    plug = SimulatedPlug(make_bus(quirks=EcuQuirks(turn_round=0.4)))
    sampler = make_sampler(plug)
    with closing(sampler.run()) as events:
        take(events, lambda e: bool(of(Sampled, e)))
        sampler.stop()
        began = plug.now()
        assert not of(UnitFound, list(events))
    assert plug.now() - began < 0.6
