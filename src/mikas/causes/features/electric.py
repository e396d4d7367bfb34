"""Features of charging: the voltage by speed, load and time."""

from __future__ import annotations

from typing import Final

from mikas.causes.features.view import Seen, View
from mikas.causes.samples import median, quantile


def _fast(view: View) -> list[int]:
    return [r for r in view.load if view.drive.speed[r] > 1500 and view.drive.run_time[r] > 60]


def charging_fast(view: View) -> Seen | None:
    """The voltage while driving."""
    rows = _fast(view)
    return view.seen(median(view.values("UACC", rows)), rows) if len(rows) > 20 else None


def charging_most(view: View) -> Seen | None:
    """The highest voltage while driving."""
    rows = _fast(view)
    if len(rows) < 20:
        return None
    return view.seen(quantile(view.values("UACC", rows), 0.95), rows)


def charging_spread(view: View) -> Seen | None:
    """The range of the voltage while driving."""
    rows = _fast(view)
    values = view.values("UACC", rows)
    if len(rows) < 20:
        return None
    return view.seen(quantile(values, 0.9) - quantile(values, 0.1), rows)


HIGH: Final = 2400.0  # rpm at which a sound alternator carries everything that is switched on
CHARGED: Final = 240.0  # s after which a battery takes little more


def charging_held(view: View) -> Seen | None:
    """The range of the voltage at high revs: a regulator holds it, a spent alternator does not."""
    drive = view.drive
    rows = [r for r in view.load if drive.speed[r] > HIGH and drive.run_time[r] > CHARGED]
    values = view.values("UACC", rows)
    if view.seconds(rows) < 15 or not values:
        return None
    return view.seen(quantile(values, 0.97) - quantile(values, 0.03), rows)


def charging_fall(view: View) -> Seen | None:
    """How far the voltage falls from driving to idle."""
    rows = _fast(view)
    if len(rows) < 20 or view.seconds(view.idle) < 8:
        return None
    high = quantile(view.values("UACC", rows), 0.9)
    return view.seen(high - quantile(view.values("UACC", view.idle), 0.1), view.idle)


def recovery(view: View) -> Seen | None:
    """The voltage late against early in the run: a battery that was low takes current at first."""
    run = view.drive.run_time
    if not view.drive.starts:
        return None
    early = [row for row in view.drive.running if 10 < run[row] < 60]
    late = [row for row in view.drive.running if run[row] > 240]
    if len(early) < 20 or len(late) < 50:
        return None
    return view.seen(median(view.values("UACC", late)) - median(view.values("UACC", early)), early)
