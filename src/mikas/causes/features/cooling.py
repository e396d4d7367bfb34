"""Features of warmth: warming up, and where the coolant stays."""

from __future__ import annotations

from math import isnan, nan

from mikas.causes.features.view import Seen, View
from mikas.causes.samples import median, quantile


def _plateau_rows(view: View) -> list[int]:
    """Rows of a run that is warm: long enough, or past the greatest warmth of a slow one."""
    coolant, run = view.column("TWAT"), view.drive.run_time
    if coolant is None:
        return []
    top = quantile(view.values("TWAT", view.drive.running), 0.98)
    rows = [r for r in view.drive.running if run[r] > 330 and not isnan(coolant[r])]
    if not rows:
        return []
    first = next((r for r in view.drive.running if coolant[r] >= top - 4), rows[-1])
    return [row for row in rows if row >= first]


def _driven(view: View) -> list[int]:
    """Rows of a warm engine in a car that has been driven for a while (wind at the radiator)."""
    rows = set(_plateau_rows(view))
    return [row for row in view.load if row in rows]


def warmth_driven(view: View) -> Seen | None:
    """The coolant of a warm engine, driven."""
    rows = _driven(view)
    return view.seen(median(view.values("TWAT", rows)), rows) if len(rows) > 40 else None


def most_warmth(view: View) -> Seen | None:
    """The greatest warmth of the coolant."""
    values = view.values("TWAT", view.drive.running)
    if view.seconds(view.drive.running) < 60 or not values or max(values) < 78:
        return None
    return view.seen(quantile(values, 0.99), view.drive.running)


def cooling_by_wind(view: View) -> Seen | None:
    """How far the coolant falls again after it was warm, driven."""
    rows = _plateau_rows(view)
    values = view.values("TWAT", rows)
    if view.seconds(rows) < 100 or view.seconds(_driven(view)) < 60:
        return None
    return view.seen(max(values) - quantile(values, 0.03), rows)


def rise_at_idle(view: View) -> Seen | None:
    """How much warmer the coolant gets at idle than while driving."""
    warm = set(_plateau_rows(view))
    driven = [row for row in view.load if row in warm]
    idle = [row for row in view.idle if row in warm]
    if len(driven) < 40 or view.seconds(idle) < 15:
        return None
    rise = quantile(view.values("TWAT", idle), 0.9) - median(view.values("TWAT", driven))
    return view.seen(rise, idle)


def evenness(view: View) -> Seen | None:
    """The range of the coolant once it is warm."""
    values = view.values("TWAT", _plateau_rows(view))
    if len(values) < 200 or view.seconds(_driven(view)) < 60:
        return None
    return view.seen(quantile(values, 0.95) - quantile(values, 0.05), _plateau_rows(view))


def warm_up(view: View) -> Seen | None:
    """Degrees a litre of petrol while the engine warms up."""
    coolant, fuel = view.column("TWAT"), view.column("JQT")
    if coolant is None or fuel is None or not view.drive.running:
        return None
    burnt, begin, rows = 0.0, nan, []
    for before, row in zip(view.drive.running, view.drive.running[1:], strict=False):
        if isnan(coolant[row]) or isnan(fuel[row]):
            continue
        if isnan(begin):
            if coolant[row] > 65:
                return None
            begin = coolant[row]
        step = view.times[row] - view.times[before]
        burnt += fuel[row] * (step if step < 3 else 0.0) / 3600
        rows.append(row)
        if coolant[row] >= 74 or (coolant[row] - begin >= 45):
            break
    rise = coolant[rows[-1]] - begin if rows else 0.0
    if burnt < 0.1 or rise < 15:
        return None
    return view.seen(rise / burnt, rows)


def late_warm_up(view: View) -> Seen | None:
    """Degrees a litre from 50 to 72 °C: there an open thermostat shows most."""
    coolant, fuel = view.column("TWAT"), view.column("JQT")
    if coolant is None or fuel is None:
        return None
    rows = [r for r in view.drive.running if 48 <= coolant[r] <= 72]
    if not rows or view.seconds(rows) < 40 or min(coolant[r] for r in rows) > 53:
        return None
    burnt = sum(fuel[r] for r in rows if not isnan(fuel[r])) / len(rows)
    burnt *= view.seconds(rows) / 3600
    rise = max(coolant[r] for r in rows) - min(coolant[r] for r in rows)
    return view.seen(rise / max(burnt, 0.02), rows)
