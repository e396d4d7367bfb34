"""Features and regimes: what is seen in samples, and that none of them fails on anything."""

from __future__ import annotations

from math import isnan, nan

from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.causes.features import BY_NAME, View, context_of, features_of
from mikas.causes.features.words import feature_texts
from mikas.causes.knowledge import SYSTEMS
from mikas.causes.ranking import rank
from mikas.causes.regimes import Regime, drive_of
from mikas.causes.samples import Samples, quantile, samples_of
from mikas.causes.weights import shipped

NAMES = (
    "TWAT", "FREQ", "FREQX", "UOZ", "UACC", "INJ", "JAIR", "JQT", "DET", "RXX", "VALF", "THR",
    "RCOK", "UOZOC", "SSM", "FSM", "UGB", "TAIR",
)  # fmt: skip
VALUES = st.one_of(
    st.just(nan), st.floats(-50, 8000, width=32), st.sampled_from([0.0, 1.0, 85.0, 850.0])
)


@st.composite
def samples(draw: st.DrawFn) -> Samples:
    """Draw samples of any channels with any values and pauses."""
    names = draw(st.lists(st.sampled_from(NAMES), max_size=12, unique=True))
    steps = draw(st.lists(st.sampled_from([0.2, 0.5, 1.0, 10.0, 4000.0]), max_size=60))
    times = [sum(steps[:count]) for count in range(len(steps))]
    columns = {n: draw(st.lists(VALUES, min_size=len(times), max_size=len(times))) for n in names}
    return samples_of(times, columns)


@given(samples())
@settings(max_examples=60, deadline=None)
def test_any_samples_are_ranked_without_an_error(given_samples: Samples) -> None:
    ranking = rank([given_samples, given_samples])
    assert all(0 <= cause.probability <= 1.0001 for cause in ranking.causes)
    drive = drive_of(given_samples)
    if drive is not None:
        context_of(View(drive))
        assert not any(isnan(seen.value) for seen in features_of(drive).values())
        rows = [row for regime in Regime for row in drive.rows[regime]]
        assert len(rows) == len(set(rows)) <= len(given_samples)


def test_every_feature_has_words_and_a_system() -> None:
    texts = feature_texts()
    assert list(texts) == list(BY_NAME)
    assert {words.system for words in texts.values()} <= set(SYSTEMS)


def test_the_tables_hold_features_that_exist() -> None:
    weights = shipped()
    assert set(weights.scales) <= set(BY_NAME)
    assert all(scale.scale > 0 and scale.spread > 0 for scale in weights.scales.values())


def test_a_value_is_held_over_a_short_pause_only() -> None:
    times = [0.0, 1.0, 2.0, 6.0]
    kept = samples_of(times, {"UACC": [12.0, nan, nan, nan], "TWAT": [80.0, nan, nan, nan]})
    voltage, coolant = kept.columns["UACC"], kept.columns["TWAT"]
    assert voltage[:3] == [12.0] * 3
    assert isnan(voltage[3])
    assert coolant == [80.0] * 4


def test_an_idle_counts_though_the_throttle_does_not_close() -> None:
    times = [number * 0.2 for number in range(200)]
    columns = {"FREQX": [1300.0] * 200, "THR": [5.0] * 200, "TWAT": [85.0] * 200}
    drive = drive_of(samples_of(times, columns))
    assert drive is not None
    assert len(drive.rows[Regime.WARM_IDLE]) > 150


def test_quantiles_of_few_values() -> None:
    assert isnan(quantile([], 0.5))
    assert quantile([3.0], 0.9) == 3.0
    assert quantile([1.0, 2.0], 0.5) == 1.5
