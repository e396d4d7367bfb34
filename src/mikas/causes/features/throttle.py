"""Features of the throttle: where it closes, how far it opens, where its sensor lies."""

from __future__ import annotations

from math import log1p
from typing import Final

from mikas.causes.features.view import Seen, View
from mikas.causes.samples import Span, row_at, spans_of


def hidden_throttle(view: View) -> Seen | None:
    """Seconds in which the engine breathes much more than a closed throttle lets through."""
    throttle, expected, air = view.column("THR"), view.expected(), view.column("JAIR")
    if throttle is None or air is None or view.seconds(view.drive.running) < 20:
        return None
    rows = [
        row
        for row in view.drive.running
        if throttle[row] < 0.8
        and view.drive.speed[row] > 1000
        and air[row] > 1.7 * expected.get(row, 1e9) + 8
    ]
    seconds = view.seconds(rows)
    return view.seen(log1p(2 * seconds), rows, seconds)


def throttle_jumps(view: View) -> Seen | None:
    """Falls of the throttle to 0 from an opening that the air does not follow, a minute."""
    throttle, air = view.column("THR"), view.column("JAIR")
    if throttle is None or air is None or view.seconds(view.load) < 20:
        return None
    rows = [
        row
        for row in view.drive.running[1:]
        if throttle[row] < 0.6
        and throttle[row - 1] > 1.5
        and air[row] > 0.75 * air[row - 1]
        and air[row] > 22
    ]
    rate = len(rows) / (view.seconds(view.drive.running) / 60)
    return view.seen(log1p(2 * rate), rows, rate)


def least_throttle(view: View) -> Seen | None:
    """The least opening of the throttle."""
    if view.seconds(view.drive.running) < 20 or not view.drive.let_go:
        return None
    return view.seen(view.drive.closed, view.idle or view.drive.running)


FLOORED: Final = 93.0  # % that a throttle reaches only with the pedal on the floor
SAME: Final = 0.6  # % within which openings are one and the same end
RISE: Final = 100.0  # rpm by which the engine still speeds up with the throttle at its end


def _ends(view: View) -> tuple[float, list[int]]:
    """Return the widest opening, and its rows: none if no drive showed that it is an end.

    It is one if it is fully open, or if the engine sped up several times at one and the same
    opening: a pedal that holds a speed ends somewhere by chance, and the engine is steady there.
    """
    throttle = view.column("THR")
    values = view.values("THR", view.load)
    if throttle is None or not values or view.seconds(view.load) < 20:
        return 0.0, []
    widest = max(values)
    top = [row for row in view.load if throttle[row] >= widest - SAME]
    if widest >= FLOORED:
        return widest, top
    spans = [span for span in spans_of(view.times, top) if span[1] - span[0] >= 0.8]
    rising = [span for span in spans if _rise(view, span) >= RISE]
    seconds = sum(end - begin for begin, end in spans)
    is_end = widest >= 15 and len(rising) >= 2 and seconds >= 3.0
    return widest, top if is_end else []


def _rise(view: View, span: Span) -> float:
    """Return by how much the engine sped up, rpm."""
    first, last = (row_at(view.times, time) for time in span)
    return view.drive.speed[last] - view.drive.speed[first]


def flat_top(view: View) -> Seen | None:
    """The share of the wide openings that is exactly the widest: a plate that meets a stop."""
    widest, top = _ends(view)
    if not top:
        return None
    if widest >= FLOORED:
        return view.seen(0.0, top)
    throttle = view.values("THR", view.load)
    wide = sum(1 for value in throttle if value >= 0.75 * widest)
    return view.seen(len(top) / wide * min(1.0, view.seconds(top) / 3.0), top)


def widest_throttle(view: View) -> Seen | None:
    """The widest opening of the throttle, where that is an end."""
    widest, top = _ends(view)
    return view.seen(widest, top) if top else None
