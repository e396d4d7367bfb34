"""Features of the ignition: knock, and what the unit takes back for it."""

from __future__ import annotations

from math import log1p

from mikas.causes.features.view import Seen, View


def knock_rate(view: View) -> Seen | None:
    """Readings with knock, a minute of load."""
    flag, throttle = view.column("DET"), view.column("THR")
    rows = [r for r in view.load if throttle is not None and throttle[r] > 12]
    if flag is None or view.seconds(rows) < 15:
        return None
    heard = [row for row in rows if flag[row] == 1]
    rate = len(heard) / (view.seconds(rows) / 60)
    return view.seen(log1p(rate), heard, rate)


def retard(view: View) -> Seen | None:
    """The mean advance taken back for knock, under load."""
    throttle = view.column("THR")
    rows = [r for r in view.load if throttle is not None and throttle[r] > 12]
    values = view.values("UOZOC", rows)
    if view.seconds(rows) < 15 or not values:
        return None
    middle = sum(values) / len(values)
    return view.seen(-log1p(max(0.0, -middle)), rows, middle)


def most_retard(view: View) -> Seen | None:
    """The most advance taken back for knock."""
    values = view.values("UOZOC", view.load)
    if view.seconds(view.load) < 60 or not values:
        return None
    return view.seen(min(values), view.load)
