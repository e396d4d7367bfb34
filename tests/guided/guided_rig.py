"""Rows of the virtual car as a tester reads them: raw data of §4, decoded, at a given rate."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from mikas.catalog import Catalog, shipped
from mikas.catalog.loading.source import parse_source
from mikas.guided.definition import GuidedTest
from mikas.guided.engine import TestEngine
from mikas.guided.result import TestResult
from mikas.virtual.cars import EngineCar
from mikas.virtual.model.engine import Engine
from mikas.virtual.scenarios.scenario import from_source

Row = tuple[float, dict[str, float]]


def car_rows(
    scenario: str, names: Iterable[str], seconds: float, rate: float, catalog: Catalog | None = None
) -> Iterator[Row]:
    """Yield rows of the car in the scenario, a file's text, while its ignition is on."""
    known = catalog or shipped()
    source = parse_source("car.toml", f"duration = 3600\n{scenario}".encode())
    car = EngineCar(Engine(from_source(source)), known)
    parameters = [known.parameter(name) for name in names]
    for number in range(int(seconds * rate)):
        time = number / rate
        if car.powered(time):
            yield time, {it.name: float(it.decode(car.raw(it.code, time))) for it in parameters}


def run(test: GuidedTest, rows: Iterable[Row], catalog: Catalog | None = None) -> TestResult | None:
    """Return the result of a test over rows; None if they end before it does."""
    engine = TestEngine(test, catalog or shipped())
    for time, values in rows:
        engine.add_row(time, values)
        if engine.result is not None:
            break
    return engine.result
