"""Conditions that name an instrument's channel: what it has no value for never holds."""

from __future__ import annotations

import pytest

from mikas.catalog import Catalog, shipped
from mikas.conditions import ActionRule, ConditionWatch, read_actions
from mikas.errors import CatalogError
from mikas.instruments import definition_named
from mikas.instruments.reading import InstrumentReading
from mikas.sampling.events import Sampled

LEAN = '[action.lean]\nwhen = "LAMBDA > 1.1 and FREQ > 2000"\nfor = 1\nmark = "{LAMBDA}"\n'


def rule(text: str, catalog: Catalog | None = None) -> ActionRule:
    (found,) = read_actions("actions.toml", text, catalog or shipped()).rules
    return found


def watch(text: str, catalog: Catalog | None = None) -> ConditionWatch:
    return ConditionWatch([rule(text, catalog)], catalog or shipped())


def acted(it: ConditionWatch, *moments: tuple[float, dict[str, float]]) -> list[float]:
    return [fired.time for time, values in moments for fired in it.add(time, values)]


def test_a_condition_needs_the_units_part_and_the_instruments() -> None:
    it = watch(LEAN)
    assert (it.requires, it.beside) == (("FREQ",), ("LAMBDA",))
    steady = [(0.5 * at, {"FREQ": 2500.0, "LAMBDA": 1.2}) for at in range(4)]
    assert acted(it, *steady) == [1.0]
    assert acted(watch(LEAN), *((t, {**v, "LAMBDA": 1.0}) for t, v in steady)) == []
    assert acted(watch(LEAN), *((t, {**v, "FREQ": 900.0}) for t, v in steady)) == []


def test_a_value_that_is_missing_for_one_sample_begins_the_time_again() -> None:
    moments = [(0.5 * at, {"FREQ": 2500.0, "LAMBDA": 1.2}) for at in range(9)]
    del moments[2][1]["LAMBDA"]
    assert acted(watch(LEAN), *moments) == [2.5]
    moments[5][1]["LAMBDA"] = float("nan")
    assert acted(watch(LEAN), *moments) == [4.0]
    alone = '[action.a]\nwhen = "LAMBDA > 1.1"\nuntil = "LAMBDA < 1"\nsound = true\n'
    lost = [(0.0, {"LAMBDA": 1.2}), (1.0, {}), (2.0, {"LAMBDA": 1.2}), (3.0, {"LAMBDA": 0.9})]
    assert acted(watch(alone), *lost, (4.0, {"LAMBDA": 1.2})) == [0.0, 4.0]


def test_a_rule_of_instruments_alone_holds_at_a_slow_units_samples() -> None:
    slow = [(5.0 * at, {"LAMBDA": 1.2}) for at in range(6)]
    it = watch('[action.a]\nwhen = "LAMBDA > 1.1"\nfor = 10\nsound = true\n')
    assert acted(it, *slow) == [15.0]  # the pace is known from the second value on


def test_it_follows_the_samples_of_a_session() -> None:
    it = watch('[action.a]\nwhen = "AFR > 16"\nsound = true\n')
    channel = shipped().instruments["AFR"]

    def sample(time: float, value: float) -> Sampled:
        return Sampled(time, {}, {}, {}, {"AFR": InstrumentReading(channel, value, time)})

    assert it.follow(sample(1.0, 15.0)) == ()
    (fired,) = it.follow(sample(2.0, 16.5))
    assert fired.values == {"AFR": 16.5}


def test_the_name_of_an_instrument_means_it_and_not_the_units_own() -> None:
    assert rule(LEAN).condition.inputs == ("LAMBDA", "FREQ")
    other = '[action.a]\nwhen = "Lambda > 1.1"\nsound = true\n'
    assert rule(other).condition.inputs == ("VALF",)  # no meter is known here
    beside = shipped().with_beside(definition_named("aem").channels)
    assert rule(other, beside).condition.inputs == ("LAMBDA",)
    left = shipped().with_beside(definition_named("aem").labelled("left").channels)
    text = '[action.a]\nwhen = "LAMBDA_LEFT - valf > 0.1"\nsound = true\n'
    assert rule(text, left).condition.inputs == ("LAMBDA_LEFT", "VALF")


def test_a_channel_that_nothing_gives_is_named_with_the_nearest() -> None:
    with pytest.raises(CatalogError, match=r"actions.toml:2.*LAMBDA_LEFT.*the nearest is LAMBDA"):
        rule('[action.a]\nwhen = "LAMBDA_LEFT > 1"\nsound = true\n')
    with pytest.raises(CatalogError, match=r"GPS_SPED.*the nearest is GPS_SPEED"):
        rule('[action.a]\nwhen = "GPS_SPED > 1"\nsound = true\n')
