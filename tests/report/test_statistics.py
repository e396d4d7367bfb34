"""The spread of a channel against what numpy says of all its values at once."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.report.measurements.statistics import (
    COLUMNS,
    BlockTimes,
    Envelope,
    ValueCounts,
    is_inside,
)

NAN = float("nan")

columns = st.lists(
    st.lists(st.integers(0, 20).map(lambda n: n / 4) | st.just(NAN), max_size=30), max_size=6
)


@given(columns)
def test_statistics_by_pieces_are_those_of_all_values_at_once(stretches) -> None:
    spread = ValueCounts(4)
    for stretch in stretches:
        spread.add(np.array(stretch, np.float64))
    values = np.array([v for stretch in stretches for v in stretch if v == v])
    stats = spread.stats((1.0, 3.0))
    if not values.size:
        assert stats is None
        return
    assert stats is not None
    assert stats.count == values.size
    assert stats.mean == pytest.approx(values.mean())
    for share, it in ((0.05, stats.low), (0.5, stats.median), (0.95, stats.high)):
        assert it == np.quantile(values, share, method="inverted_cdf")
    assert (stats.least, stats.most) == (values.min(), values.max())
    assert stats.inside == pytest.approx(((values >= 1) & (values <= 3)).mean())


def test_only_a_parameter_with_a_reference_has_a_share() -> None:
    spread = ValueCounts(0)
    spread.add(np.array([1.0]))
    stats = spread.stats()
    assert stats is not None
    assert stats.inside is None


def test_memory_does_not_grow_with_computed_values() -> None:
    spread = ValueCounts(2)
    random = np.random.default_rng(1)
    for _ in range(20):
        spread.add(random.random(10_000))
    assert spread.values.size <= 101


def test_the_edges_belong_to_the_band() -> None:
    assert is_inside(13.5, (13.5, 14.5))
    assert is_inside(0.1 + 0.2, (0.0, 0.3))
    assert not is_inside(13.4, (13.5, 14.5))
    assert not is_inside(1, (0, 0))


@given(st.integers(1, 40), st.floats(0.01, 50), st.integers(0, 1000))
def test_a_curve_keeps_every_spike(pieces, step, seed) -> None:
    random = np.random.default_rng(seed)
    values = random.random(pieces * 25)
    times = 1e9 + np.arange(values.size) * step
    curve = Envelope()
    for piece in range(pieces):
        part = slice(piece * 25, piece * 25 + 25)
        curve.add(BlockTimes(times[part], 1e9), values[part])
    assert curve.least.size == curve.most.size == COLUMNS
    assert np.nanmin(curve.least) == values.min()
    assert np.nanmax(curve.most) == values.max()
    at = curve.middles[np.nanargmax(curve.most)]
    assert abs(at - (times[values.argmax()] - 1e9)) <= curve.width
    assert COLUMNS * curve.width >= times[-1] - 1e9
    if curve.width > 0.02:  # never wider than needed
        assert COLUMNS * curve.width / 2 <= times[-1] - 1e9


def test_a_curve_without_values_stays_empty() -> None:
    curve = Envelope()
    curve.add(BlockTimes(np.array([0.0, 1.0, -3.0]), 0.0), np.array([NAN, NAN, 5.0]))
    assert np.isnan(curve.most).all()
