"""All that a screen shows of drives: their sums, the way in a colour, the measured mixture.

Of a recording, or of the rows of a running connection, from a mark on or from the first row.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING, Final

from mikas.drives.curves import SampledCurve, sampled_curve
from mikas.drives.finding import SPEED, instrument_curve, session_rows, trips, trips_of_live
from mikas.drives.mixture import MixtureComparison, compared_mixture, mixture_of_live
from mikas.drives.trip import Trip
from mikas.drives.way_lines import SPEEDS, WayLine, level_ends, way_lines
from mikas.drives.ways import WayStretch, way_of_rows, way_since
from mikas.errors import UsageError
from mikas.i18n import Text

if TYPE_CHECKING:
    from mikas.recording.recording import Recording
    from mikas.recording.table.channels import Rows
    from mikas.sampling.events import Marker

_FINE: Final = 600.0  # parts of the way's extent, within one of which places are one


@dataclass(frozen=True, slots=True)
class DrawnWay:
    """The way as lines. `ends`: of the levels of `colour`, empty if it has one value."""

    colour: str
    ends: tuple[float, ...]
    lines: tuple[WayLine, ...]


@dataclass(frozen=True, slots=True)
class DriveOverview:
    """The figures that are known. `why`: why those of the engine's runs are not; None: they are."""

    trips: list[Trip] = field(default_factory=list)
    why: Text | None = None
    way: DrawnWay | None = None
    mixture: MixtureComparison | None = None


def overview_of_recording(
    recording: Recording, since: Marker | None = None, colour: str = SPEED
) -> DriveOverview:
    """Return what a recording has. `colour`: a channel of it, of the unit or of an instrument.

    The mixture is that of its last session. Raises `UsageError` for an unknown channel.
    """
    found, why = _or_why(lambda: trips(recording, since))
    way = way_since(recording, _colours(recording, colour), since)
    last = recording.raw.last_session
    mixture = None if last is None else compared_mixture(recording, last)
    return DriveOverview(found, why, _drawn(way, colour), mixture)


def overview_of_live(rows: Rows, since: float = -inf, colour: str = SPEED) -> DriveOverview:
    """Return what rows have, from a time on; they have the columns of the instruments, too."""
    found, why = _or_why(lambda: trips_of_live(rows, since))
    way = way_of_rows(rows, colour, since)
    return DriveOverview(found, why, _drawn(way, colour), mixture_of_live(rows))


def _or_why(find: Callable[[], list[Trip]]) -> tuple[list[Trip], Text | None]:
    try:
        return find(), None
    except UsageError as error:  # the engine's speed was not recorded
        return [], error.text


def _colours(recording: Recording, name: str) -> dict[int, SampledCurve]:
    """Return the curve of the channel in each session."""
    sessions = sorted(recording.raw.spans)
    beside = {number: instrument_curve(recording, number, name) for number in sessions}
    curves = {number: curve for number, curve in beside.items() if curve is not None}
    if curves or name not in recording.catalog.channels:
        return curves
    for source, rows in session_rows(recording.interpreted("corrected", [name])):
        curves.setdefault(source.recording, sampled_curve(rows.times, rows.values[name]))
    return curves


def _drawn(way: Sequence[WayStretch], colour: str) -> DrawnWay | None:
    if not way:
        return None
    extent = max(
        max(float(each[-1]) for each in ends) - min(float(each[0]) for each in ends)
        for ends in (
            [(it.east.min(), it.east.max()) for it in way],
            [(it.north.min(), it.north.max()) for it in way],
        )
    )
    ends = SPEEDS if colour.startswith(SPEED) else level_ends(way)
    return DrawnWay(colour, ends, tuple(way_lines(way, ends, extent / _FINE)))
