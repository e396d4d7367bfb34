"""The rules of the fleet's report: when a car stands out, and when a value changes for good."""

from __future__ import annotations

from random import Random
from statistics import median

from hypothesis import given
from hypothesis import strategies as st

from mikas.fleet.report.comparing import (
    FEWEST_DRIVES,
    FEWEST_OF_TREND,
    FEWEST_OTHERS,
    LATEST,
    Outlier,
    Peers,
    trend,
    value_of,
)


def outlier(value: float, others: list[float], least: float) -> Outlier | None:
    return Peers([*others, value]).outlier(value, least)


floats = st.floats(-1e6, 1e6)


def test_a_value_is_the_median_of_the_latest_drives() -> None:
    assert value_of([1.0, 2.0]) is None
    assert value_of([9.0, 1.0, 2.0]) == 2.0
    assert value_of([100.0] * 20 + [1.0, 2.0, 3.0, 4.0, 5.0]) == 3.0


def test_too_few_others_are_no_comparison() -> None:
    assert outlier(100.0, [1.0] * (FEWEST_OTHERS - 1), 0.5) is None
    found = outlier(100.0, [1.0] * FEWEST_OTHERS, 0.5)
    assert found is not None
    assert (found.value, found.others, found.count) == (100.0, 1.0, FEWEST_OTHERS)


def test_one_bad_car_does_not_hide_another() -> None:
    sound = [14.0, 14.1, 14.2, 14.1, 14.0, 14.1]
    assert outlier(12.4, [*sound, 9.0], 0.5) is not None
    assert outlier(14.2, [*sound, 9.0, 9.1], 0.5) is None


@given(st.lists(floats, min_size=FEWEST_OTHERS, max_size=30), floats, st.floats(0.1, 100))
def test_a_difference_below_the_least_never_counts(others, value, least) -> None:
    found = outlier(value, others, least)
    if found is not None:
        assert abs(value - found.others) > least
        assert found.low <= found.others <= found.high


@given(st.lists(floats, min_size=FEWEST_OTHERS, max_size=30))
def test_a_car_like_half_of_the_others_never_stands_out(others) -> None:
    middle = sorted(others)[len(others) // 2]
    found = outlier(middle, [middle, middle, *others, middle], 0.0)
    assert found is None


@given(st.lists(floats, min_size=FEWEST_OTHERS + 1, max_size=12), st.floats(0, 100))
def test_all_cars_together_are_compared_as_each_alone(values, least) -> None:
    peers = Peers(values)
    for at, value in enumerate(values):
        others = values[:at] + values[at + 1 :]
        middle = median(others)
        spread = 1.4826 * median(abs(each - middle) for each in others)
        found = peers.outlier(value, least)
        assert (found is not None) == (abs(value - middle) > max(3.5 * spread, least))
        if found is not None:
            assert (found.others, found.low, found.high) == (middle, min(others), max(others))


def test_a_lasting_change_is_found_and_noise_is_not() -> None:
    rising = [30.0 + 3 * number for number in range(10)]
    found = trend(rising, 10)
    assert found is not None
    assert (found.first, found.last, found.count) == (33.0, 54.0, 10)
    falling = trend(rising[::-1], 10)
    assert falling is not None
    assert falling.first > falling.last
    assert trend(rising[: FEWEST_OF_TREND - 1], 1) is None
    assert trend(rising, 30) is None  # less than counts
    assert trend([10.0] * 20, 0) is None
    step_back = [*rising[:5], *rising[:5]]
    assert trend(step_back, 1) is None
    spike = [30.0] * 9 + [300.0]
    assert trend(spike, 1) is None


def test_chance_is_taken_for_a_change_once_in_a_thousand_at_most() -> None:
    random = Random(5)
    series = ([random.gauss(0, 1) for _ in range(12)] for _ in range(4000))
    assert sum(trend(each, 0.0) is not None for each in series) <= 8


@given(st.lists(floats, min_size=FEWEST_OF_TREND, max_size=20))
def test_a_change_has_the_other_sign_backwards(series) -> None:
    forth, back = trend(series, 0.0), trend(series[::-1], 0.0)
    assert (forth is None) == (back is None)
    if forth is not None and back is not None:
        assert (forth.first, forth.last) == (back.last, back.first)


def test_the_numbers_are_those_of_the_documentation() -> None:
    assert (LATEST, FEWEST_DRIVES, FEWEST_OTHERS, FEWEST_OF_TREND) == (5, 3, 4, 8)
