"""Features of the air meter: its air against that of throttle and speed."""

from __future__ import annotations

from math import isnan, log1p

from mikas.causes.features.view import Compute, Seen, View
from mikas.causes.samples import median, quantile


def breathing(low: float, high: float) -> Compute:
    """The air of the meter against that of throttle and speed."""

    def compute(view: View) -> Seen | None:
        expected, air = view.expected(), view.column("JAIR")
        if air is None:
            return None
        rows = [r for r in view.steady_load() if low <= expected.get(r, -1.0) < high]
        ratios = [air[row] / expected[row] for row in rows if not isnan(air[row])]
        if view.seconds(rows) < 5 or not ratios:
            return None
        return view.seen(median(ratios), rows)

    return compute


def spread_of_breathing(view: View) -> Seen | None:
    """The range of the measured air against that of throttle and speed."""
    expected, air = view.expected(), view.column("JAIR")
    if air is None:
        return None
    ratios = [air[r] / expected[r] for r in view.steady_load() if r in expected]
    if len(ratios) < 40:
        return None
    width = quantile(ratios, 0.97) - quantile(ratios, 0.03)
    return view.seen(log1p(max(0.0, width)), view.load, width)


def no_air(view: View) -> Seen | None:
    """Seconds without air through the meter while the engine runs."""
    air = view.column("JAIR")
    if air is None or view.seconds(view.drive.running) < 20:
        return None
    rows = [r for r in view.drive.running if air[r] < 2.0]
    seconds = view.seconds(rows)
    return view.seen(log1p(2 * seconds), rows, seconds)
