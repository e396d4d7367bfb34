"""When an engine is at warm idle, by its values alone."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_harness import START, rows

from mikas.recording.table.channels import Rows
from mikas.report.measurements.warm_idle import ENOUGH, PAUSE, SETTLING, WarmIdleFinder

NAMES = ("TWAT", "FREQ", "FREQX", "THR", "RXX")


def look(*stretches, names=NAMES):
    finder = WarmIdleFinder([name for name in names if any(name in s.values for s in stretches)])
    masks = [finder.find(stretch) for stretch in stretches]
    return finder.found, np.concatenate(masks)


def test_warm_idle_begins_after_settling_and_lasts() -> None:
    idle, mask = look(rows(60))
    assert idle.spans == ((START + SETTLING, START + 59.9),)
    assert idle.enough
    assert idle.unknown == ()
    assert mask.sum() == 600 - 30
    assert all(observed.held for observed in idle.rules)


@pytest.mark.parametrize(
    ("name", "value"), [("TWAT", 69), ("FREQ", 480), ("FREQ", 1320), ("FREQ", 0), ("THR", 6)]
)
def test_each_broken_rule_ends_warm_idle(name, value) -> None:
    idle, mask = look(rows(60, **{name: value}))
    assert not mask.any()
    assert idle.spans == ()
    assert not idle.enough
    (broken,) = [observed for observed in idle.rules if not observed.held]
    assert (broken.name, broken.least, broken.most) == (name, value, value)


@pytest.mark.parametrize(
    ("name", "value"), [("TWAT", 120), ("TWAT", 70), ("FREQ", 1280), ("THR", 5)]
)
def test_a_bad_idle_is_still_one(name, value) -> None:
    idle, _ = look(rows(60, **{name: value}))
    assert idle.enough


def test_a_blip_of_the_throttle_begins_it_anew() -> None:
    idle, _ = look(rows(60, THR=lambda t: np.where((t >= 30) & (t < 31), 20, 0)))
    assert idle.spans == (
        (START + SETTLING, START + 29.9),
        (START + 31 + SETTLING, START + 59.9),
    )


def test_a_pause_parts_two_spans() -> None:
    idle, _ = look(rows(20), rows(20, start=START + 20 + PAUSE))
    assert len(idle.spans) == 2
    assert idle.spans[1][0] == START + 20 + PAUSE + SETTLING


def only(until, value=0.0):
    return lambda times: np.where(times < until, value, np.nan)


def test_a_throttle_that_is_not_asked_any_more_is_replaced_by_the_units_own_sign() -> None:
    idle, _ = look(rows(60, THR=only(20)))
    assert idle.spans == ((START + SETTLING, START + 59.9),)
    (throttle,) = [observed for observed in idle.rules if observed.name == "THR"]
    assert throttle.instead is not None
    assert throttle.missing == 0


def test_a_sign_that_is_not_there_does_not_make_an_idle() -> None:
    idle, _ = look(rows(60, THR=only(20), RXX=0.0))
    assert idle.seconds == pytest.approx(20 - SETTLING + PAUSE, abs=0.2)


def test_the_throttle_itself_counts_where_it_is_known() -> None:
    idle, _ = look(rows(60, THR=30.0, RXX=1.0))
    assert idle.spans == ()


def test_samples_without_the_rules_values_are_counted() -> None:
    idle, _ = look(rows(60, THR=only(20), RXX=None))
    assert idle.seconds == pytest.approx(20 - SETTLING + PAUSE, abs=0.2)
    (throttle,) = [observed for observed in idle.rules if observed.name == "THR"]
    assert throttle.missing == pytest.approx(40 - PAUSE, abs=0.2)
    assert [observed.missing for observed in idle.rules if observed is not throttle] == [0, 0]


def test_the_other_speed_does_as_well() -> None:
    idle, _ = look(rows(60, FREQ=only(20, 840.0)))
    assert idle.spans == ((START + SETTLING, START + 59.9),)


def test_too_short_a_warm_idle_is_not_enough() -> None:
    idle, _ = look(rows(SETTLING + ENOUGH - 0.5))
    assert 0 < idle.seconds < ENOUGH
    assert not idle.enough


@pytest.mark.parametrize("missing", ["TWAT", "FREQ", "THR"])
def test_what_was_not_recorded_leaves_it_open(missing) -> None:
    idle, mask = look(rows(60, **{missing: None, "FREQX": None, "RXX": None}))
    assert not mask.any()
    (rule,) = idle.unknown
    assert missing in rule.names


def test_the_unit_s_own_flag_stands_in_for_the_throttle() -> None:
    assert look(rows(60, THR=None))[0].enough
    assert not look(rows(60, THR=None, RXX=0))[0].enough
    assert look(rows(60, RXX=0))[0].enough  # the throttle is there: it counts


def test_the_other_speed_stands_in() -> None:
    assert look(rows(60, FREQ=None))[0].enough


def test_values_that_come_one_by_one_hold_for_a_while() -> None:
    def every(count, turn, value):
        def column(times):
            rows_ = np.arange(times.size)
            return np.where(rows_ % count == turn, value, np.nan)

        return column

    idle, _ = look(
        rows(60, TWAT=every(100, 0, 88), FREQ=every(3, 1, 840), THR=every(3, 2, 0), FREQX=None)
    )
    assert idle.enough
    idle, _ = look(rows(60, TWAT=every(600, 0, 88)))  # once: no longer known after a while
    assert idle.spans[-1][1] <= START + 15


def test_an_old_value_does_not_hold_over_a_pause() -> None:
    later = rows(20, start=START + 120, TWAT=None)
    idle, mask = look(rows(20), later)
    assert not mask[200:].any()
    assert len(idle.spans) == 1


def test_without_rows_there_is_no_warm_idle() -> None:
    idle, mask = look(Rows(np.empty(0), {name: np.empty(0) for name in NAMES}))
    assert idle.spans == ()
    assert mask.size == 0
    assert idle.seconds == 0


values = st.sampled_from([np.nan, 60.0, 88.0])
speeds = st.sampled_from([np.nan, 0.0, 840.0, 840.0, 2000.0])


@given(
    st.lists(st.tuples(st.floats(0.1, 4), values, speeds), min_size=1, max_size=60),
    st.lists(st.integers(1, 59), max_size=4),
)
def test_how_rows_are_cut_changes_nothing(samples, cuts) -> None:
    steps, coolant, speed = map(np.array, zip(*samples, strict=True))
    whole = Rows(np.cumsum(steps), {"TWAT": coolant, "FREQ": speed, "THR": speed * 0})
    idle, mask = look(whole)
    edges = sorted({0, len(samples), *(cut for cut in cuts if cut < len(samples))})
    parts = [
        Rows(whole.times[a:b], {name: column[a:b] for name, column in whole.values.items()})
        for a, b in pairwise(edges)
    ]
    again, pieces = look(*parts)
    np.testing.assert_array_equal(pieces, mask)
    assert again == idle
    inside = [t for t, hit in zip(whole.times, mask, strict=True) if hit]
    for began, ended in idle.spans:
        assert began in inside
        assert ended in inside
