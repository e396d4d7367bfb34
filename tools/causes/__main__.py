"""Simulate cars, weigh what speaks for each cause, write the tables: `make causes`.

python -m tools.causes [--processes N]     an hour on two cores; what was simulated is kept
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from datetime import UTC, datetime
from pathlib import Path

from mikas.causes.features import View, context_of, features_of
from mikas.causes.regimes import drive_of
from mikas.causes.samples import samples_of
from tools.causes.cars import BY_NAME, Car, columns_of, training_cars
from tools.causes.tables import texts
from tools.causes.weigh import Example, weigh

FOLDER = Path(__file__).parents[2] / "src/mikas/causes/weights"


def example_of(car: Car) -> Example:
    """Return the features of a car in its drive."""
    drive = drive_of(samples_of(*columns_of(car)))
    if drive is None:
        raise AssertionError("a drive has the engine's speed")
    values = {name: seen.value for name, seen in features_of(drive).items()}
    return Example(car.defects, values, context_of(View(drive)))


def examples_of(cars: Sequence[Car], processes: int) -> list[Example]:
    """Return the features of these cars, simulated in parallel."""
    with ProcessPoolExecutor(processes) as pool:
        return list(pool.map(example_of, cars, chunksize=4))


def write(cars: Sequence[Car], processes: int) -> None:
    """Write the tables of these cars."""
    weights = weigh(examples_of(cars, processes), list(BY_NAME))
    sound = sum(1 for car in cars if not car.defects)
    header = (
        "Written by `make causes`; not by hand.",
        f"{datetime.now(UTC):%Y-%m-%d}: {len(cars)} simulated cars, {sound} of them sound.",
    )
    names = "features.csv", "causes.csv", "correlations.csv"
    for name, text in zip(names, texts(weights, header), strict=True):
        (FOLDER / name).write_text(text, "utf-8")
        print(FOLDER / name)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--processes", type=int, default=2)
    write(training_cars(), parser.parse_args().processes)
