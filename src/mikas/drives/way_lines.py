"""The way as few lines, each of one level of the value that gives the colour.

Places that fall on the same spot of a drawing are one, so the number of points is bounded by the
drawing, not by the drive.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite
from typing import Final

from mikas.cancellation import check_cancelled
from mikas.drives.ways import WayStretch

SPEEDS: Final = (20.0, 40.0, 60.0, 90.0)
"""km/h, the ends of the levels of the speed."""
LEVELS: Final = 5


@dataclass(frozen=True, slots=True)
class WayLine:
    """A line. `level`: of its value, from 0 on; None: unknown. `points`: metres east and north."""

    level: int | None
    points: tuple[tuple[float, float], ...]


def way_lines(
    stretches: Sequence[WayStretch], ends: Sequence[float], near: float
) -> Iterator[WayLine]:
    """Yield the lines. `ends`: of the levels, rising; `near`: metres within which places are one.

    A line begins where the one before ends.
    """
    for each in stretches:
        check_cancelled()
        yield from _lines(_thinned(each, near), ends)


def level_ends(stretches: Sequence[WayStretch]) -> tuple[float, ...]:
    """Return the ends of five levels of equal height; empty if all values are alike, or unknown."""
    values = [value for each in stretches for value in each.values.tolist() if isfinite(value)]
    low, high = min(values, default=0.0), max(values, default=0.0)
    if high <= low:
        return ()
    return tuple(low + (high - low) * step / LEVELS for step in range(1, LEVELS))


def _lines(
    points: Sequence[tuple[float, float, float]], ends: Sequence[float]
) -> Iterator[WayLine]:
    run: list[tuple[float, float]] = []
    was: int | None = None
    began = False
    for (east, north, value), (_, _, after) in pairwise([*points, points[-1]]):
        level = _level_of(after if isfinite(after) else value, ends)
        run.append((east, north))
        if began and level != was:
            yield WayLine(was, tuple(run))
            run = [(east, north)]
        was, began = level, True
    if len(run) > 1:
        yield WayLine(was, tuple(run))


def _thinned(stretch: WayStretch, near: float) -> list[tuple[float, float, float]]:
    kept: list[tuple[float, float, float]] = []
    places = list(
        zip(stretch.east.tolist(), stretch.north.tolist(), stretch.values.tolist(), strict=True)
    )
    for place, (east, north, value) in enumerate(places):
        is_end = place == len(places) - 1
        is_apart = not kept or max(abs(east - kept[-1][0]), abs(north - kept[-1][1])) >= near
        if is_end or is_apart:
            kept.append((east, north, value))
    return kept


def _level_of(value: float, ends: Sequence[float]) -> int | None:
    return sum(value >= end for end in ends) if isfinite(value) else None
