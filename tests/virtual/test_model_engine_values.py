"""The engine model as an engine: its values agree with each other, and with what is known of it."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from math import isfinite
from statistics import mean

import pytest

from mikas.catalog import shipped
from mikas.virtual.model import physics as ph
from mikas.virtual.model.engine import FIELDS, Engine, EngineState
from mikas.virtual.model.sensors import TABLE
from mikas.virtual.scenarios.scenario import SCENARIOS


@pytest.fixture(params=SCENARIOS, scope="module")
def name(request: pytest.FixtureRequest) -> str:
    """Of the module, so that all tests of one scenario follow each other and share its drive."""
    return str(request.param)


@cache
def drive(name: str, faults: tuple[int, ...]) -> tuple[Engine, list[EngineState]]:
    return Engine(SCENARIOS[name], seed=11, faults=faults), []


def run(name: str, faults: tuple[int, ...] = (), length: float = 320) -> list[EngineState]:
    """Eight states a second; a longer run goes on where a shorter one ended."""
    engine, states = drive(name, faults)
    wanted = int(length * 8)
    for number in range(len(states), wanted):
        engine.advance(number / 8)
        states.append(engine.state)
    return states[:wanted]


def burning(states: list[EngineState]) -> list[EngineState]:
    return [state for state in states if state.injection > 0]


def steady(states: list[EngineState]) -> list[EngineState]:
    """Those from two seconds of nearly the same speed, pedal and air on."""
    found = []
    for window in zip(*(states[i:] for i in range(16)), strict=False):
        speeds = [s.rpm for s in window]
        pedals = [s.throttle for s in window]
        even = max(speeds) - min(speeds) < 60 and max(pedals) - min(pedals) < 1
        if even and all(s.injection > 0 and s.running for s in window):
            found.append(window[-1])
    return found


def test_everything_fits_its_raw_bytes_and_the_plausible_range(name: str) -> None:
    catalog = shipped()
    for parameter in catalog.parameters:
        field = FIELDS.get(parameter.name)
        if field is None:
            continue
        values = [getattr(state, field) for state in run(name) if state.ignition_on]
        if parameter.is_flag:
            assert {type(value) for value in values} == {bool}
            continue
        assert all(isfinite(value) for value in values)
        low, high = parameter.range or (-1e9, 1e9)
        assert low <= min(values), parameter.name
        assert max(values) <= high, parameter.name
        conversion = parameter.conversion
        for value in (min(values), max(values)):
            raw = (value - float(conversion.offset)) / float(conversion.scale) + conversion.bias
            assert conversion.raw_limits[0] - 0.5 <= raw <= conversion.raw_limits[1] + 0.5


def test_injection_mixture_air_and_voltage_agree(name: str) -> None:
    for state in burning(run(name)):
        fuel = ph.air_per_stroke(state.air, state.rpm) / (14.7 * state.mixture)
        assert state.injection == pytest.approx(ph.dead_time(state.voltage) + fuel / 2.5)
        assert state.fuel == pytest.approx(fuel * state.rpm * 120 / 1e6 / 0.74)


def test_the_filling_of_the_cylinders_is_possible(name: str) -> None:
    for state in steady(run(name)):
        assert 0.08 < ph.air_per_stroke(state.air, state.rpm) / ph.STROKE_AIR < 1.02


def test_without_injection_no_fuel_is_used(name: str) -> None:
    for state in run(name):
        assert (state.injection == 0) == (state.fuel == 0)
        assert state.injection == 0 or state.ignition_on
        assert state.rpm > 0 or state.injection == 0


def test_fuel_used_is_the_sum_of_the_flow(name: str) -> None:
    states = run(name)
    total = sum((a.fuel + b.fuel) / 2 / 8 / 3600 for a, b in pairwise(states))
    assert states[-1].fuel_used - states[0].fuel_used == pytest.approx(total, rel=0.02)
    assert all(a.fuel_used <= b.fuel_used for a, b in pairwise(states))


def test_cycles_are_the_sum_of_the_speed(name: str) -> None:
    states = run(name)
    total = sum((a.rpm + b.rpm) / 2 / 120 / 8 for a, b in pairwise(states))
    assert states[-1].cycles - states[0].cycles == pytest.approx(total, rel=0.01, abs=2)
    assert all(a.cycles <= b.cycles for a, b in pairwise(states))


def test_the_idle_valve_follows_its_set_position(name: str) -> None:
    for before, after in pairwise(run(name)):
        assert abs(after.valve - before.valve) <= 96 / 8 + 1e-6
    for state in steady(run(name)):
        if state.idle:
            assert state.valve == pytest.approx(state.valve_set, abs=4)
            assert state.air == pytest.approx(state.air_set, abs=3)


@pytest.mark.parametrize(
    ("field", "low", "high"),
    [
        ("rpm", 800, 900),
        ("air", 13, 16),
        ("injection", 4, 5.5),
        ("advance", 10, 16),
        ("throttle", 0, 0),
        ("coolant", 80, 95),
        ("voltage", 13.5, 14.5),
        ("mixture", 0.95, 1.05),
        ("fuel_correction", -0.55, -0.45),
    ],
)
def test_warm_idle_has_its_values_from_the_first_moment(
    field: str, low: float, high: float
) -> None:
    values = [getattr(state, field) for state in run("warm-idle", length=900)]
    assert low <= mean(values) <= high
    assert low <= values[0] <= high
    assert sum(low <= value <= high for value in values) >= 0.995 * len(values)
    assert all(state.idle and state.running for state in run("warm-idle"))


def test_the_fan_saws_at_the_temperature_of_a_long_idle() -> None:
    states = run("warm-idle", length=900)
    turned_on = [b for a, b in pairwise(states) if b.fan and not a.fan]
    turned_off = [b for a, b in pairwise(states) if a.fan and not b.fan]
    assert turned_on
    assert turned_off
    assert all(92 <= state.coolant <= 95 for state in turned_on)
    assert all(87 <= state.coolant <= 90 for state in turned_off)
    assert mean(s.voltage for s in states if s.fan) < mean(s.voltage for s in states if not s.fan)


def test_a_cold_engine_idles_faster_richer_and_slows_down_as_it_warms() -> None:
    states = run("cold-start", length=1500)
    cold, mild, warm = (states[int(t * 8)] for t in (20, 300, 1480))
    assert 1100 <= mild.rpm <= cold.rpm <= 1500
    assert 800 <= warm.rpm <= 900
    assert cold.coolant < mild.coolant < warm.coolant
    assert cold.coolant_at_start == mild.coolant_at_start == warm.coolant_at_start == -15
    assert cold.mixture < mild.mixture < 0.95 < warm.mixture
    assert cold.valve > mild.valve > warm.valve
    assert cold.air > mild.air > warm.air
    assert states[0].intake_air < warm.intake_air


def test_full_load_has_the_air_of_the_facts() -> None:
    states = run("full-load")
    at_power = [s for s in steady(states) if abs(s.rpm - 5200) < 50 and s.throttle > 99]
    assert at_power
    for state in at_power:
        assert 370 <= state.air <= 400
        assert 0.85 <= state.mixture <= 0.92
        assert state.full_power
        assert state.voltage > 13.5
    assert max(state.rpm for state in states) < 6200
    assert any(s.rpm > 6000 and s.injection == 0 and s.throttle > 20 for s in states)  # the limit
    overrun = [s for s in states if s.throttle == 0 and s.rpm > 2200 and s.injection == 0]
    assert len(overrun) > 100
    assert all(s.rpm > 1400 for s in states if s.running and s.injection == 0)


def test_knock_takes_advance_away_and_gives_it_back() -> None:
    states = run("full-load")
    assert any(state.knock for state in states)
    assert {state.knock_corrected for state in states if state.advance_correction < -1} == {True}
    assert all(state.knock_corrected or state.advance_correction > -0.3 for state in states)
    assert -12 <= min(state.advance_correction for state in states) <= -2.5
    drops = [b for a, b in pairwise(states) if b.advance_correction < a.advance_correction - 1]
    assert drops
    assert not any(state.knock for state in run("city") + run("warm-idle"))


def test_the_starter_pulls_the_voltage_down() -> None:
    states = run("cranking-dip")
    cranking = [s for s in states if 0 < s.rpm < 300 and s.time < 19]
    assert 8 < min(s.voltage for s in cranking) < 9
    starts = [b for a, b in pairwise(states) if a.rpm == 0 and b.rpm > 0]
    assert len(starts) == 3
    assert not any(s.running for s in states if s.time < 15)
    assert states[-1].running
    assert 13.5 < states[-1].voltage < 14.5
    assert 12 < states[0].voltage < 12.8


def test_the_highway_takes_7_to_11_litres_per_100_km() -> None:
    states = run("highway", length=300)
    way = sum(s.speed / 3600 / 8 for s in states)
    assert 7 < states[-1].fuel_used / way * 100 < 11  # l/100 km
    assert any(s.injection == 0 and s.running for s in run("city"))


def test_every_row_of_the_substitutes_changes_its_parameters() -> None:
    sound = run("warm-idle", length=30)[-1]
    for row in TABLE:
        for fault in row.faults:
            failed = run("warm-idle", (fault,), length=30)[-1]
            if row.parameters == ("DET", "RDET", "UOZOC"):
                continue  # nothing to be seen at idle
            for name in row.parameters:
                assert getattr(failed, FIELDS[name]) != getattr(sound, FIELDS[name]) or (
                    name == "THR"  # closed either way
                )


@pytest.mark.parametrize("faults", [(13,), (14, 17), (21,), (23,), (25,), (26,), (31,), (41,)])
@pytest.mark.parametrize("name", ["warm-idle", "highway"])
def test_with_one_sensor_gone_the_engine_still_runs(name: str, faults: tuple[int, ...]) -> None:
    states = run(name, faults, length=40)
    assert all(state.running and state.rpm > 650 for state in states)
    fuel = states[-1].fuel_used / run(name, length=40)[-1].fuel_used
    assert 0.9 < fuel < 1.25


def test_a_stored_fault_gives_the_substitute_of_its_sensor() -> None:
    full = run("full-load", (41,), length=30)
    assert not any(state.knock or state.knock_corrected for state in full)
    assert full[-1].advance_correction == -6
    throttle = run("highway", (23,), length=40)[-1].throttle
    assert throttle == pytest.approx(run("highway", length=40)[-1].throttle, rel=0.1)
    air = run("highway", (13,), length=40)[-1].air
    assert air == pytest.approx(run("highway", length=40)[-1].air, rel=0.1)
    rising = run("cold-start", (21,), length=60)
    assert rising[-1].coolant == pytest.approx(-15 + 0.1 * (60 - 6.5), abs=1)
    assert run("warm-idle", (25,), length=30)[-1].voltage == 9.5
    assert run("warm-idle", (26,), length=30)[-1].voltage == 18.2
