"""The findings of a fleet: which car stands out in what, what changes, which faults it stored."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime

from mikas.catalog import Catalog, Fault
from mikas.fleet.report import comparing
from mikas.fleet.report.figures import CarFigures, FleetFigures
from mikas.fleet.report.measures import MEASURES, CarMeasure
from mikas.report.findings import Outcome
from mikas.report.measurements.statistics import is_inside


@dataclass(frozen=True, slots=True)
class CarFault:
    """A fault of a car: first and last reading with it, and whether the latest reading had it.

    `marks`: of each reading, whether it had it.
    """

    fault: Fault
    first: datetime
    last: datetime
    is_stored: bool
    marks: tuple[bool, ...]


@dataclass(frozen=True, slots=True)
class CarFindings:
    """All findings of a car: the measures in which it differs from the others, those that change
    over its drives, and those outside their normal range, with the value.
    """

    figures: CarFigures
    stands_out: Mapping[CarMeasure, comparing.Outlier]
    changes: Mapping[CarMeasure, comparing.Trend]
    out_of_range: Mapping[CarMeasure, float]
    faults: tuple[CarFault, ...]

    @property
    def found(self) -> bool:
        """Whether the car needs attention: a stored fault, or a value."""
        stored = any(each.is_stored for each in self.faults)
        return stored or bool(self.stands_out or self.changes or self.out_of_range)

    @property
    def measures(self) -> tuple[CarMeasure, ...]:
        """The measures of its findings."""
        return tuple(dict.fromkeys((*self.out_of_range, *self.stands_out, *self.changes)))


@dataclass(frozen=True, slots=True)
class FleetFindings:
    """The content of the report. `values`: by measure, of the cars that have one; `compared`:
    the measures with enough cars; `followed`: cars with enough drives for a trend of some measure.
    """

    catalog: Catalog
    figures: FleetFigures
    cars: tuple[CarFindings, ...]
    values: Mapping[CarMeasure, Collection[float]]
    compared: tuple[CarMeasure, ...]
    followed: int

    @property
    def outcome(self) -> Outcome:
        """Attention: a car needs it. Good: none does, and something was compared."""
        if any(car.found for car in self.cars):
            return Outcome.ATTENTION
        return Outcome.GOOD if self.compared else Outcome.OPEN


def find(figures: FleetFigures, catalog: Catalog) -> FleetFindings:
    """Apply the rules. Pure."""
    values = {
        measure: {
            car.car: value
            for car in figures.cars
            if (value := comparing.value_of(car.values(measure.key))) is not None
        }
        for measure in MEASURES
    }
    peers = {measure: comparing.Peers(of_cars.values()) for measure, of_cars in values.items()}
    cars = tuple(_car(car, values, peers, catalog) for car in figures.cars)
    return FleetFindings(
        catalog,
        figures,
        cars,
        {measure: of_cars.values() for measure, of_cars in values.items() if of_cars},
        tuple(each for each in MEASURES if len(values[each]) > comparing.FEWEST_OTHERS),
        sum(
            any(len(series) >= comparing.FEWEST_OF_TREND for series in car.series.values())
            for car in figures.cars
        ),
    )


def _car(
    car: CarFigures,
    values: Mapping[CarMeasure, Mapping[str, float]],
    peers: Mapping[CarMeasure, comparing.Peers],
    catalog: Catalog,
) -> CarFindings:
    stands_out, changes, out_of_range = {}, {}, {}
    for measure in MEASURES:
        mine = values[measure].get(car.car)
        if mine is not None:
            if (found := peers[measure].outlier(mine, measure.least)) is not None:
                stands_out[measure] = found
            reference = measure.channel(catalog).reference
            if reference is not None and not is_inside(mine, reference):
                out_of_range[measure] = mine
        if (change := comparing.trend(car.values(measure.key), measure.least)) is not None:
            changes[measure] = change
    return CarFindings(car, stands_out, changes, out_of_range, tuple(_faults(car, catalog)))


def _faults(car: CarFigures, catalog: Catalog) -> Iterator[CarFault]:
    for code in sorted({code for reading in car.readings for code in reading.codes}):
        marks = tuple(code in reading.codes for reading in car.readings)
        times = [it.time for it, has in zip(car.readings, marks, strict=True) if has]
        yield CarFault(catalog.fault(code), times[0], times[-1], marks[-1], marks)
