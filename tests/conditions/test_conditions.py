"""When a rule acts: against the same rule written moment by moment, and case by case."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.catalog import shipped
from mikas.catalog.formula_syntax import parse
from mikas.client import Passport
from mikas.client.parameters.readings import decode
from mikas.conditions import ActionRule, ConditionWatch, read_actions
from mikas.conditions.definition import LEAST_PAUSE
from mikas.conditions.evaluation import PAUSE
from mikas.errors import UnknownParameter
from mikas.sampling.events import Gap, Sampled, UnitFound

CATALOG = shipped()
HOT = ActionRule("hot", parse("TWAT > 100", {}), when="TWAT > 100", sound=True)


def rule(when="TWAT > 100", until="", **more):
    release = parse(until, {}) if until else None
    return replace(HOT, condition=parse(when, {}), when=when, until=until, release=release, **more)


def acted(it, samples, name="TWAT"):
    """The times at which the rule acts; a value of None: the channel was not read."""
    watch = ConditionWatch([it], CATALOG)
    found = []
    for time, value in samples:
        values = {} if value is None else {name: value}
        found += [fired.time for fired in watch.add(time, values)]
    return found


def every(step, *values, start=0.0):
    return [(start + step * at, value) for at, value in enumerate(values)]


def test_a_rule_acts_once_its_condition_has_held_for_so_long():
    samples = every(0.5, 90, 101, 102, 103, 104, 105)
    assert acted(rule(), samples) == [0.5]
    assert acted(rule(hold=1.5), samples) == [2.0]
    assert acted(rule(hold=3), samples) == []


def test_it_acts_again_only_after_the_condition_did_not_hold():
    assert acted(rule(), every(1, 101, 101, 99, 101, 101)) == [0, 3]


def test_hysteresis_keeps_it_from_chattering():
    chatter = every(1, 101, 99, 101, 99, 101, 94, 101)
    assert acted(rule(), chatter) == [0, 2, 4, 6]
    assert acted(rule(until="TWAT < 95"), chatter) == [0, 6]


def test_once_in_a_time_and_once_at_all():
    samples = every(1, *[101, 99] * 6)
    assert acted(rule(again=5), samples) == [0, 6]
    assert acted(rule(once=True), samples) == [0]


@pytest.mark.parametrize("again", [0.0, 0.2])
def test_a_noisy_value_acts_once_in_a_second_at_most(again):
    noise = every(1 / 32, *[101, 99] * 80)  # 5 s, at each second row
    assert acted(rule(again=again), noise) == [0, 1, 2, 3, 4]


def test_a_pause_that_forbids_it_ends_while_the_condition_still_holds():
    assert acted(rule(again=5), every(1, 101, 99, *[101] * 8)) == [0, 5]


def test_what_was_not_seen_did_not_hold():
    steps = every(1, 101, 101)
    after = every(1, 101, 101, 101, 101, start=30)
    assert acted(rule(hold=3), steps + after) == [33]


def test_a_channel_that_is_read_seldom_counts_until_the_next_time():
    slow = [(at * 0.5, 101 if at % 10 == 0 else None) for at in range(41)]
    assert acted(rule(hold=10), slow) == [15.0]  # its pace is known from the second value on
    gone = [(at * 0.5, 101 if at % 10 == 0 and at < 20 else None) for at in range(81)]
    assert acted(rule(hold=20), gone) == []


def test_no_value_neither_holds_nor_releases():
    samples = [(0, 101), (1, None), (1 + PAUSE + 1, None), (5, None), (6, 101), (7, 99), (8, 101)]
    assert acted(rule(), samples) == [0, 8]


def test_a_gap_another_unit_and_a_clock_set_back_begin_again():
    watch = ConditionWatch([rule(hold=2)], CATALOG)

    def hot(*times):
        return [fired.time for time in times for fired in watch.add(time, {"TWAT": 101})]

    assert hot(0, 1) == []
    assert watch.follow(Gap(1.5, 1.0, None)) == ()
    assert hot(2, 3) == []
    assert watch.follow(UnitFound(3.2, 10, Passport((None,) * 3, (None,) * 5), True)) == ()
    assert hot(3.5, 4.5) == []
    assert hot(1, 2) == []  # the clock ran back
    assert hot(3) == [3]


def test_a_clock_set_back_does_not_keep_a_rule_waiting_until_that_time_comes_again():
    samples = [*every(1, 90, 101, start=3600.0), *every(1, 90, 101, 90, 101)]
    assert acted(rule(again=60), samples) == [3601, 1]


def test_derived_channels_are_computed_from_what_was_read():
    it = rule("FUEL_FLOW > 0.0001")
    watch = ConditionWatch([it], CATALOG)
    assert set(watch.requires) == set(CATALOG.required_by(["FUEL_FLOW"]))
    values = dict.fromkeys(watch.requires, 5.0)
    (fired,) = watch.add(1.0, values)
    assert fired.values["FUEL_FLOW"] > 0
    assert watch.value(it) == 1.0


def test_another_interpretation_of_the_session_changes_no_condition():
    parameter = CATALOG.parameter("RCOK")
    raw = b"\x80"
    corrected = parameter.decode(raw)
    assert parameter.decode(raw, "alternative") != corrected
    watch = ConditionWatch([rule(f"abs(RCOK - ({corrected})) < 0.001")], CATALOG)
    shown = decode(parameter, raw, 1.0, "alternative")
    assert len(watch.follow(Sampled(1.0, {"RCOK": shown}, {}))) == 1


def test_a_formula_without_a_value_does_not_act():
    assert acted(rule("1 / (TWAT - 100) > 0"), every(1, 100, 100)) == []


def test_a_rule_of_another_catalog_is_refused():
    with pytest.raises(UnknownParameter):
        ConditionWatch([rule("NOPE > 1")], CATALOG)


TIMES = st.lists(st.sampled_from([0.25, 0.5, 1.0, 1.75, 4.0]), min_size=1, max_size=40)
VALUES = st.sampled_from([90.0, 96.0, 101.0, None])


def pauses(samples):
    """The times that come too late after the value before: by the two steps before them."""
    found, before = set(), []
    for time, value in samples:
        if value is None:
            before = []
            continue
        steps = [later - earlier for earlier, later in pairwise(before)][-2:]
        usual = 2.5 * min(steps) if steps else 0
        if before and time - before[-1] > min(max(PAUSE, usual), 60):
            found.add(time)
        before.append(time)
    return found


def by_hand(hold, low, again, once, samples):
    """The same rule, from the whole past of each moment."""
    acts, begins = [], pauses(samples)
    for at, (time, value) in enumerate(samples):
        if value is None or value <= 100:
            continue
        since = time
        for earlier, before in reversed(samples[:at]):
            if since in begins or before is None or before <= 100:
                break
            since = earlier
        free = not acts or any(
            before is not None and before < low
            for moment, before in samples[:at]
            if moment > acts[-1]
        )
        waits = acts and time - acts[-1] < max(again, LEAST_PAUSE)
        if time - since >= hold and free and not waits and not (once and acts):
            acts.append(time)
    return acts


@given(
    TIMES, st.data(), st.sampled_from([0.0, 1.0, 2.5]), st.sampled_from([101.0, 95.0]),
    st.sampled_from([0.0, 0.5, 3.0, 10.0]), st.booleans(),
)  # fmt: skip
def test_against_the_rule_written_by_hand(steps, data, hold, low, again, once):
    time, samples = 0.0, []
    for step in steps:
        time += step
        samples.append((time, data.draw(VALUES)))
    until = "TWAT < 95" if low == 95.0 else "TWAT <= 100"
    watch = ConditionWatch([rule(until=until, hold=hold, again=again, once=once)], CATALOG)
    found = []
    for at, value in samples:
        if value is None:
            watch.interrupt()  # as after a gap
        found += [fired.time for fired in watch.add(at, {} if value is None else {"TWAT": value})]
    assert found == by_hand(hold, 100.5 if low == 101.0 else 95.0, again, once, samples)


@given(
    st.lists(
        st.tuples(
            st.floats(allow_nan=True, allow_infinity=True),
            st.dictionaries(
                st.sampled_from(["TWAT", "FREQ", "NOPE"]), st.floats(allow_nan=True), max_size=3
            ),
        ),
        max_size=30,
    )
)
def test_no_sample_breaks_it(samples):
    rules = [rule(hold=1, again=2), rule("FREQ / TWAT > 3", "sqrt(FREQ) < 2")]
    watch = ConditionWatch(rules, CATALOG)
    for time, values in samples:
        for fired in watch.add(time, values):
            assert fired.since <= fired.time


def test_ten_thousand_samples_of_fifty_rules_keep_no_more_than_the_last():
    text = "".join(
        f'[action.r{n}]\nwhen = "TWAT > {n} and FREQ > {n}"\nmark = "m"\n' for n in range(50)
    )
    watch = ConditionWatch(read_actions("a.toml", text, CATALOG).rules, CATALOG)
    for at in range(2000):
        watch.add(at * 0.1, {"TWAT": 50.0 + at % 7, "FREQ": 800.0})
    assert len(watch._latest) == 2  # noqa: SLF001  (the bound is the point)
