"""Units without injection are found out from values, and only where these are certain."""

from __future__ import annotations

import pytest

from mikas.catalog import shipped
from mikas.catalog.ignition_only import (
    DEAD,
    RUNNING,
    WITNESSES,
    InjectionWatch,
    absent_channels,
    is_absent,
)

RUN = {"FREQ": 900.0, "INJ": 0.0, "JAIR": 0.0}


def watched(*rows: dict[str, float]) -> bool:
    watch = InjectionWatch()
    for row in rows:
        watch.add_row(row)
    return watch.ignition_only


def test_the_dead_channels_are_parameters_and_the_witnesses_among_them() -> None:
    assert {shipped().parameter(name).name for name in DEAD} == DEAD
    assert DEAD.issuperset(WITNESSES)


def test_zeros_of_a_running_engine_show_it_after_twenty_readings_of_each() -> None:
    assert watched(*[RUN] * 20)
    assert not watched(*[RUN] * 19)
    assert not watched(*[{"FREQ": 900.0, "INJ": 0.0}] * 40)
    assert not watched(*[RUN] * 19, *[{"JAIR": 0.0}] * 9)


def test_channels_may_come_in_rows_of_their_own() -> None:
    assert watched({"FREQ": 900.0}, *[{"INJ": 0.0}, {"JAIR": 0.0}] * 20)


@pytest.mark.parametrize("name", WITNESSES)
def test_one_reading_of_injection_or_air_is_enough_against_it(name: str) -> None:
    assert not watched(RUN | {name: 0.1}, *[RUN] * 40)
    assert not watched(*[RUN] * 40, RUN | {name: 0.1})


def test_an_engine_that_stands_is_cranked_or_has_no_speed_says_nothing() -> None:
    assert not watched(*[RUN | {"FREQ": 0.0}] * 40)
    assert not watched(*[RUN | {"FREQ": RUNNING - 1}] * 40)
    assert not watched(*[{"INJ": 0.0, "JAIR": 0.0}] * 40)
    assert watched(*[RUN | {"FREQ": 0.0, "INJ": 3.0}] * 40, *[RUN | {"FREQ": RUNNING}] * 20)


def test_readings_are_counted_together_as_one_by_one() -> None:
    watch = InjectionWatch()
    watch.count("INJ", 30, is_alive=False)
    assert not watch.ignition_only
    watch.count("JAIR", 20, is_alive=False)
    assert watch.ignition_only
    watch.count("JAIR", 1, is_alive=True)
    assert not watch.ignition_only


def test_what_is_computed_from_a_dead_channel_is_absent_too() -> None:
    catalog = shipped()
    absent = absent_channels(catalog)
    assert set(absent) > DEAD
    assert "FUEL_FLOW" in absent
    assert not {"FREQ", "TWAT", "UACC"} & set(absent)
    assert all(is_absent(name, catalog) == (name in absent) for name in catalog.channels)
