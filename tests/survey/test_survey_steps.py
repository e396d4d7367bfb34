"""The searches of a survey: the greatest number that is taken, lists with a wanted checksum."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.framing import checksum
from mikas.survey.concluding.codes import moves_of
from mikas.survey.concluding.streams import slope_of
from mikas.survey.steps.checksums import listed_codes
from mikas.survey.steps.greatest import MOST, CountedResponse, greatest
from mikas.survey.steps.streams import rate_of

FORMS = st.sampled_from(["short", "01", "silent", "other"])


@given(st.integers(1, MOST), FORMS)
def test_the_greatest_number_is_found_and_never_passed_by_far(limit, form):
    """A unit without a check of its own is asked for little more than it takes."""
    asked = []

    def ask(count: int) -> CountedResponse:
        asked.append(count)
        if count <= limit:
            return CountedResponse(count, None)
        return CountedResponse(limit if form == "short" else 0, form)

    found = greatest(ask)
    assert found == {"limit": limit, "beyond": None if limit == MOST else form}
    assert max(asked) <= min(MOST, max(2, 2 * limit))
    assert len(asked) <= 24  # eight numbers going up, seven between; what fails is asked twice


@given(st.integers(1, MOST), FORMS, st.integers(0, 24), st.sampled_from(["short", "01", "other"]))
def test_one_response_that_the_line_has_spoiled_changes_no_limit(limit, form, place, spoiled):
    asked = []

    def ask(count: int) -> CountedResponse:
        asked.append(count)
        if len(asked) == place + 1:
            return CountedResponse(count // 2, spoiled)
        if count <= limit:
            return CountedResponse(count, None)
        return CountedResponse(limit if form == "short" else 0, form)

    beyond = None if limit == MOST else form
    found = greatest(ask)
    assert found["limit"] == limit
    assert found["beyond"] == beyond or place + 1 == len(asked)


@given(FORMS)
def test_a_unit_that_takes_nothing_has_no_limit(form):
    found = greatest(lambda _: CountedResponse(0, form))
    assert found == {"limit": None, "beyond": form}


@given(
    st.dictionaries(st.integers(0, 255), st.integers(0, 255), max_size=20),
    st.integers(0, 255),
    st.integers(1, 24),
)
def test_a_list_has_the_wanted_sum_or_there_is_none(weights, total, longest):
    listed = listed_codes(weights, total, longest)
    if listed is None:
        assert not any((one + other) & 0xFF == total for one in weights.values()
                       for other in weights.values()) or longest < 2  # fmt: skip
        return
    assert 2 <= len(listed) <= longest
    assert sum(weights[code] for code in listed) & 0xFF == total
    own = {code: code for code in weights}
    request = listed_codes(own, (-0x0D - 0x61) & 0xFF, longest)
    if request is not None:
        assert checksum(bytes([0x61, *request])) == 0x0D


def samples(standing, idle, raised):
    states = {"standing": standing, "idle": idle, "raised": raised}
    return {state: {"30": [f"{value:02X}" for value in each]} for state, each in states.items()}


def test_what_a_code_follows():
    def follows(standing, idle, raised):
        return moves_of(samples(standing, idle, raised))["30"]

    assert follows([5, 5], [5, 5], [5, 5]) == "constant"
    assert follows([0, 0], [21, 22], [60, 62]) == "rpm"
    assert follows([0, 0], [1, 1], [1, 1]) == "key"  # a flag
    assert follows([120, 121], [140, 141], [140, 142]) == "key"
    assert follows([49, 49], [49, 49], [50, 50]) == "other"  # one step in minutes
    assert follows([80, 80], [81, 84], [83, 85]) == "other"  # a temperature that drifts
    assert follows([1, 9], [3, 8], [2, 7]) == "other"


@given(st.floats(0.02, 0.5), st.integers(3, 26), st.sampled_from(["lost", "doubled"]))
def test_a_response_that_the_line_loses_or_doubles_changes_no_rate(period, place, trouble):
    times = [place * period for place in range(30)]
    spoiled = [*times[:place], *times[place + 1 :]]
    if trouble == "doubled":
        spoiled = sorted([*times, times[place] + period / 10])
    assert rate_of(spoiled, 0.0) == pytest.approx(1 / period, rel=0.01)


def test_cycles_that_the_unit_itself_skips_are_in_its_rate():
    times = [cycle * 0.1 for cycle in range(30) if cycle % 3]
    assert rate_of(times, 0.0) == pytest.approx(20 / 3, rel=0.05)
    assert rate_of([5.0] * 9, 0.0) is None  # a link that hands all over at once
    assert rate_of([1.0, 2.0], 0.0) is None


@given(st.floats(-5, 5), st.floats(-5, 5))
def test_points_on_a_line_give_its_slope(slope, offset):
    points = [(x, slope * x + offset) for x in (0.0, 850.0, 2500.0)]
    assert abs(slope_of(points) - slope) < 1e-6
