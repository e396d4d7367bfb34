"""The engine model as a machine: same input, same states; strokes; faults; any scenario at all."""

from __future__ import annotations

from dataclasses import astuple, replace
from math import inf, isclose

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.catalog import shipped
from mikas.catalog.loading.source import parse_source
from mikas.virtual.model.engine import FIELDS, Engine
from mikas.virtual.model.plant import _settled_plant, _warm_plant
from mikas.virtual.scenarios.scenario import SCENARIOS, from_source
from protocol_codes import NAMES

CITY = SCENARIOS["city"]
LATER = replace(CITY, start=replace(CITY.start, running=False))  # begins quickly: nothing settles

times = st.lists(st.floats(0, 20), max_size=8).map(sorted)
seeds = st.integers(0, 5)


def scenario(text: str):
    return from_source(parse_source("test.toml", text.encode()))


def at(engine: Engine, time: float):
    engine.advance(time)
    return engine.state


def test_the_same_seed_gives_the_same_states() -> None:
    one, other = Engine(CITY, seed=7), Engine(CITY, seed=7)
    assert [at(one, t) for t in range(30)] == [at(other, t) for t in range(30)]


def test_a_kept_start_is_the_same_as_a_new_one() -> None:
    first = Engine(CITY, seed=7, faults=[13])
    states = [at(first, t) for t in range(30)]
    kept = Engine(CITY, seed=7, faults=[13])
    for kept_plants in (_settled_plant, _warm_plant):
        kept_plants.cache_clear()
    new = Engine(CITY, seed=7, faults=[13])
    assert _settled_plant.cache_info().misses == 1
    assert [at(kept, t) for t in range(30)] == [at(new, t) for t in range(30)] == states


def test_another_seed_gives_other_states() -> None:
    assert at(Engine(CITY, seed=1), 5).rpm != at(Engine(CITY, seed=2), 5).rpm


@settings(max_examples=30)
@given(times, seeds)
def test_it_does_not_matter_how_often_it_is_advanced(stops: list[float], seed: int) -> None:
    by_steps, at_once = Engine(SCENARIOS["cold-start"], seed), Engine(SCENARIOS["cold-start"], seed)
    for stop in stops:
        by_steps.advance(stop)
    assert at(by_steps, 20) == at(at_once, 20)


@settings(max_examples=30)
@given(times, st.sampled_from([13, 21, 23, 41, 53]), st.floats(0, 15), st.floats(0, 5))
def test_reads_change_no_value_while_faults_change(
    stops: list[float], fault: int, begin: float, length: float
) -> None:
    def run(extra: list[float]) -> object:
        engine = Engine(LATER, 3)
        for stop in sorted([*extra, begin, begin + length]):
            engine.advance(stop)
            if stop == begin:
                engine.faults.add(fault)
            if stop == begin + length:
                engine.faults = set()
        return at(engine, 20)

    assert run(stops) == run([])


@settings(max_examples=20)
@given(times, st.integers(0, 4))
def test_looking_ahead_changes_nothing(stops: list[float], stroke: int) -> None:
    asked, quiet = Engine(SCENARIOS["cranking-dip"], 1), Engine(SCENARIOS["cranking-dip"], 1)
    for stop in stops:
        asked.advance(stop)
        asked.next_cycle_time(stroke, stop)
        asked.next_cycle_time(0, stop + 1)
    assert at(asked, 20) == at(quiet, 20)


def track(low: int, high: int):
    points = st.dictionaries(st.integers(1, 29), st.integers(low, high), max_size=4)
    whole = st.integers(low, high)
    return st.builds(lambda first, rest: [[0, first], *sorted(rest.items())], whole, points)


@settings(max_examples=40)
@given(
    st.fixed_dictionaries(
        {"key": track(0, 1)},
        optional={
            "starter": track(0, 1),
            "speed": track(0, 200),
            "throttle": track(0, 100),
            "gear": track(0, 5),
            "load": track(0, 100),
        },
    ),
    st.integers(-40, 50),
    st.integers(-40, 120),
    st.booleans(),
    st.sets(st.sampled_from([13, 17, 21, 23, 25, 26, 31, 41, 53]), max_size=3),
)
def test_any_scenario_stays_in_the_range_of_the_raw_bytes(
    timeline: dict[str, list[list[int]]],
    ambient: int,
    coolant: int,
    running: bool,
    faults: set[int],
) -> None:
    lines = [f"{name} = {[list(point) for point in points]}" for name, points in timeline.items()]
    start = f"ambient = {ambient}\ncoolant = {coolant}\nrunning = {str(running).lower()}"
    text = f"duration = 30\n[start]\n{start}\n[timeline]\n" + "\n".join(lines)
    engine = Engine(scenario(text), faults=faults)
    for time in range(40):
        state = at(engine, time)
        for parameter in shipped().parameters:
            if parameter.name in FIELDS and not parameter.is_flag:
                value, rule = getattr(state, FIELDS[parameter.name]), parameter.conversion
                raw = (value - float(rule.offset)) / float(rule.scale) + rule.bias
                assert rule.raw_limits[0] - 0.5 <= raw <= rule.raw_limits[1] + 0.5, parameter.name


def test_going_back_does_nothing() -> None:
    engine = Engine(CITY)
    later = at(engine, 3)
    assert at(engine, 1) is later


def test_a_state_is_computed_once_a_moment() -> None:
    engine = Engine(CITY)
    assert at(engine, 3) is at(engine, 3)
    assert at(engine, 3) is not at(engine, 3.001)


def test_every_parameter_of_section_4_has_a_field() -> None:
    assert set(NAMES) - set(FIELDS) == {"MINERR"}  # the unit's own, not the engine's
    assert all(hasattr(Engine().state, field) for field in FIELDS.values())


@pytest.mark.parametrize("stroke", range(5))
@pytest.mark.parametrize("name", ["warm-idle", "city", "full-load"])
def test_strokes_are_where_the_crankshaft_is(name: str, stroke: int) -> None:
    engine = Engine(SCENARIOS[name], 2)
    phase = max(0, stroke - 1) / 4
    time, marks = 8.0, []
    while time < 14:
        engine.advance(time)
        later = engine.next_cycle_time(stroke, time)
        assert later > time
        assert engine.next_cycle_time(stroke, later - 1e-4) == pytest.approx(later, abs=1e-9)
        time = later
        marks.append(at(engine, time).cycles - phase)
    numbers = [round(mark) for mark in marks]
    assert marks == pytest.approx(numbers, abs=1e-5)
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))  # none left out


def test_strokes_are_a_quarter_of_a_cycle_apart() -> None:
    engine = Engine()
    first = engine.next_cycle_time(1, 1.0)
    assert engine.next_cycle_time(0, 1.0) == first
    following = [engine.next_cycle_time(stroke, first) - first for stroke in (2, 3, 4, 1)]
    assert following == pytest.approx([0.035, 0.071, 0.106, 0.141], rel=0.06)


def test_strokes_in_the_future_are_those_of_then() -> None:
    ahead, there = Engine(CITY, 4), Engine(CITY, 4)
    ahead.advance(3)
    there.advance(21.7)
    assert ahead.next_cycle_time(2, 21.7) == there.next_cycle_time(2, 21.7)


def test_a_standing_engine_has_no_strokes() -> None:
    engine = Engine(SCENARIOS["cold-start"])
    engine.advance(2.0)
    assert engine.next_cycle_time(0, 2.0) > 3  # the starter has yet to turn
    standing = scenario("duration = 60\n[timeline]\nkey = 1")
    assert Engine(standing).next_cycle_time(0, 0.0) == inf


def test_with_the_key_off_there_are_no_strokes() -> None:
    engine = Engine(SCENARIOS["key-off"])
    engine.advance(20.5)
    assert engine.next_cycle_time(0, 20.5) == inf
    engine.advance(39.0)
    assert 39.0 < engine.next_cycle_time(0, 39.0) < 40.5


def test_a_crank_sensor_fault_ends_strokes_and_injection_and_can_be_cured() -> None:
    engine = Engine()
    engine.advance(5)
    assert engine.next_cycle_time(0, 5.0) < inf
    engine.faults.add(53)
    state = at(engine, 5.1)
    assert (state.rpm, state.injection, state.fuel, state.running) == (0, 0, 0, False)
    assert engine.next_cycle_time(0, 5.1) == inf
    assert at(engine, 9).voltage < 13
    engine.faults.clear()
    assert at(engine, 25).running  # the driver starts it again
    assert 800 < at(engine, 40).rpm < 950


def test_a_fault_at_the_start_has_its_substitute_at_the_start() -> None:
    assert Engine(faults=[53]).state.rpm == 0
    assert Engine(faults=(17,)).state.intake_air == 20
    assert Engine(faults={22}).state.coolant == 80


def test_power_follows_the_key() -> None:
    engine = Engine(SCENARIOS["key-off"])
    assert engine.powered
    assert engine.scenario.timeline.next_key_change(0.0) == 20
    off = at(engine, 20)
    assert not engine.powered
    assert (off.ignition_on, off.running, off.rpm, off.injection) == (False, False, 0, 0)
    assert engine.scenario.timeline.next_key_change(20.0) == 35
    on = at(engine, 36)
    assert on.ignition_on
    assert not on.running
    assert 12 < on.voltage < 12.8


def test_half_an_hour_in_one_go_gives_finite_values() -> None:
    engine = Engine(SCENARIOS["key-off"])
    assert all(isinstance(v, bool) or abs(v) < inf for v in astuple(at(engine, 1800)))


def test_cycles_run_on_inside_a_step() -> None:
    engine = Engine()
    a, b = at(engine, 1 / 64), at(engine, 1 / 33)
    assert a.rpm == b.rpm
    assert isclose((b.cycles - a.cycles) * 120, (1 / 33 - 1 / 64) * a.rpm, rel_tol=0.03)
