"""The figures of each car, by SQL: what it measured drive by drive, and which faults it stored."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from typing import Final

from mikas.catalog import Catalog
from mikas.causes.result import CauseVerdict, Likelihood
from mikas.cleaning import clean_line
from mikas.fleet.cars import KnownBy
from mikas.fleet.query.database import Database
from mikas.fleet.report.causes import JudgedDrive
from mikas.fleet.report.measures import MEASURES
from mikas.fleet.states import DriveState
from mikas.i18n import Text
from mikas.report.findings import FEWEST
from mikas.report.measurements.warm_idle import ENOUGH

_AHEAD: Final = timedelta(days=1)  # that a right clock can be ahead of this computer's

# The tables may be a stranger's: what no recording can have is as if it were not there.
_DATED: Final = (
    "CASE WHEN {0} BETWEEN TIMESTAMP '1970-01-01' AND TIMESTAMP '9998-01-01' THEN {0} END"
)
_LENGTH: Final = "CASE WHEN {0} BETWEEN 0 AND 1e10 THEN {0} END"
_LARGEST: Final = 1e9  # of a measure, in its unit
_LONGEST: Final = 200  # characters of a name

_DRIVES: Final = f"""
SELECT car, drive, {_DATED.format("began")} AS day_and_time, {_LENGTH.format("seconds")}, known_by,
    left(name, {_LONGEST}), left(plate, {_LONGEST}), {_LENGTH.format("warm_idle_seconds")},
    verdict, likelihood, left(cause_en, {_LONGEST}), left(cause_ru, {_LONGEST})
FROM drives ORDER BY car, day_and_time, drive
"""
_STATISTICS: Final = f"""
SELECT drive, channel, state, median FROM statistics
WHERE state <> 'all' AND count >= ? AND abs(median) <= {_LARGEST}
"""
_FAULTS: Final = f"""
SELECT drive, before, {_DATED.format("utc")} AS read,
    list(DISTINCT code ORDER BY code) FILTER (code BETWEEN 0 AND 255 AND NOT message)
FROM faults GROUP BY drive, reading, before, read ORDER BY drive, reading
"""


@dataclass(frozen=True, slots=True)
class DatedFaults:
    """The real faults that were stored at a time."""

    time: datetime
    codes: tuple[int, ...]


@dataclass(slots=True)
class CarFigures:
    """One car. `series`: by measure, (time, value) of each dated drive that has it, in order;
    `readings`: of the faults, in dated drives; `read`: whether they were read in any drive;
    `undated`: drives without a date; `ahead`: dated in the future; `judged`: the dated drives whose
    causes were looked for, in order; `unjudged`: drives added before causes were.
    """

    car: str
    known_by: frozenset[KnownBy] = frozenset()
    name: str = ""
    drives: int = 0
    undated: int = 0
    ahead: int = 0
    seconds: float = 0.0
    first: datetime | None = None
    last: datetime | None = None
    series: dict[str, list[tuple[datetime, float]]] = field(default_factory=dict)
    readings: list[DatedFaults] = field(default_factory=list)
    read: bool = False
    judged: list[JudgedDrive] = field(default_factory=list)
    unjudged: int = 0

    def values(self, measure: str) -> list[float]:
        """Return the values of a measure in the order of the drives."""
        return [value for _, value in self.series.get(measure, ())]


@dataclass(frozen=True, slots=True)
class FleetFigures:
    """All cars, by name. `unknown`: drives of a car that is not known; `now`: UTC; `refused`:
    recordings that the dataset has, and that can't be used.
    """

    cars: tuple[CarFigures, ...]
    unknown: int
    now: datetime
    refused: int = 0


@dataclass(slots=True)
class _Drive:
    """A drive of a known car. `began`: None without a right date; `stored`: the faults in it."""

    car: CarFigures
    is_idle: bool
    began: datetime | None = None
    stored: set[int] = field(default_factory=set)


def figures(database: Database, catalog: Catalog, now: datetime) -> FleetFigures:
    """Return the figures of a dataset. `now`: UTC; a drive after it has a wrong clock."""
    cars: dict[str, CarFigures] = {}
    drives: dict[str, _Drive] = {}
    unknown = 0
    for row in database.rows(_DRIVES):
        car, drive, began, seconds, known_by, name, plate, warm, *causes = row
        if car is None:
            unknown += 1
            continue
        it = cars.setdefault(car, CarFigures(car))
        drives[drive] = _Drive(it, is_idle=(warm or 0.0) >= ENOUGH)
        it.drives += 1
        it.seconds += seconds or 0.0
        it.known_by |= {KnownBy(known_by)} if known_by in tuple(KnownBy) else set()
        beside = plate if known_by != KnownBy.PLATE else None  # else it is the car's name here
        it.name = clean_line(" · ".join(filter(None, (name, beside)))) or it.name
        if began is None:
            it.undated += 1
        elif began > now + _AHEAD:
            it.ahead += 1
        else:
            it.first, it.last = it.first or began, began
            drives[drive].began = began
            _add_causes(it, began, seconds or 0.0, *causes)
    _add_readings(database, drives)
    _add_series(database, catalog, drives)
    return FleetFigures(tuple(cars.values()), unknown, now, len(database.ledger.refused))


def _add_causes(
    car: CarFigures,
    began: datetime,
    seconds: float,
    verdict: str | None,
    likelihood: str | None,
    *cause: str | None,
) -> None:
    """Add the causes of a drive; a column that an earlier program did not write is NULL."""
    if verdict not in tuple(CauseVerdict):
        car.unjudged += 1
        return
    en, ru = (clean_line(text or "") for text in cause)
    named = likelihood in tuple(Likelihood) and en and ru
    car.judged.append(
        JudgedDrive(
            began,
            seconds,
            CauseVerdict(verdict),
            Likelihood(likelihood) if named and likelihood else None,
            Text(en, ru) if named else None,
        )
    )


def _add_readings(database: Database, drives: Mapping[str, _Drive]) -> None:
    """Add the readings of the faults, each once: several recordings may have one that was before
    them.
    """
    found: dict[str, set[DatedFaults]] = defaultdict(set)
    for drive, before, time, codes in database.rows(_FAULTS):
        if (it := drives.get(drive)) is None:
            continue
        it.stored = set(codes or ()) | (set() if before else it.stored)
        it.car.read = True
        if it.began is not None and time is not None:
            found[it.car.car].add(DatedFaults(time, tuple(codes or ())))
    for car in {id(it.car): it.car for it in drives.values()}.values():
        readings = found[car.car]
        car.readings = sorted(readings, key=lambda reading: (reading.time, reading.codes))


def _add_series(database: Database, catalog: Catalog, drives: Mapping[str, _Drive]) -> None:
    """Add the values, but those from a sensor whose circuit was faulty in that drive."""
    measures = {(each.name, each.state.value): each.key for each in MEASURES}
    for drive, channel, state, value in database.rows(_STATISTICS, FEWEST):
        key, it = measures.get((channel, state)), drives.get(drive)
        if key is None or it is None or it.began is None:
            continue
        if state == DriveState.WARM_IDLE and not it.is_idle:
            continue
        if not any(channel in catalog.fault(code).sensor for code in it.stored):
            it.car.series.setdefault(key, []).append((it.began, value))
    for car in {id(it.car): it.car for it in drives.values()}.values():
        for series in car.series.values():
            series.sort()
