"""The parts of a chart do not grow with the recording."""

from __future__ import annotations

import re

import numpy as np
import pytest

from mikas.catalog import shipped
from mikas.report.charts import chart
from mikas.report.measurements.statistics import BlockTimes, Envelope


def drawn(seconds, values, pauses=()):
    curve = Envelope()
    curve.add(BlockTimes(np.linspace(0.0, seconds, len(values)), 0.0), np.array(values, float))
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


def labels(name, values):
    curve = Envelope()
    curve.add(BlockTimes(np.linspace(0.0, 60, len(values)), 0.0), np.array(values, float))
    drawing = chart(shipped().channel(name), curve, 60, "en").replace("−", "-")
    return [float(found) for found in re.findall(r'class="value"[^>]*>([^<]*)<', drawing)]


def test_noise_does_not_fill_a_chart_and_a_standing_engine_has_no_negative_speed():
    speed = labels("FREQ", [0, 0])
    assert speed[0] == 0
    assert speed[-1] > 800  # to the reference's upper end
    voltage = labels("UACC", [14.1, 14.2])
    assert voltage[-1] - voltage[0] >= 1.5
    assert labels("TAIR", [-3, 5])[0] < 0
