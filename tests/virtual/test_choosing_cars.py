"""Cars by name: sound, with defects, blind; what is refused, and what a blind car gives away."""

from __future__ import annotations

import pytest

import mikas
from mikas.errors import UsageError
from mikas.virtual.build import build_bus
from mikas.virtual.defects.car import wear_of
from mikas.virtual.defects.choosing import KEYS, answer, car_of
from mikas.virtual.defects.table import DEFECTS
from mikas.virtual.scenarios.scenario import SCENARIOS


def condition_of(**settings: str) -> object:
    return build_bus(settings).ecu.responder.car.engine.scenario.condition


def test_defects_are_chosen_by_key_with_an_amount_or_a_noticeable_one() -> None:
    car = car_of("leak:8,coolant_sensor:-40,battery throttle_stops:50", seed=3)
    assert car.defects == {
        "leak": 8.0,
        "coolant_sensor": -40.0,
        "battery": DEFECTS["battery"].sides[0].noticeable,
        "throttle_stops": (0.0, 50.0),
    }
    assert car.wear == wear_of(3)


def test_a_healthy_car_is_worn_by_its_seed_and_without_a_car_nothing_is() -> None:
    assert car_of("healthy", 4).defects == {}
    assert condition_of() == SCENARIOS["warm-idle"].condition
    assert condition_of(car="healthy") != condition_of(car="healthy", seed="1")
    assert condition_of(car="leak:8").leak == 8
    assert condition_of(car="leak:8", scenario="city").air_meter == wear_of(0)["air_meter"]


def test_every_key_can_be_chosen() -> None:
    for key in KEYS:
        (chosen,) = answer(key)
        assert (chosen.key, chosen.amount) == (key, DEFECTS[key].sides[0].noticeable)
        assert condition_of(car=key) is not None


def test_an_answer_names_the_defect_and_its_amount() -> None:
    (leak,) = answer("leak:7.5")
    assert leak.text.en == "Air leak past the air meter: 7.5\N{NO-BREAK SPACE}kg/h"
    assert leak.text.ru == "Подсос воздуха мимо ДМРВ: 7,5\N{NO-BREAK SPACE}кг/ч"
    (radiator,) = answer("radiator:0.25")
    assert radiator.text.en.endswith("25\N{NO-BREAK SPACE}% of its cooling is left")
    (late,) = answer("idle_advance:-3")
    assert late.text.en == "Late spark at idle: \N{MINUS SIGN}3°"


def test_a_blind_number_is_always_the_same_car_and_many_are_all_kinds_of_cars() -> None:
    assert car_of("blind:4711", seed=1) == car_of("blind:04711", seed=2) != car_of("blind:4712")
    cars = [answer(f"blind:{number}") for number in range(600)]
    assert {each.key for found in cars for each in found} == set(KEYS)
    assert 30 < sum(not found for found in cars) < 110
    for found in cars:
        for each in found:
            assert each.side.contains(each.amount)
            assert abs(each.amount - each.side.sound) >= abs(each.side.at(0.69) - each.side.sound)
            assert abs(each.amount - each.side.sound) <= abs(each.side.most - each.side.sound)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "car= is empty"),
        ("leek:8", "no defect “leek”. Did you mean leak"),
        ("leak:", "a number 2 … 20 kg/h"),
        ("leak:x", "a number 2 … 20 kg/h"),
        ("leak:0", "a number 2 … 20 kg/h"),
        ("leak:-1", "a number 2 … 20 kg/h"),
        ("leak:31", "a number 2 … 20 kg/h"),
        ("leak:nan", "a number 2 … 20 kg/h"),
        ("alternator:40", "0.75 … 0 as a share"),
        ("throttle_stops:15", r"1.2 … 10 % or 85 … 25 %"),
        ("leak,leak:3", "leak is named twice"),
        ("blind", "has a number"),
        ("blind:x", "has a number"),
        ("blind:-1", "has a number"),
        ("blind:3,leak", "stands alone"),
        ("healthy,leak", "stands alone"),
        ("idle_target:50", "no defect “idle_target”"),
    ],
)
def test_what_is_no_car_is_refused_with_the_expected_form(text: str, problem: str) -> None:
    with pytest.raises(UsageError, match=problem):
        car_of(text)
    with pytest.raises(UsageError, match=problem):
        build_bus({"car": text})


def test_a_blind_car_s_connection_and_recording_name_its_number_only(tmp_path) -> None:
    key = answer("blind:4711")[0].key
    file = tmp_path / "blind.pcapng"
    url = "sim:?clock=simulated&car=blind:4711"
    from mikas.recording.capture.writer import CaptureWriter

    with CaptureWriter(file, url=url) as sink, mikas.connect(url, sink=sink) as ecu:
        ecu.read("TWAT", "FREQ")
        assert key not in repr(ecu.tester.link.url)
    data = file.read_bytes()
    assert b"blind:4711" in data
    assert key.encode() not in data
