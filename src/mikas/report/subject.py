"""The subject of a report: the unit, its faults, the conditions of the measurement.

Filled in from a recording or a running session; None or empty: unknown, which the report says.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime
from itertools import pairwise
from typing import Final

from mikas.catalog import Catalog, Fault, Model
from mikas.causes.result import Ranking
from mikas.client.cars import NO_CAR, CarDetails
from mikas.drives.mixture import MixtureComparison
from mikas.drives.trip import Trip
from mikas.drives.ways import WayStretch
from mikas.guided.result import TestResult
from mikas.i18n import Text
from mikas.recording.freeze_frames import AppearedFault
from mikas.sampling.events import ClockChanged, FaultReading, Gap

_MOST_CLEARED: Final = 20


@dataclass(frozen=True, slots=True)
class ReportedUnit:
    """The unit. Its passport: three pieces of the program, five of the data; None: a piece that the
    unit did not report; no pieces at all: the passport was not read.
    """

    model: Model
    program: tuple[str | None, ...] = ()
    data: tuple[str | None, ...] = ()


@dataclass(frozen=True, slots=True)
class Conditions:
    """Conditions of the measurement. `file`: the recording's name; empty: a running session.
    `interruptions` None: not noted.

    `date` None: the clock was a simulated one. `method`: the last one; `other_methods`: there were
    others before. `errors`: exchanges that failed since connecting. `sessions`: how many the file
    holds; the report is of the last. `ports`: of that session; the report is of the one with most
    values. `damaged`: places that could not be read. `cars`: those of the file. `clock`: what the
    computer's date did meanwhile. `empty`: the file has no packets.
    """

    file: str = ""
    date: datetime | None = None
    port: str = ""
    adapter: str = ""
    echo: bool | None = None
    method: str = ""
    interruptions: tuple[Gap, ...] | None = ()
    other_methods: bool = False
    errors: int | None = None
    sessions: int = 1
    ports: int = 1
    damaged: int = 0
    cars: tuple[Text, ...] = ()
    clock: tuple[ClockChanged, ...] = ()
    empty: bool = False


@dataclass(frozen=True, slots=True)
class ClearedFaults:
    """Faults that were no longer stored at `time`, on the link's clock. `erased`: by a tester;
    else for an unknown reason (battery disconnected, or the unit dropped them).
    """

    time: float
    faults: tuple[Fault, ...]
    erased: bool


@dataclass(frozen=True, slots=True)
class ReportedDrive:
    """What an instrument beside the unit adds: the session's drives, and the way of the car."""

    trips: tuple[Trip, ...] = ()
    way: tuple[WayStretch, ...] = ()


@dataclass(frozen=True, slots=True)
class ReportSubject:
    """All of these. `faults` None: not read; else those stored at `faults_read`; `gone`: those
    stored before; `appeared`: those that came between two readings, the latest first. `notes`: the
    user's notes, in order. `tests`: the guided tests to show. `car`: as the user names it.
    `causes`: ranked from the values; None: not looked for. `drive`: None without a receiver.
    `mixture`: None without a λ meter.
    """

    catalog: Catalog
    unit: ReportedUnit | None = None
    faults: tuple[Fault, ...] | None = None
    conditions: Conditions = field(default_factory=Conditions)
    notes: tuple[str, ...] = ()
    faults_read: float | None = None
    cleared: tuple[ClearedFaults, ...] = ()
    tests: tuple[TestResult, ...] = ()
    car: CarDetails = NO_CAR
    appeared: tuple[AppearedFault, ...] = ()
    causes: Ranking | None = None
    drive: ReportedDrive | None = None
    mixture: MixtureComparison | None = None


def cleared_faults(heard: Sequence[FaultReading], catalog: Catalog) -> tuple[ClearedFaults, ...]:
    """Return the faults of one reading that are missing in the next, of the last few times."""
    missing = (
        (after, [code for code in dict.fromkeys(before.codes) if code not in stored])
        for before, after in pairwise(heard)
        for stored in [frozenset(after.codes)]
    )
    cleared = deque(((after, codes) for after, codes in missing if codes), _MOST_CLEARED)
    return tuple(
        ClearedFaults(after.time, tuple(map(catalog.fault, codes)), after.erased)
        for after, codes in cleared
    )
