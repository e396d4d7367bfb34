"""All channels are sampled; which of them come first changes without a hole in the values."""

from __future__ import annotations

from contextlib import closing
from itertools import pairwise

import pytest
from sampling_harness import SimulatedPlug, ecu_factory, of, take

from mikas.errors import UnknownParameter
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import CycleFailed, PlanChanged, Sampled
from mikas.sampling.gaps import GapTracker
from mikas.sampling.plan import Plan, select
from protocol_codes import SECTION_4
from virtual_harness import make_bus

IDLE, FUEL = ("FREQ", "TWAT"), ("INJ", "JAIR", "FUEL_FLOW")
ALL = tuple(parameter.name for parameter in SECTION_4.parameters)


def samples(count):
    return lambda events: len(of(Sampled, events)) >= count


def sampled_with_other_presets(method, rate=None):
    """The events of some hundred cycles, in which other channels come first again and again."""
    made = Acquisition(
        SimulatedPlug(make_bus()), ecu_factory(), SECTION_4, (), method=method, rate=rate
    )
    made.prefer(IDLE)
    reported = []
    with closing(made.run()) as events:
        for names in (FUEL, IDLE, (), FUEL):
            reported += take(events, samples(60))
            made.prefer(names)
        reported += take(events, samples(60))
    return reported


@pytest.mark.parametrize("method", ["stream", "list", "batch"])
def test_another_choice_is_no_gap_and_loses_no_row(method):
    reported = sampled_with_other_presets(method)
    tracker = GapTracker()
    assert not [gap for event in reported for gap in tracker.gaps_of(event)]
    assert not of(CycleFailed, reported)
    whole = Plan(select(SECTION_4, ()).parameters, method)
    longest = whole.price().seconds * 1.25 + 0.01  # of a cycle with everything
    rows = of(Sampled, reported)[3:]
    assert max(b.time - a.time for a, b in pairwise(rows)) < longest
    # Each parameter has a value in five rows, in nine around another choice, which counts anew.
    for at in range(len(rows) - 9):
        assert set().union(*(row.fresh for row in rows[at : at + 9])) == set(ALL)
    assert (len(of(PlanChanged, reported)) == 1) == (method in ("stream", "list"))


def test_preferred_parameters_are_in_every_row_by_requests():
    reported = sampled_with_other_presets("batch")
    last = of(Sampled, reported)[-50:]
    assert all({"FREQ", "INJ", "JAIR"} <= set(row.fresh) for row in last)  # inputs of FUEL_FLOW too
    assert sum("TWAT" in row.fresh for row in last) == 10
    steps = [b.time - a.time for a, b in pairwise(last)]
    everything = Plan(select(SECTION_4, ()).parameters).price().seconds
    assert sum(steps) / len(steps) < 0.6 * everything


def test_nothing_is_slowed_where_all_reach_the_requested_rate():
    reported = sampled_with_other_presets("batch", rate=10.0)
    assert len(of(PlanChanged, reported)) == 1
    assert all(set(row.fresh) == set(ALL) for row in of(Sampled, reported)[1:])


def test_divisors_are_the_users_own_choice():
    plan = Plan(select(SECTION_4, ["FREQ", "TWAT/10", "INJ"]).parameters)
    assert plan.preferring({"INJ"}) is plan
    with pytest.raises(UnknownParameter):
        Acquisition(SimulatedPlug(make_bus()), ecu_factory(), SECTION_4).prefer(["TWTA"])
