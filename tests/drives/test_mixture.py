"""The mixture that the unit aims at against a meter's: exact cells, and what does not count."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from drive_rig import Road, Session, Unit, recorded
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.drives.mixture import (
    LEANEST,
    LOAD_EDGES,
    RPM_EDGES,
    MixtureVerdict,
    compared_mixture,
)

NAN = float("nan")


def meter(begin, end, lambda_, step=0.1):
    """A value each tenth of a second."""
    count = round((end - begin) / step)
    return [Road(begin + at * step, 0.0, lambda_=lambda_) for at in range(count)]


def steady(begin, end, rpm=1200, throttle=10, aimed=1.0):
    count = round((end - begin) * 4)
    return [Unit(begin + at / 4, rpm, aimed=aimed, throttle=throttle) for at in range(count)]


def test_a_cell_has_the_figures_of_its_steady_values(tmp_path):
    session = Session(steady(0, 20, aimed=0.75), meter(5, 15, 0.81))
    found = compared_mixture(recorded(tmp_path / "a.pcapng", session), 0)
    (cell,) = found.cells
    assert (cell.rpm, cell.load, found.load) == ((1100.0, 1600.0), (0.0, 20.0), "THR")
    assert (cell.count, found.unsteady, found.lean) == (100, 0, 0)
    assert (cell.aimed, cell.measured) == (0.75, 0.81)
    assert (cell.difference, cell.low, cell.high) == pytest.approx((8.0, 8.0, 8.0))
    assert cell.verdict is MixtureVerdict.LEANER


@pytest.mark.parametrize(
    ("measured", "verdict"),
    [(0.95, "richer"), (0.98, "agrees"), (1.02, "agrees"), (1.05, "leaner")],
)
def test_the_verdict_is_by_the_difference_in_per_cent(tmp_path, measured, verdict):
    session = Session(steady(0, 20), meter(5, 15, measured))
    (cell,) = compared_mixture(recorded(tmp_path / "a.pcapng", session), 0).cells
    assert cell.verdict == verdict


def test_few_values_and_a_scatter_are_no_verdict(tmp_path):
    few = Session(steady(0, 20), meter(5, 7.9, 1.2))
    found = compared_mixture(recorded(tmp_path / "a.pcapng", few), 0)
    assert [cell.verdict for cell in found.cells] == ["too-few"]
    assert found.judged == ()
    both = [each for at in range(5, 15) for each in meter(at, at + 1, 0.9 if at % 2 else 1.1)]
    found = compared_mixture(recorded(tmp_path / "b.pcapng", Session(steady(0, 20), both)), 0)
    assert [cell.verdict for cell in found.cells] == ["scatters"]


def test_values_of_a_changing_engine_and_of_cut_fuel_do_not_count(tmp_path):
    unit = [*steady(0, 10), *steady(10, 20, rpm=2400), *steady(20, 30, rpm=2400, throttle=30)]
    road = [*meter(5, 25, 1.0), *meter(25, 26, 1.32), *meter(26, 28, 1.0)]
    found = compared_mixture(recorded(tmp_path / "a.pcapng", Session(unit, road)), 0)
    assert [(cell.rpm[0], cell.load[0]) for cell in found.cells] == [
        (1100.0, 0.0), (2200.0, 0.0), (2200.0, 20.0),
    ]  # fmt: skip
    assert found.lean == 10
    assert found.unsteady == pytest.approx(20, abs=2)  # a second after each change
    assert sum(cell.count for cell in found.cells) + found.unsteady + found.lean == 230


def test_an_engine_that_stands_and_a_silent_unit_are_compared_with_nothing(tmp_path):
    unit = [*steady(0, 10, rpm=0), *steady(30, 31)]
    found = compared_mixture(recorded(tmp_path / "a.pcapng", Session(unit, meter(1, 29, 1.0))), 0)
    assert (found.cells, found.unsteady, found.lean) == ((), 0, 0)


def test_without_a_meter_or_what_the_unit_aims_at_there_is_none(tmp_path):
    none = recorded(tmp_path / "a.pcapng", Session(steady(0, 10)))
    assert compared_mixture(none, 0) is None
    for name, lacking in (("b", "rpm"), ("c", "aimed"), ("d", "throttle")):
        unit = steady(0, 10)
        for each in unit:
            setattr(each, lacking, None)
        recording = recorded(tmp_path / f"{name}.pcapng", Session(unit, meter(2, 8, 1.0)))
        assert compared_mixture(recording, 0) is None
    there = recorded(tmp_path / "e.pcapng", Session(steady(0, 10), meter(2, 8, 1.0)))
    assert compared_mixture(there, 1) is None


@settings(max_examples=30)
@given(
    st.lists(
        st.tuples(st.sampled_from([0, 800, 880, 1200, 5000]), st.sampled_from([0, 4, 22, 90])),
        min_size=3, max_size=12,
    ),
    st.lists(st.sampled_from([0.7, 1.0, 1.05, 1.31, 1.6]), min_size=5, max_size=40),
)  # fmt: skip
def test_the_cells_are_those_of_a_plain_loop(tmp_path_factory, regimes, heard):
    """Each regime lasts 1.75 s; a meter's value comes each 0.41 s."""
    told = [
        Unit(number * 1.75 + at / 4, rpm, aimed=0.875, throttle=throttle)
        for number, (rpm, throttle) in enumerate(regimes)
        for at in range(7)
    ]
    road = [Road(0.6 + 0.41 * at, 0.0, lambda_=value) for at, value in enumerate(heard)]
    path = tmp_path_factory.mktemp("mixture") / "a.pcapng"
    found = compared_mixture(recorded(path, Session(told, road)), 0)
    expected: dict[tuple[float, float], list[float]] = {}
    unsteady = lean = 0
    for each in road:
        before = [_latest(told, each.time - ago) for ago in (0.0, 0.5, 1.0)]
        if before[0] is None or before[0].rpm < 500 or before[1] is None:
            continue
        speeds = [NAN if it is None else it.rpm for it in before]
        loads = [NAN if it is None else it.throttle for it in before]
        if (
            not (max(speeds) - min(speeds) <= 160 and max(loads) - min(loads) <= 6)
            or np.isnan(speeds).any()
        ):
            unsteady += 1
        elif each.lambda_ > LEANEST:
            lean += 1
        else:
            rpm = next(low for low, high in pairwise(RPM_EDGES) if low <= speeds[0] < high)
            load = next(low for low, high in pairwise(LOAD_EDGES) if low <= loads[0] < high)
            expected.setdefault((rpm, load), []).append(100 * (each.lambda_ / 0.875 - 1))
    assert (found.unsteady, found.lean) == (unsteady, lean)
    assert {(cell.rpm[0], cell.load[0]): cell.count for cell in found.cells} == {
        cell: len(values) for cell, values in expected.items()
    }
    for cell in found.cells:
        values = expected[cell.rpm[0], cell.load[0]]
        assert cell.difference == pytest.approx(float(np.median(values)))
        assert cell.low == pytest.approx(float(np.percentile(values, 10)))


def _latest(told, time):
    return next((it for it in reversed(told) if it.time <= time and time - it.time <= 1.0), None)
