"""Units that lack what most have, or take few codes at a time (D10, D11): sampled as well as can
be.
"""

from __future__ import annotations

from contextlib import closing

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

from mikas.sampling.events import MethodChosen, ParameterDropped, Sampled
from mikas.virtual.quirks import GROUPS, EcuQuirks, LongList, Unknown
from virtual_harness import make_bus


@pytest.mark.parametrize("lacking", [{0x29}, {0x29, 0x2C, 0x1A, 0x1E}])
@pytest.mark.parametrize("unknown", Unknown)
@pytest.mark.parametrize("long_list", LongList)
def test_a_unit_that_lacks_commands_is_sampled_by_its_best_method(lacking, unknown, long_list):
    lacks = GROUPS["stream"] | GROUPS["list"]
    bus = make_bus(
        quirks=EcuQuirks(missing=lacks, unknown=unknown, max_list=3, long_list=long_list)
    )
    for code in lacking:
        del bus.ecu.responder.car.data[code]
    events = run(bus)
    (chosen,) = of(MethodChosen, events)
    assert chosen.method == "batch"
    assert len(of(Sampled, events)[-1].fresh) == 23 - len(lacking)
    assert_values_are_the_units(events)


@pytest.mark.parametrize("method", ["auto", "single", "batch"])
@pytest.mark.parametrize("long_list", LongList)
def test_a_refusal_that_looks_like_a_datum_is_dropped(method, long_list):
    """A unit that takes one code at a time, and answers 01 to what it does not know."""
    bus = make_bus(
        quirks=EcuQuirks(
            max_list=1, unknown=Unknown.ERROR, long_list=long_list, missing=GROUPS["list"]
        )
    )
    for code in (0x1A, 0x07):
        del bus.ecu.responder.car.data[code]
    events = run(bus, "FREQ", "TWAT", "RXX", method=method)
    assert [d.name for d in of(ParameterDropped, events)] == ["TWAT", "RXX"]
    (first, *_, last) = of(Sampled, events)
    assert first.time < 8
    assert list(last.fresh) == ["FREQ"]
    rate = 19 / (last.time - of(Sampled, events)[-20].time)
    assert rate > 100  # one request of one code takes 9 ms


@pytest.mark.parametrize("takes", [3, 7])
def test_prices_use_the_units_longest_list(takes):
    lacks = GROUPS["stream"] | GROUPS["list"]
    plug = SimulatedPlug(make_bus(quirks=EcuQuirks(max_list=takes, missing=lacks)))
    sampler = make_sampler(plug)
    with closing(sampler.run()) as events:
        reported = take(events, settled)
        assert sampler.plan.max_list == sampler.ecu.limits().max_list
        took = [s.time for s in of(Sampled, reported)[-20:]]
        every = sampler.price([])
        assert every.requests == -(-21 // sampler.plan.max_list)
        assert every.seconds == pytest.approx((took[-1] - took[0]) / 19, rel=0.01)
        few = sampler.price(["FREQ", "TWAT"])
        sampler.reconfigure(["FREQ", "TWAT"])
        reported = take(events, lambda e: len(of(Sampled, e)) == 60)
    took = [s.time for s in of(Sampled, reported)[-20:]]
    real = (took[-1] - took[0]) / 19
    assert few.requests == 1
    assert few.seconds == pytest.approx(real, abs=0.004)  # the data are stuffed more than most


def test_a_sufficient_rate_is_judged_by_measured_cycles(tmp_path):
    """A unit that takes three codes: what all of them took says nothing bad of two."""
    quirks = EcuQuirks(max_list=3, missing=GROUPS["list"])
    run(make_bus(quirks=quirks), state=tmp_path)
    reported = run(make_bus(quirks=quirks), "FREQ", "TWAT", state=tmp_path, rate=40.0)
    assert (
        of(MethodChosen, reported)[-1].method == "batch"
    )  # not by a stream, which does more to the unit
