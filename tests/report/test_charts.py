"""The parts of a chart do not grow with the recording."""

from __future__ import annotations

import numpy as np
import pytest

from mikas.catalog import shipped
from mikas.report.charts import chart
from mikas.report.statistics import Envelope


def drawn(seconds, values, pauses=()):
    curve = Envelope(0.0)
    curve.add(np.linspace(0.0, seconds, len(values)), np.array(values, float))
    return chart(shipped().channel("TWAT"), curve, seconds, "en", pauses=pauses)


@pytest.mark.parametrize("seconds", [0.5, 59, 7200, 4 * 86400, 3e7, 3.2e8, 2.5e11])
def test_a_chart_has_at_most_six_times_on_its_axis_whatever_its_length(seconds):
    assert 1 <= drawn(seconds, [20, 90]).count('class="time"') <= 6


def test_a_chart_of_days_counts_days():
    assert ">2000 d<" in drawn(3.2e8, [20, 90])


@pytest.mark.parametrize("values", [[0, 1e308], [-1e308, 1e308], [1e20, 1e20], [7, 7]])
def test_a_chart_has_few_values_on_its_axis_whatever_they_are(values):
    assert 1 <= drawn(60, values).count('class="value"') <= 12


def test_many_gaps_are_as_many_bars_as_can_be_seen():
    pauses = [(number * 0.01, number * 0.01 + 0.005) for number in range(10_000)]
    assert drawn(100, [20, 90], pauses).count('class="pause"') <= 300
    apart = [(1, 2), (50, 60), (98, 99)]
    assert drawn(100, [20, 90], apart).count('class="pause"') == 3
