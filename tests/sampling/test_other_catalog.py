"""Another catalog while it is sampled: new limits and channels leave no hole in the values."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from itertools import pairwise

import pytest
from sampling_harness import (
    SimulatedPlug,
    assert_values_are_the_units,
    ecu_factory,
    of,
    settled,
    take,
)

from mikas.catalog import AlarmLimits, Catalog, Level
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import AlarmChanged, CycleFailed, MethodChosen, PlanChanged, Sampled
from protocol_codes import SECTION_4, with_limits
from virtual_harness import make_bus

METHODS = ["stream", "list", "batch"]


def samples(count):
    return lambda events: len(of(Sampled, events)) >= count


def own(catalog: Catalog, version: str, **limits: AlarmLimits) -> Catalog:
    return replace(with_limits(catalog, **limits), version=version)


HOT = own(SECTION_4, "hot", TWAT=AlarmLimits(warning_high=-40.0))
WITHOUT = replace(
    SECTION_4,
    derived={n: each for n, each in SECTION_4.derived.items() if n == "FUEL_STROKE"},
    version="without",
)


def sampled_by(*catalogs, method, names=None, lacks=(), rate=None):
    """The events of 60 samples by each catalog in turn; `names`: by default, all channels."""
    plug = SimulatedPlug(make_bus())
    for code in lacks:
        del plug.bus.ecu.responder.car.data[code]
    wanted = [names or tuple(catalog.channels) for catalog in catalogs]
    made = Acquisition(plug, ecu_factory(), catalogs[0], wanted[0], method=method, rate=rate)
    reported = []
    with closing(made.run()) as events:
        for catalog, channels in zip(catalogs, wanted, strict=True):
            if reported:
                made.reconfigure(channels, method, rate, catalog=catalog)
            reported += take(events, samples(60))
    return reported


def longest_step(reported):
    """Of the samples, without the first ones, which find the unit's refusals."""
    return max(b.time - a.time for a, b in pairwise(of(Sampled, reported)[3:]))


@pytest.mark.parametrize("method", METHODS)
def test_saving_a_limit_or_a_channel_loses_no_row(method):
    reported = sampled_by(WITHOUT, HOT, SECTION_4, WITHOUT, method=method)
    usual = longest_step(sampled_by(SECTION_4, method=method))
    assert longest_step(reported) <= usual * 1.3 + 0.005
    assert not of(CycleFailed, reported)
    versions = [plan.catalog for plan in of(PlanChanged, reported)]
    assert versions == ["without", "hot", SECTION_4.version, "without"]
    assert_values_are_the_units(reported)


def test_the_fastest_method_goes_on_unmeasured():
    plug = SimulatedPlug(make_bus())
    made = Acquisition(plug, ecu_factory(), SECTION_4, SECTION_4.channels)
    with closing(made.run()) as events:
        take(events, settled)
        made.reconfigure(HOT.channels, catalog=HOT)
        reported = take(events, samples(60))
    assert longest_step(reported) < 0.05
    assert not of(MethodChosen, reported)
    assert [plan.catalog for plan in of(PlanChanged, reported)] == ["hot"]


@pytest.mark.parametrize("method", METHODS)
def test_the_next_sample_is_of_the_new_catalog(method):
    reported = sampled_by(WITHOUT, HOT, SECTION_4, method=method)
    plans = of(PlanChanged, reported)[1:]
    for plan, following in zip(plans, (*plans[1:], None), strict=True):
        end = reported.index(following) if following else None
        rows = of(Sampled, reported[reported.index(plan) + 1 : end])
        assert all("FUEL_FLOW" in row.derived for row in rows if {"FREQ", "INJ"} <= set(row.fresh))
    began, ended = (each for each in of(AlarmChanged, reported) if each.name == "TWAT")
    assert (began.name, began.level, ended.level) == ("TWAT", Level.WARNING, Level.NONE)
    assert reported.index(plans[0]) < reported.index(began) < reported.index(plans[1])


@pytest.mark.parametrize("method", METHODS)
def test_a_parameter_that_the_unit_lacks_is_not_requested_again(method):
    """Each is a second of silence, and to save a limit is no wish for it."""
    reported = sampled_by(SECTION_4, HOT, method=method, lacks=[0x5B, 0x5C])
    assert longest_step(reported) < 0.2
    assert {"SSM", "FSM"}.isdisjoint(of(Sampled, reported)[-1].fresh)


def test_divisors_and_the_rate_are_kept():
    names = ("FREQ", "INJ/2", "TWAT/10", "JAIR/10")
    reported = sampled_by(SECTION_4, HOT, method="batch", names=names, rate=10.0)
    rows = of(Sampled, reported)[3:]
    assert {round(b.time - a.time, 2) for a, b in pairwise(rows)} == {0.1}
    for name, every in (("INJ", 2), ("TWAT", 10), ("JAIR", 10)):
        times = [at for at, row in enumerate(rows) if name in row.fresh]
        assert {b - a for a, b in pairwise(times)} == {every}


@pytest.mark.parametrize("method", METHODS)
def test_a_channel_that_needs_another_parameter_costs_no_trial(method):
    """The unit has answered it before. Only a stream has to be ended for it (D12)."""
    plug = SimulatedPlug(make_bus())
    made = Acquisition(plug, ecu_factory(), SECTION_4, ("FREQ", "INJ", "JAIR"), method=method)
    with closing(made.run()) as events:
        reported = take(events, samples(60))
        made.reconfigure(("FREQ", "JAIR"), method)
        reported += take(events, samples(60))
        made.reconfigure(("FREQ", "FUEL_FLOW", "JAIR"), method)
        reported += take(events, samples(60))
    assert longest_step(reported) < {"stream": 0.25, "list": 0.11, "batch": 0.04}[method]
