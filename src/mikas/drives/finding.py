"""The drives of a recording: where its engine runs, and from a mark on.

A drive ends where the engine stops, with its session, or in a gap of five minutes. A shorter gap
with a running engine on both sides belongs to the drive: its seconds count, its sums do not.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Final

import numpy as np

from mikas.cancellation import check_cancelled
from mikas.catalog.ignition_only import RUNNING
from mikas.catalog.instrument_channels import is_labelled
from mikas.drives.curves import SampledCurve, sampled_curve
from mikas.drives.measuring import DriveCurves
from mikas.drives.trip import Trip
from mikas.errors import usage_error
from mikas.recording.exchanges.arrays import Floats
from mikas.recording.table.channels import Rows, joined_rows
from mikas.sampling.events import Marker

if TYPE_CHECKING:
    from mikas.recording.capture.reader import Source
    from mikas.recording.recording import Recording

LONGEST_GAP: Final = 300.0  # s, within a drive
SPEED: Final = "GPS_SPEED"
_FUEL: Final = ("JQT", "FUEL_FLOW")
_SHOWN: Final = 10  # marks that an error names


@dataclass(frozen=True, slots=True)
class Running:
    """The engine ran from `begin` to `end`."""

    curves: DriveCurves
    begin: float
    end: float


def trips(recording: Recording, since: Marker | None = None) -> list[Trip]:
    """Return the drives of a recording, in the order of the file; `since` a mark, if given.

    Raises `UsageError` if the engine's speed was not recorded.
    """
    return [each.curves.trip(each.begin, each.end) for each in drives_of(recording, since)]


def since_mark(recordings: Sequence[Recording], wanted: str) -> tuple[int, Marker]:
    """Return the mark of that name, the latest one of several, or of that number from 1 on.

    With it the number of its recording among `recordings`, from 0 on. Raises `UsageError`, which
    names the marks that there are.
    """
    marks = [
        (number, event)
        for number, recording in enumerate(recordings)
        for event in recording.events
        if isinstance(event, Marker)
    ]
    name = wanted.strip().casefold()
    labels = [event.label.strip().casefold() for _, event in marks]
    if name and name in labels:
        return marks[len(labels) - 1 - labels[::-1].index(name)]
    if name.isascii() and name.isdigit() and 1 <= int(name[:9]) <= len(marks):
        return marks[int(name[:9]) - 1]
    if not marks:
        raise usage_error("there is no mark in the recording", "в записи нет ни одной отметки")
    known = ", ".join(
        f"{number} {event.label}".strip() for number, (_, event) in enumerate(marks[:_SHOWN], 1)
    )
    more = ", …" if len(marks) > _SHOWN else ""
    raise usage_error(
        f"there is no mark “{wanted}”; by number and name there are: {known}{more}",
        f"отметки «{wanted}» нет; по номеру и имени есть: {known}{more}",
    )


def drives_of(recording: Recording, since: Marker | None = None) -> Iterator[Running]:
    """Yield the stretches in which the engine runs, with the curves of their time."""
    known = recording.catalog.channels
    names = [name for name in ("FREQ", "RXX", *_FUEL) if name in known]
    corrected = recording.interpreted("corrected", names)
    if "FREQ" not in names or "FREQ" in corrected.absent:
        raise usage_error(
            "FREQ: not in this recording, so nothing says when the engine ran",
            "FREQ: в этой записи нет, поэтому неизвестно, когда двигатель работал",
        )
    for source, rows in session_rows(corrected):
        yield from _running(recording, source.recording, rows, since)


def trips_of_rows(recording: Recording, session: int, stretches: Sequence[Rows]) -> list[Trip]:
    """Return the trips of rows of one port in a session, with FREQ, RXX and the fuel flow.

    Missing channels are NaN. The recording gives the speed.
    """
    return [
        each.curves.trip(each.begin, each.end)
        for rows in _rising(stretches)
        for each in _running(recording, session, rows, None)
    ]


def trips_of_live(rows: Rows, since: float = -inf) -> list[Trip]:
    """Return the trips of rows that have the columns of the instruments, too, from a time on.

    So are those of a running connection. Raises `UsageError` without FREQ.
    """
    if "FREQ" not in rows.values:
        raise usage_error(
            "FREQ: it is not read, so nothing says when the engine ran",
            "FREQ: не опрашивается, поэтому неизвестно, когда двигатель работал",
        )
    name = column_of(rows, SPEED)
    speed = sampled_curve(rows.times, rows.values[name]) if name else None
    names = [each for each in ("FREQ", "RXX", *_FUEL) if each in rows.values]
    unit = Rows(rows.times, {each: rows.values[each] for each in names})
    return [
        each.curves.trip(each.begin, each.end)
        for each in _running_from(_curves(0, unit, speed), since)
    ]


def column_of(rows: Rows, name: str) -> str | None:
    """Return the column of an instrument's channel, the first one with values of several labels."""
    for column, values in rows.values.items():
        if is_labelled(column, name) and np.isfinite(values).any():
            return column
    return None


def _running(
    recording: Recording, session: int, rows: Rows, since: Marker | None
) -> Iterator[Running]:
    """Yield the stretches in which the engine runs."""
    curves = _curves(session, rows, instrument_curve(recording, session, SPEED))
    earliest = -inf
    if since is not None and session <= since.recording:
        earliest = inf if session < since.recording else since.time
    yield from _running_from(curves, earliest)


def _running_from(curves: DriveCurves, earliest: float) -> Iterator[Running]:
    for began, end in _runs(curves.rpm):
        check_cancelled()
        if (begin := max(began, earliest)) < end:
            yield Running(curves, begin, end)


def session_rows(recording: Recording, session: int | None = None) -> Iterator[tuple[Source, Rows]]:
    """Yield the rows of each session and port, or of one session, in stretches of rising times."""
    found: dict[Source, list[Rows]] = {}
    for source, rows in recording.stretches():
        check_cancelled()
        if session is not None and source.recording != session:
            continue
        if len(rows.times):
            found.setdefault(source, []).append(rows)
    for source, stretches in found.items():
        for rows in _rising(stretches):
            yield source, rows


def _rising(stretches: Iterable[Rows]) -> Iterator[Rows]:
    waiting: list[Rows] = []
    for rows in stretches:
        if waiting and rows.times[0] < waiting[-1].times[-1]:  # the clock was set back
            yield joined_rows(waiting)
            waiting = []
        waiting.append(rows)
    if waiting:
        yield joined_rows(waiting)


def _curves(session: int, rows: Rows, speed: SampledCurve | None) -> DriveCurves:
    read = {
        name: sampled_curve(rows.times, column)
        for name, column in rows.values.items()
        if name != "FREQ" and np.isfinite(column).any()
    }
    fuel = next((name for name in _FUEL if name in read), None)
    return DriveCurves(
        session,
        sampled_curve(rows.times, rows.values["FREQ"]),
        read[fuel] if fuel else None,
        fuel,
        speed,
        read.get("RXX"),
    )


def instrument_curve(recording: Recording, session: int, name: str) -> SampledCurve | None:
    """Return what an instrument measured in a session; None without one.

    Of several labelled ones the first that has values counts.
    """
    for channel in recording.instrument_channels:
        if not is_labelled(channel, name):
            continue
        found = recording.instrument_samples(channel, session)
        if found is not None and len(found.times):
            return SampledCurve(found.times, found.values, found.stale)
    return None


def _runs(rpm: SampledCurve) -> Iterator[tuple[float, float]]:
    """Yield the begin and the end of each time in which the engine runs."""
    times, runs = rpm.times, rpm.values >= RUNNING
    if not len(times):
        return
    joined = (np.diff(times) <= LONGEST_GAP) & runs[1:] & runs[:-1]
    edge = np.zeros(1, np.bool_)
    begins = runs & ~np.concatenate((edge, joined))
    ends = runs & ~np.concatenate((joined, edge))
    spans: tuple[Floats, Floats] = times[begins], times[ends]
    yield from zip(spans[0].tolist(), spans[1].tolist(), strict=True)
