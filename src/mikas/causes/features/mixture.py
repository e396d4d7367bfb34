"""Features of the mixture: the trim by air flow."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from mikas.causes.features.view import Compute, Seen, View

NEUTRAL: Final = -0.5  # E3: RCOK without a correction, by the letter


def thin(view: View) -> list[int]:
    """Return rows under a light load."""
    air = view.column("JAIR")
    return [] if air is None else [row for row in view.load if 12 < air[row] < 70]


def thick(view: View) -> list[int]:
    """Return rows under a heavy load."""
    air = view.column("JAIR")
    return [] if air is None else [row for row in view.load if air[row] >= 70]


def trim(rows_of: Callable[[View], list[int]], seconds: float) -> Compute:
    """Return the feature of the mean trim in these rows."""

    def compute(view: View) -> Seen | None:
        rows = [row for row in rows_of(view) if view.drive.run_time[row] > 45]
        values = view.values("RCOK", rows)
        if view.seconds(rows) < seconds or not values:
            return None
        trim = 100 * (sum(values) / len(values) - NEUTRAL)
        return view.seen(trim, rows)

    return compute


def trim_difference(view: View) -> Seen | None:
    """The trim at idle against that under a light load."""
    idle, load = trim(lambda v: v.idle, 12)(view), trim(thin, 12)(view)
    if idle is None or load is None:
        return None
    return view.seen(idle.value - load.value, view.idle)
