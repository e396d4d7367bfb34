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
from mikas.causes.weights import read
from tools.causes.cars import BY_NAME, Car, columns_of, training_cars, validation_sets
from tools.causes.choose import BEGINNING, chosen, figures, trials, usual_fits
from tools.causes.tables import FILES, texts
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


def write(processes: int) -> None:
    """Simulate the cars and write the tables."""
    cars = training_cars()
    examples = examples_of(cars, processes)
    weights = weigh(examples, list(BY_NAME))
    usual = usual_fits(examples, list(BY_NAME))
    sets = validation_sets()
    validation = {
        "noticeable": examples_of(sets.noticeable, processes),
        "half": examples_of(sets.half, processes),
        "idle": examples_of(sets.idle, processes),
        "pairs": examples_of(sets.pairs, processes),
        "sound": examples_of(sets.sound, processes),
    }
    tried = trials(validation, read(*texts(weights, usual, BEGINNING)), processes)
    constants = chosen(tried, usual)
    for name, figure in figures(tried, constants, usual).items():
        print(f"{name}: {figure:.1f} %")
    sound = sum(1 for car in cars if not car.defects)
    others = sum(len(several) for several in validation.values())
    header = (
        "Written by `make causes`; not by hand.",
        f"Constants of judging: chosen on {others} other cars.",
        f"{datetime.now(UTC):%Y-%m-%d}: {len(cars)} simulated cars, {sound} of them sound.",
    )
    for name, text in zip(FILES, texts(weights, usual, constants, header), strict=True):
        (FOLDER / name).write_text(text, "utf-8")
        print(FOLDER / name)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--processes", type=int, default=2)
    write(parser.parse_args().processes)
