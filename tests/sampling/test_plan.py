"""Issue: from wanted parameters to requests, and §5's arithmetic."""

from __future__ import annotations

from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.catalog import shipped
from mikas.client.parameters.polling import FIXED_METHODS, STREAMS
from mikas.errors import UsageError
from mikas.sampling.plan import Plan, PlannedParameter
from protocol_codes import SECTION_4

ALL = tuple(map(PlannedParameter, SECTION_4.parameters))


def plan(*names: str, method: str = "batch", **settings: int) -> Plan:
    wanted = []
    for name in names:
        mnemonic, _, every = name.partition("/")
        wanted.append(PlannedParameter(shipped().parameter(mnemonic), int(every or 1)))
    return Plan(tuple(wanted), method, **settings)


def test_parameters_that_share_a_byte_are_requested_once():
    assert [d.code for d in plan("RXX", "BITPOW", "RDET").divisors] == [0x07]
    assert len(Plan(ALL).divisors) == 21


def test_the_smallest_divisor_of_a_shared_byte_applies():
    assert list(plan("RXX/10", "BITPOW/2").divisors.values()) == [2]


@pytest.mark.parametrize(
    ("method", "sets"), [("single", 5.0), ("batch", 17.8), ("list", 30.0), ("stream", 35.0)]
)
def test_rates_of_the_methods_are_those_of_the_law(method, sets):
    """§5: at d = 2 ms about 5.0, 17.8, 30 and 35 sets a second (it leaves data unstuffed)."""
    assert Plan(ALL, method).price().rate == pytest.approx(sets, rel=0.025)


def test_one_more_parameter_costs_its_bytes():
    before = plan("FREQ")
    after = plan("FREQ", "TWAT")
    extra = after.price().seconds - before.price().seconds
    assert extra == pytest.approx((1 + 1 + 2 / 256) * 10 / 9600)
    free = plan("RXX", "RDET")
    assert free.price() == plan("RXX").price()


wishes = st.lists(
    st.tuples(st.sampled_from(shipped().parameters), st.integers(1, 12)),
    min_size=1,
    max_size=30,
).map(lambda pairs: tuple(PlannedParameter(p, every) for p, every in pairs))


@given(wishes, st.sampled_from(FIXED_METHODS), st.integers(1, 30))
def test_every_code_is_due_as_often_as_requested(wanted, method, longest):
    made = Plan(wanted, method, longest)
    cycles = 12 * max(made.divisors.values())
    came = Counter()
    for cycle in range(cycles):
        asked = [d for request in made.requests(cycle) for d in request]
        assert all(len(request) <= longest for request in made.requests(cycle))
        if made.reads_list(cycle):
            asked += made.fast
        if method in STREAMS:
            asked += made.fast
        came.update(asked)
        assert max(Counter(asked).values(), default=0) <= 1
        if method != "list":
            assert set(asked) == set(made.due(cycle))
    for datum, every in made.divisors.items():
        expected = cycles if method in STREAMS else cycles // every
        assert abs(came[datum] - expected) <= 1


@given(wishes, st.sampled_from(FIXED_METHODS))
def test_prices_are_those_of_the_requests(wanted, method):
    plan = Plan(wanted, method)
    price = plan.price()
    asking = price.bytes * 10 / 9600 + price.requests * 0.002
    assert price.seconds == pytest.approx(asking / plan.busy_share)
    assert price.rate > 0
    assert 0 < plan.busy_share <= 1
    assert plan.busy_share == 1 or min(plan.divisors.values()) > 1


def test_slow_parameters_are_spread_over_the_cycles():
    made = plan("FREQ", "TWAT/4", "TAIR/4", "TWATI/4", "UACC/4")
    assert [len(made.due(cycle)) for cycle in range(8)] == [2] * 8


def test_a_plan_of_nothing_or_with_wrong_numbers_is_refused():
    with pytest.raises(UsageError, match="nothing"):
        Plan(())
    with pytest.raises(UsageError, match="every 0"):
        plan("FREQ/0")
    with pytest.raises(ValueError, match="at least one"):
        plan("FREQ", max_list=0)
