"""The report on virtual cars with seeded defects finds exactly those, and nothing in sound cars."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime

import pytest
from bench.virtual_fleet import Drive, record

from fleet_rig import BEGAN, DAY, MINUTE, add_here, make
from mikas.catalog import shipped
from mikas.fleet.cars import KnownBy
from mikas.fleet.query.database import opened
from mikas.fleet.report.figures import figures
from mikas.fleet.report.findings import FleetFindings, find
from mikas.report.findings import Outcome

NOW = datetime(2026, 6, 1)
LONG = Drive(0.0, seconds=760.0, rate=0.5)
SHORT = Drive(0.0, seconds=40.0, rate=2.0, warm=True)
DRIVES = 8
FLEET = {
    "SOUND1": (LONG, {}), "SOUND2": (LONG, {}), "SOUND3": (LONG, {}), "SOUND4": (LONG, {}),
    "SOUND5": (LONG, {}), "THERMOSTAT": (LONG, {"thermostat": 0.6}),
    "ALTERNATOR": (SHORT, {"alternator": 0.5}), "METER": (SHORT, {"air_meter": 0.72}),
    "VALVE": (SHORT, {}), "FAULT": (SHORT, {}),
}  # fmt: skip


def findings(dataset, now: datetime = NOW) -> FleetFindings:
    with opened(str(dataset)) as database:
        return find(figures(database, shipped(), now), shipped())


@pytest.fixture(scope="module")
def fleet(tmp_path_factory) -> FleetFindings:
    home = tmp_path_factory.mktemp("virtual")
    for car, (drive, condition) in FLEET.items():
        for number in range(DRIVES):
            worn = {"idle_passage": 1 - 0.07 * number} if car == "VALVE" else {}
            faults = (17,) if car == "FAULT" and number in (2, 3, 7) else ()
            made = replace(
                drive, began=BEGAN + number * DAY, plate=car, condition={**condition, **worn},
                faults=faults,
            )  # fmt: skip
            (folder := home / "in" / car).mkdir(parents=True, exist_ok=True)
            record(folder / f"{number}.pcapng", made)
    add_here(home / "in", to=home / "set")
    return findings(home / "set")


def test_each_defect_is_found_and_nothing_else(fleet) -> None:
    found = {
        car.figures.car: {
            "stored": [it.fault.code for it in car.faults if it.is_stored],
            "off": [measure.key for measure in car.out_of_range],
            "out": [measure.key for measure in car.stands_out],
            "changes": [measure.key for measure in car.changes],
        }
        for car in fleet.cars
        if car.found
    }
    nothing: dict[str, list] = {"stored": [], "off": [], "out": [], "changes": []}
    assert found == {
        "THERMOSTAT": nothing | {"out": ["coolant"]},
        "ALTERNATOR": nothing | {"off": ["idle_voltage"], "out": ["idle_voltage"]},
        "METER": nothing | {"off": ["idle_air"], "out": ["idle_air"]},
        "VALVE": nothing | {"out": ["idle_valve"], "changes": ["idle_valve"]},
        "FAULT": nothing | {"stored": [17]},
    }
    assert fleet.outcome is Outcome.ATTENTION


def test_what_was_measured_is_what_the_cars_did(fleet) -> None:
    cars = {car.figures.car: car for car in fleet.cars}
    (out,) = cars["THERMOSTAT"].stands_out.values()
    assert out.value < 60 < 80 < out.low <= out.high < 90
    assert out.count == 5
    (change,) = cars["VALVE"].changes.values()
    assert change.first < 45 < 60 < change.last
    assert change.count == DRIVES
    (fault,) = cars["FAULT"].faults
    assert fault.marks == (False, False, True, True, False, False, False, True)
    assert fault.first.date().isoformat() == "2026-03-04"
    assert all(car.figures.known_by == {KnownBy.PLATE} for car in fleet.cars)


def test_drives_without_a_date_or_from_the_future_and_unknown_cars_are_left_out(tmp_path) -> None:
    make(tmp_path / "in" / "1.pcapng")
    make(tmp_path / "in" / "2.pcapng", began=50.0)
    make(tmp_path / "in" / "3.pcapng", began=BEGAN + 400 * DAY)
    make(tmp_path / "in" / "4.pcapng", plate="", car="", passport=("",) * 8)
    add_here(tmp_path / "in", to=tmp_path / "set")
    found = findings(tmp_path / "set")
    (car,) = found.cars
    assert (car.figures.drives, car.figures.undated, car.figures.ahead) == (3, 1, 1)
    assert found.figures.unknown == 1
    assert len(car.figures.readings) == 1
    assert found.outcome is Outcome.OPEN


def test_a_value_of_a_faulty_sensor_is_not_used(tmp_path) -> None:
    for number in range(3):
        made = replace(
            MINUTE, began=BEGAN + number * DAY, warm=True, faults=(21,) if number == 1 else ()
        )
        (tmp_path / "in").mkdir(exist_ok=True)
        record(tmp_path / "in" / f"{number}.pcapng", replace(made, plate="X", car=""))
    add_here(tmp_path / "in", to=tmp_path / "set")
    (car,) = findings(tmp_path / "set").cars
    assert len(car.figures.series["idle_voltage"]) == 3
    assert 21 in {it.fault.code for it in car.faults}
    sensors = shipped().fault(21).sensor
    assert sensors
    assert "coolant" not in car.figures.series or len(car.figures.series["coolant"]) < 3


def test_an_empty_dataset_has_no_findings(tmp_path) -> None:
    (tmp_path / "in").mkdir()
    add_here(tmp_path / "in", to=tmp_path / "set")
    found = findings(tmp_path / "set")
    assert found.cars == ()
    assert found.outcome is Outcome.OPEN
