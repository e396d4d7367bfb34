"""Features of idle: the valve, its passage, the air that it aims at; an engine that died."""

from __future__ import annotations

from collections.abc import Callable
from math import isnan, log1p

from mikas.causes.features.view import Compute, Seen, View
from mikas.causes.samples import median, quantile
from mikas.virtual.model import physics as ph


def stalls(view: View) -> Seen | None:
    """How often the engine died."""
    rows = view.drive.stalls
    if view.drive.samples.seconds < 30 or not view.drive.running:
        return None
    return view.seen(log1p(len(rows)), rows, float(len(rows)))


def valve_lag(view: View) -> Seen | None:
    """How far the idle valve is from where the unit wants it."""
    want, have = view.column("SSM"), view.column("FSM")
    rows = view.idle or view.cold
    if want is None or have is None or view.seconds(rows) < 8:
        return None
    off = [abs(want[row] - have[row]) for row in rows if not isnan(want[row] + have[row])]
    return view.seen(quantile(off, 0.9), rows)


def passage(rows_of: Callable[[View], list[int]]) -> Compute:
    """Air through the idle valve, against that of a clean passage at its position."""

    def compute(view: View) -> Seen | None:
        rows = rows_of(view)
        air, valve, intake = view.column("JAIR"), view.column("FSM"), view.column("TAIR")
        if air is None or valve is None or view.seconds(rows) < 6:
            return None
        throttle = view.column("THR")
        ratios = []
        for row in rows:
            warmth = intake[row] if intake is not None and not isnan(intake[row]) else 20.0
            opening = throttle[row] if throttle is not None and not isnan(throttle[row]) else 0.0
            due = (ph.throttle_air(opening) + valve[row] * ph.VALVE_FLOW) * ph.density(warmth)
            if not isnan(air[row] + due) and due > 0:
                ratios.append(air[row] / due)
        return view.seen(median(ratios), rows)

    return compute


def air_below_set(view: View) -> Seen | None:
    """How far the air at idle is below the one that the unit aims at."""
    goal, air = view.column("UGB"), view.column("JAIR")
    if goal is None or air is None or view.seconds(view.idle) < 8:
        return None
    off = [goal[row] - air[row] for row in view.idle if not isnan(goal[row] + air[row])]
    return view.seen(median(off), view.idle)
