"""Derived channels over samples: values with their inputs, what is missing, what adds up."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.catalog import Catalog, load, shipped
from mikas.client.parameters.derived import DerivedChannels, DerivedValue
from mikas.client.parameters.readings import Reading, decode

OWN = """
[derived.SUM]
formula = "INJ + TWAT + (1 if RXX else 0)"
text = "sum"
[derived.SECONDS]
formula = "1 + 0 * FREQ"
accumulates = true
text = "running time"
[derived.REVS]
formula = "FREQ / 60"
accumulates = true
text = "turns"
[derived.REVS_A_SECOND]
formula = "REVS / SECONDS"
text = "mean speed"
[derived.TREND]
formula = "100 / (TWAT - 85) + INJ ** 1.5"
accumulates = true
text = "adds up what may be negative or missing"
"""


@pytest.fixture(scope="module")
def catalog(tmp_path_factory: pytest.TempPathFactory) -> Catalog:
    path: Path = tmp_path_factory.mktemp("derived") / "own.toml"
    path.write_text(OWN, encoding="utf-8")
    return load(path)


def readings(
    time: float, interpretation: str = "corrected", age: float = 0, **values: float
) -> dict[str, Reading]:
    made = {}
    for name, value in values.items():
        parameter = shipped().parameter(name)
        raw = b"\xff" if parameter.is_flag and value else b"\0"
        raw = raw if parameter.is_flag else parameter.encode(value)
        made[name] = decode(parameter, raw, time - age, interpretation)
    return made


def test_a_value_is_never_bare() -> None:
    channels = DerivedChannels(shipped(), ["FUEL_FLOW"])
    sample = readings(100.0, INJ=4.8, FREQ=840)
    value = channels.update(sample, 100.0)["FUEL_FLOW"]
    assert value.value == pytest.approx(1.362, abs=0.001)
    assert (value.name, value.unit, value.time) == ("FUEL_FLOW", "l/h", 100.0)
    assert value.channel is shipped().derived["FUEL_FLOW"]
    assert (value.since, value.gaps) == (None, 0)
    assert value.inputs["FREQ"] is sample["FREQ"]
    stroke = value.inputs["FUEL_STROKE"]
    assert isinstance(stroke, DerivedValue)
    assert stroke.value == pytest.approx(10)
    assert stroke.inputs == {"INJ": sample["INJ"]}
    assert str(value) == "FUEL_FLOW 1.4 l/h"


def test_channels_name_their_inputs_and_have_values_in_order() -> None:
    channels = DerivedChannels(shipped(), ["FUEL_USED", "FILLING", "FUEL_USED"])
    assert shipped().required_by(["FUEL_USED", "FILLING"]) == ("FREQ", "INJ", "JAIR")
    assert [each.name for each in channels.channels] == ["FUEL_USED", "FILLING"]
    assert list(channels.update(readings(0, INJ=4, FREQ=840, JAIR=15), 0)) == [
        "FUEL_USED",
        "FILLING",
    ]
    assert DerivedChannels(shipped(), []).update(readings(0, INJ=4), 0) == {}


def test_missing_and_undefined_have_no_value() -> None:
    channels = DerivedChannels(shipped(), ["FILLING", "DUTY"])
    assert channels.update({}, 1.0) == {}
    assert list(channels.update(readings(1.0, INJ=4, FREQ=840), 1.0)) == ["DUTY"]
    assert list(channels.update(readings(1.0, JAIR=15, FREQ=0, INJ=4), 1.0)) == ["DUTY"]


def test_readings_of_a_sample_that_lasts_are_all_fresh() -> None:
    """One request a parameter on a slow unit: its own readings are seconds apart, all fresh."""
    channels = DerivedChannels(shipped(), ["DUTY"])
    sample = readings(1.0, INJ=4) | readings(7.0, FREQ=840)
    assert list(channels.update(sample, 1.0)) == ["DUTY"]


def test_formulas_mean_the_corrected_interpretation(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text('[derived.D]\nformula = "UACC"\ntext = ""\n', encoding="utf-8")
    sample = readings(0, "literal", UACC=14.2)
    assert sample["UACC"].value == -11.4
    assert DerivedChannels(load(path), ["D"]).update(sample, 0)["D"].value == 14.2


def test_a_flag_is_0_or_1(catalog: Catalog) -> None:
    channels = DerivedChannels(catalog, ["SUM"])
    assert channels.update(readings(0, INJ=4, TWAT=80, RXX=1), 0)["SUM"].value == 85
    assert channels.update(readings(0, INJ=4, TWAT=80, RXX=0), 0)["SUM"].value == 84


def totals(channels: DerivedChannels) -> dict[str, tuple[float, float | None, int]]:
    return {name: (each.total, each.since, each.gaps) for name, each in channels.totals.items()}


def revs(channels: DerivedChannels, time: float, freq: float | None = 600) -> float | None:
    """Turns so far: 600 rpm are 10 a second. No `freq`: nothing came."""
    sample = {} if freq is None else readings(time, FREQ=freq)
    made = channels.update(sample, time).get("REVS")
    return made.value if made else None


def test_a_total_is_added_up_along_a_straight_line(catalog: Catalog) -> None:
    channels = DerivedChannels(catalog, ["REVS", "REVS_A_SECOND"])
    assert totals(channels) == {"REVS": (0, None, 0), "SECONDS": (0, None, 0)}
    assert revs(channels, 100.0) == 0
    assert revs(channels, 100.5) == 5
    assert revs(channels, 101.5, 1200) == 20  # along a straight line
    made = channels.update(readings(103.5, FREQ=0), 103.5)
    assert made["REVS"].value == 40
    assert (made["REVS"].since, made["REVS"].gaps) == (100.0, 0)
    assert made["REVS_A_SECOND"].value == pytest.approx(40 / 3.5)
    assert totals(channels)["REVS"] == (40, 100.0, 0)


def test_a_gap_adds_nothing_and_is_counted(catalog: Catalog) -> None:
    channels = DerivedChannels(catalog, ["REVS"])
    assert revs(channels, 100.0) == 0
    assert revs(channels, 100.5) == 5
    assert revs(channels, 103.0) == 5  # too long
    assert revs(channels, 104.0) == 15
    assert totals(channels)["REVS"] == (15, 100.0, 1)
    assert revs(channels, 50.0) == 15  # the clock went back
    assert revs(channels, 50.0) == 15  # and stood
    assert revs(channels, 50.5) == 20
    assert totals(channels)["REVS"] == (20, 100.0, 2)


def test_an_empty_response_is_no_gap_if_the_next_is_in_time(
    catalog: Catalog,
) -> None:
    """It was spoilt, and asked for again."""
    channels, columns = DerivedChannels(catalog, ["REVS"]), DerivedChannels(catalog, ["REVS"])
    came = {99.0: None, 100.0: 600, 100.9: None, 101.0: None, 102.0: 600, 102.1: None, 104.5: 600}
    for time, freq in came.items():
        revs(channels, time, freq)
    assert totals(channels)["REVS"] == (20, 100.0, 1)
    freqs = np.array([math.nan if freq is None else freq for freq in came.values()])
    columns.columns(np.array(list(came)), {"FREQ": freqs})
    assert totals(columns) == totals(channels)


def wanted(catalog: Catalog, before: DerivedChannels, *names: str, asked: str) -> DerivedChannels:
    """Other channels, while the parameters `asked` are."""
    channels = DerivedChannels(catalog, names)
    channels.continue_from(before, asked.split())
    return channels


def test_totals_are_kept_while_not_requested(catalog: Catalog) -> None:
    channels = DerivedChannels(catalog, ["REVS_A_SECOND"])
    assert [revs(channels, time) for time in (100.0, 101.0)] == [None, None]  # of another's making
    channels = wanted(catalog, channels, "SUM", asked="INJ TWAT RXX")
    channels.update(readings(101.1, INJ=4, TWAT=80, RXX=1), 101.1)
    channels = wanted(catalog, channels, asked="INJ")
    channels = wanted(catalog, channels, "REVS", asked="FREQ")
    assert channels.update(readings(101.2, FREQ=600), 101.2)["REVS"].since == 100.0
    assert revs(channels, 101.7) == 15
    assert totals(channels)["REVS"] == (15, 100.0, 1)
    assert totals(channels)["SECONDS"] == (1.5, 100.0, 1)


def test_accumulation_continues_while_other_channels_need_the_inputs(
    catalog: Catalog,
) -> None:
    channels = DerivedChannels(catalog, ["REVS"])
    revs(channels, 100.0)
    channels = wanted(catalog, channels, asked="FREQ TWAT")
    assert channels.channels == ()
    assert channels.update(readings(101.0, FREQ=600, TWAT=80), 101.0) == {}
    channels = wanted(catalog, channels, "REVS", asked="FREQ")
    assert revs(channels, 102.0) == 20
    assert totals(channels) == {"REVS": (20, 100.0, 0)}


def test_slow_channels_accumulate(catalog: Catalog) -> None:
    channels = DerivedChannels(catalog, ["REVS"])
    for time in range(0, 50, 5):
        assert revs(channels, time) == max(0, time - 10) * 10  # two steps to know that it is usual
    assert channels.totals["REVS"].gaps == 2
    assert revs(channels, 57) == 470  # one value was lost
    assert revs(channels, 62) == 520
    assert revs(channels, 92) == 520
    assert revs(channels, 120) == 520  # twice long is not usual yet
    assert channels.totals["REVS"].gaps == 4


def test_a_slower_request_is_no_gap(catalog: Catalog) -> None:
    channels = DerivedChannels(catalog, ["REVS"])
    for tenth in range(21):
        sample = readings(tenth / 10, TWAT=80)
        if tenth % 10 == 0:
            sample |= readings(tenth / 10, FREQ=600)
        channels.update(sample, tenth / 10)
    assert totals(channels)["REVS"] == (20, 0, 0)


def test_columns_of_unrecorded_inputs_are_missing() -> None:
    channels = DerivedChannels(shipped(), ["DUTY", "FUEL_STROKE", "FUEL_USED"])
    columns = channels.columns(np.array([0.0, 1.0]), {"INJ": np.array([4.0, 4.0])})
    assert list(columns) == ["DUTY", "FUEL_STROKE", "FUEL_USED"]
    assert columns["FUEL_STROKE"].tolist() == [8, 8]
    assert np.isnan(columns["DUTY"]).all()
    assert np.isnan(columns["FUEL_USED"]).all()


def test_columns_without_rows_are_empty() -> None:
    channels = DerivedChannels(shipped(), ["FUEL_USED", "FILLING"])
    empty = np.empty(0)
    for inputs in ({}, {"INJ": empty, "FREQ": empty, "JAIR": empty}):
        columns = channels.columns(empty, inputs)
        assert {name: len(each) for name, each in columns.items()} == {
            "FUEL_USED": 0,
            "FILLING": 0,
        }
    assert totals(channels)["FUEL_USED"] == (0, None, 0)


# Steps of time: usual, none, back, and about the longest between neighbours.
steps = st.sampled_from([0.028, 0.1, 0.5, 0.9, 2.0, 2.0000001, 5.0, 0.0, -1.0]) | st.floats(-3, 3)
values = st.fixed_dictionaries(
    {},
    optional={
        "INJ": st.sampled_from([0.0, 0.8, 4.8, 12.0]),
        "FREQ": st.sampled_from([0, 40, 840, 5200]),
        "TWAT": st.sampled_from([-40, 84, 85, 86]),
        "RXX": st.booleans(),
        "JAIR": st.sampled_from([0.0, 15.0, 385.0]),
    },
)
samples = st.lists(st.tuples(steps, values), max_size=12)


@given(samples, st.lists(st.integers(0, 12), max_size=4), st.lists(st.booleans(), min_size=6))
def test_columns_are_the_samples_one_by_one(
    catalog: Catalog,
    drawn: Sequence[tuple[float, dict[str, float]]],
    cuts: list[int],
    as_columns: list[bool],
) -> None:
    """However a recording is cut, and whichever form each part goes through."""
    names = list(catalog.derived)
    times = np.cumsum([1000.0, *(step for step, _ in drawn)])[1:]
    taken = [readings(time, **each) for time, (_, each) in zip(times, drawn, strict=True)]

    live = DerivedChannels(catalog, names)
    one_by_one = [live.update(each, time) for each, time in zip(taken, times, strict=True)]

    mixed = DerivedChannels(catalog, names)
    edges = [0, *sorted(min(cut, len(drawn)) for cut in cuts), len(drawn)]
    for first, last, whole in zip(edges, edges[1:], as_columns, strict=False):
        if not whole:
            for row in range(first, last):
                assert mixed.update(taken[row], times[row]) == one_by_one[row]
            continue
        inputs = {
            name: np.array(
                [float(row[name].value) if name in row else math.nan
                 for row in taken[first:last]], dtype=float,
            )
            for name in ("INJ", "FREQ", "TWAT", "RXX", "JAIR")
        }  # fmt: skip
        columns = mixed.columns(times[first:last], inputs)
        assert list(columns) == names
        for name, column in columns.items():
            expected = [
                row[name].value if name in row else math.nan for row in one_by_one[first:last]
            ]
            np.testing.assert_array_equal(column, np.array(expected))
    assert totals(mixed) == totals(live)


@given(st.lists(st.tuples(st.floats(0, 1.9), st.floats(0, 10_000)), min_size=2, max_size=20))
def test_a_total_lies_between_the_least_and_the_most(
    catalog: Catalog, drawn: list[tuple[float, float]]
) -> None:
    times = np.cumsum([step for step, _ in drawn])
    speeds = np.array([speed for _, speed in drawn])
    total = DerivedChannels(catalog, ["REVS"]).columns(times, {"FREQ": speeds})["REVS"]
    assert total[0] == 0
    assert (np.diff(total) >= 0).all()
    seconds = times[-1] - times[0]
    assert speeds.min() / 60 * seconds * (1 - 1e-9) <= total[-1] + 1e-9
    assert total[-1] <= speeds.max() / 60 * seconds * (1 + 1e-9) + 1e-9


def test_what_grows_beyond_all_bounds_has_no_value(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(
        '[derived.D]\nformula = "9e307 * FREQ"\naccumulates = true\ntext = ""\n', encoding="utf-8"
    )
    catalog = load(path)
    live, column = DerivedChannels(catalog, ["D"]), DerivedChannels(catalog, ["D"])
    times, speeds = np.arange(4.0), np.full(4, 1.0)
    totals = column.columns(times, {"FREQ": speeds})["D"]
    np.testing.assert_array_equal(totals, [0, 9e307, math.nan, math.nan])
    assert math.isnan(column.totals["D"].total)
    assert live.update(readings(0, FREQ=0), 0)["D"].value == 0
    assert live.update(readings(1, FREQ=40), 1) == {}
    assert live.totals["D"].total == 0
