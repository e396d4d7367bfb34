"""Features of key on and of cranking."""

from __future__ import annotations

from math import log1p
from typing import Final

from mikas.causes.features.view import Seen, View
from mikas.causes.regimes import Regime
from mikas.causes.samples import median, quantile

DRAWN: Final = 1.5  # V below rest that only a starter draws


def key_on(view: View) -> list[int]:
    """Return the rows before the first start, key on."""
    first = view.drive.running[0] if view.drive.running else len(view.times)
    return [row for row in view.drive.at(Regime.KEY_ON) if row < first]


def rest_voltage(view: View) -> Seen | None:
    """The voltage before the start."""
    rows = key_on(view)
    if len(rows) < 3:
        return None
    return view.seen(quantile(view.values("UACC", rows), 0.8), rows)


def rest_air(view: View) -> Seen | None:
    """The air that the meter shows of a standing engine."""
    rows = view.drive.at(Regime.KEY_ON)
    values = view.values("JAIR", rows[3:])
    return view.seen(median(values), rows) if values else None


def colder_than_air(view: View) -> Seen | None:
    """The coolant against the intake air before the start."""
    rows = key_on(view) or view.drive.starts[:1]
    coolant, intake = view.values("TWAT", rows), view.values("TAIR", rows)
    if not coolant or not intake:
        return None
    difference = median(coolant) - median(intake)
    return view.seen(max(-40.0, min(25.0, difference)), rows, difference)


def _cranking(view: View) -> list[int]:
    """Return where the starter turns the engine, or draws its current in vain."""
    rows = view.drive.at(Regime.CRANKING)
    if len(rows) > 2:
        return rows[1:]
    voltage, standing = view.column("UACC"), key_on(view)
    if voltage is None or not standing:
        return []
    rest = quantile(view.values("UACC", standing), 0.9)
    return [row for row in standing if voltage[row] < rest - DRAWN]


def crank_speed(view: View) -> Seen | None:
    """The cranking speed."""
    rows = _cranking(view)
    if len(rows) < 3:
        return None
    speeds = [view.drive.speed[row] for row in rows if view.drive.speed[row] < 360]
    return view.seen(median(speeds), rows)


def crank_voltage(view: View) -> Seen | None:
    """The voltage while cranking."""
    rows = _cranking(view)
    return view.seen(median(view.values("UACC", rows)), rows) if len(rows) > 2 else None


def crank_dip(view: View) -> Seen | None:
    """How far the voltage falls for the starter."""
    rest, low = rest_voltage(view), crank_voltage(view)
    if rest is None or low is None:
        return None
    return view.seen(rest.value - low.value, _cranking(view))


def crank_pull(view: View) -> Seen | None:
    """The cranking speed for its voltage."""
    speed, voltage = crank_speed(view), crank_voltage(view)
    if speed is None or voltage is None or voltage.value <= 0:
        return None
    return view.seen(speed.value / voltage.value, _cranking(view))


def crank_turns(view: View) -> Seen | None:
    """Turns until the engine fires, beyond those that the cold takes."""
    rows = view.drive.at(Regime.CRANKING)
    starts = view.drive.starts
    if not rows or not starts:
        return None
    turns = 0.0
    for row in rows:
        if row < starts[0] and row + 1 < len(view.times):
            turns += view.drive.speed[row] / 60 * (view.times[row + 1] - view.times[row])
    coolant = view.values("TWAT", rows)
    cold = max(0.0, 60.0 - median(coolant)) * 0.06 if coolant else 0.0
    beyond = turns - cold
    return view.seen(log1p(max(0.0, beyond)), rows, turns)
