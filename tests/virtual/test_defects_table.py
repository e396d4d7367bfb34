"""The table of defects: complete, in the model's limits, and wear that is no defect."""

from __future__ import annotations

import re
from dataclasses import fields
from decimal import Decimal
from pathlib import Path

import pytest

from mikas.catalog.loading.fields import schema_of
from mikas.catalog.loading.source import parse_source
from mikas.errors import CatalogError
from mikas.virtual.defects.car import WornCar, wear_of
from mikas.virtual.defects.table import DEFECTS, SIDES, SOUND, DefectSide, from_source
from mikas.virtual.model.engine import Engine
from mikas.virtual.scenarios.scenario import SCENARIOS, Condition, Start

LIMITS = {**schema_of(Condition), **schema_of(Start)}
NO_DEFECT = {"idle_target"}  # another program, not a broken part


def in_toml(value: object) -> object:
    return [Decimal(str(it)) for it in value] if isinstance(value, tuple) else Decimal(str(value))


def test_the_table_has_every_key_of_the_condition() -> None:
    assert set(DEFECTS) == {it.name for it in fields(Condition)} | {"battery", "discharged"}
    assert {key for key, defect in DEFECTS.items() if not defect.sides} == NO_DEFECT


@pytest.mark.parametrize("side", SIDES, ids=lambda side: f"{side.key}-{side.noticeable}")
def test_the_amounts_of_a_side_go_outwards_within_the_limits_of_the_model(side: DefectSide) -> None:
    amounts = [side.sound, side.least, side.noticeable, side.most]
    assert amounts in (sorted(set(amounts)), sorted(set(amounts), reverse=True))
    for amount in amounts[1:]:
        assert DEFECTS[side.key].side_of(amount) is side
        assert LIMITS[side.key](in_toml(side.value(amount))) == side.value(amount)
    assert side.at(0) == side.sound
    assert side.at(1) == pytest.approx(side.noticeable)
    assert re.search("[а-яА-Я]", side.text.ru)


def test_wear_is_the_same_for_a_seed_and_never_as_much_as_a_defect() -> None:
    assert wear_of(3) == wear_of(3) != wear_of(4)
    for key, defect in DEFECTS.items():
        if defect.wear is None:
            assert isinstance(SOUND[key], tuple | None)
            continue
        low, high = defect.wear
        assert low <= SOUND[key] <= high
        assert all(low <= wear_of(seed)[key] <= high for seed in range(20))
        for side in defect.sides:
            assert not low <= side.least <= high


def test_a_car_replaces_what_the_scenario_says_and_wears_only_what_it_leaves() -> None:
    weak = SCENARIOS["cranking-dip"]
    worn = WornCar({"leak": 8.0, "throttle_stops": (3.0, 100.0)}, wear_of(1)).applied_to(weak)
    assert (worn.condition.leak, worn.condition.throttle_stops) == (8.0, (3.0, 100.0))
    assert worn.start.battery == weak.start.battery == 0.9
    assert worn.start.discharged == wear_of(1)["discharged"]
    assert WornCar({"battery": 0.5}).applied_to(weak).start.battery == 0.5
    assert WornCar().applied_to(weak) == weak


def test_the_coolant_at_start_is_what_the_sensor_showed() -> None:
    car = WornCar({"coolant_sensor": -20.0})
    engine = Engine(car.applied_to(SCENARIOS["city"]))
    engine.advance(1.0)
    assert engine.state.coolant == pytest.approx(64, abs=0.5)
    assert engine.state.coolant_at_start == 22 - 20


def test_the_idle_speed_can_be_another_program_s() -> None:
    engine = Engine(WornCar({"idle_target": 80.0}).applied_to(SCENARIOS["warm-idle"]))
    engine.advance(30.0)
    assert engine.state.rpm == pytest.approx(930, abs=25)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("[leek]\n", "unknown key `leek`"),
        ('[leak.high]\nsound = "no"\n', "must be a number"),
        ("[throttle_stops.low]\ninterval = [1, 2]\n", "must be .number,"),
    ],
)
def test_a_wrong_table_names_its_place(text: str, problem: str) -> None:
    with pytest.raises(CatalogError, match=problem):
        from_source(parse_source("defects.toml", text.encode()))


@pytest.mark.parametrize("folder", ["docs", "docs/ru"])
def test_the_documentation_lists_every_defect_with_its_amounts(folder: str) -> None:
    page = Path(__file__).parents[2] / folder / "reference" / "simulator.md"
    text = page.read_text(encoding="utf-8")
    for side in SIDES:
        shown = side.text.ru if folder.endswith("ru") else side.text.en
        amounts = f"| `{side.least:g}` | `{side.noticeable:g}` | `{side.most:g}` |"
        row = rf"\| `{side.key}` \| {re.escape(shown)}: [^|]+ {re.escape(amounts)}"
        assert re.search(row, text), f"no row of {side.key}"
