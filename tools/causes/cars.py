"""Draw virtual cars with known defects, their drivers and the weather; record their drives.

A car is drawn from a seed: the spread of a sound one (idle setting, meter ±8 %, sensor ±3 °C, a
little leak, a worn valve, a thin battery), one defect or two with amounts, a drive. The raw data
are kept as bytes, as the unit gives them, in `build/causes`, by what they depend on.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from pathlib import Path
from random import Random
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mikas.catalog import Catalog, Parameter, shipped
from mikas.catalog.loading.source import parse_source
from mikas.causes.rows import CHANNELS
from mikas.virtual.cars import EngineCar
from mikas.virtual.defects.car import WornCar
from mikas.virtual.defects.table import DEFECTS, SIDES, SOUND, DefectSide, Value
from mikas.virtual.model.engine import Engine
from mikas.virtual.scenarios.scenario import Scenario, from_source
from tools.causes.drives import drive_of

KEPT: Final = Path("build/causes")
Columns = Mapping[str, list[float]]


def name_of(side: DefectSide) -> str:
    """Return the name of a class: the key, and the direction where there are two."""
    both = len(DEFECTS[side.key].sides) > 1
    direction = "low" if side.most < side.sound else "high"
    if side.key == "throttle_stops":
        direction = "open" if side.most > side.sound else "short"
    return f"{side.key}-{direction}" if both else side.key


BY_NAME: Final = {name_of(side): side for side in SIDES}
_WINDOWS: Final = ("air_meter_loose", "throttle_dead")


@dataclass(frozen=True, slots=True)
class Car:
    """A car in its drive. `defects`: amounts by the names of defects; none: sound.

    `wear_seed`: of its wear and rate, if this is another drive of a car.
    """

    seed: int
    drive: str  # "mixed", "whole" (begins with a start), "idle", "warm-up", "start", "pull", "long"
    defects: Mapping[str, float] = field(default_factory=dict)
    wear_seed: int | None = None

    @property
    def origin(self) -> int:
        """The seed of the car itself."""
        return self.seed if self.wear_seed is None else self.wear_seed


def wear(random: Random) -> dict[str, float]:
    """Return the wear of a sound car: as adjustment and age leave it, seldom at the limits."""
    worn = {}
    for key, defect in DEFECTS.items():
        if defect.wear is None:
            continue
        low, high = defect.wear
        sound = SOUND[key]
        worn[key] = random.triangular(low, high, min(max(float(sound), low), high))
    return worn


def scenario_of(car: Car) -> Scenario:
    """Return the scenario of a car's drive."""
    random = Random(f"{car.origin} car")
    worn = wear(random)
    begin = random.uniform(2.0, 25.0)
    defects: dict[str, Value] = {}
    for name, amount in car.defects.items():
        side = BY_NAME[name]
        value = side.at(amount)
        value = min(max(value, min(side.sound, side.most)), max(side.sound, side.most))
        if side.key in _WINDOWS:
            defects[side.key] = (begin, begin + value - side.sound)
        elif side.interval is None:
            # Wear of the same part adds to the defect, as in a real one.
            limits = min(side.sound, side.most), max(side.sound, side.most)
            value += worn.get(side.key, side.sound) - side.sound
            defects[side.key] = min(max(value, limits[0]), limits[1])
        else:
            defects[side.key] = side.value(value)
    timeline, start = drive_of(car.drive, Random(f"{car.seed} drive"))
    plain = from_source(parse_source("car.toml", b"duration = 1\n"))
    return WornCar(defects, worn).applied_to(replace(plain, start=start, timeline=timeline))


@cache
def _catalog() -> Catalog:
    return shipped()


def raw_of(car: Car) -> tuple[NDArray[np.float64], NDArray[np.uint8], tuple[int, ...]]:
    """Return times, raw data (a row a reading) and the codes of the drive; kept on the disk."""
    scenario = scenario_of(car)
    random = Random(f"{car.origin} rate")
    rate = random.choice((2.5, 4.0, 5.0, 5.0, 7.0))
    text = f"{scenario.start} {scenario.condition} {scenario.timeline} {rate} {car.seed} {_model()}"
    path = KEPT / f"{hashlib.sha256(text.encode()).hexdigest()[:24]}.npz"
    if path.exists():
        with np.load(path) as kept:
            return kept["times"], kept["data"], tuple(kept["codes"].tolist())
    unit = EngineCar(Engine(scenario, car.seed % 1000), _catalog())
    codes = tuple(dict.fromkeys(_catalog().parameter(name).code for name in CHANNELS))
    times = np.arange(0.3, scenario.timeline.duration, 1 / rate)
    rows = [b"".join(unit.raw(code, float(time)) for code in codes) for time in times]
    data = np.frombuffer(b"".join(rows), np.uint8).reshape(len(rows), -1)
    KEPT.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(path, times=times, data=data, codes=np.array(codes))
    return times, data, codes


@cache
def _model() -> str:
    """Return a hash of the engine model."""
    files = sorted((Path(__file__).parents[2] / "src/mikas/virtual/model").glob("*.py"))
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


def columns_of(car: Car) -> tuple[list[float], dict[str, list[float]]]:
    """Return the times and columns of a car's drive, as a recording would have them."""
    times, data, codes = raw_of(car)
    columns: dict[str, list[float]] = {}
    place = 0
    for code in codes:
        parameters = _catalog().by_code(code)
        size = parameters[0].size
        for parameter in parameters:
            columns[parameter.name] = _decoded(parameter, data[:, place : place + size])
        place += size
    return times.tolist(), columns


def _decoded(parameter: Parameter, raw: NDArray[np.uint8]) -> list[float]:
    conversion = parameter.conversion
    number: NDArray[np.float64] = raw[:, 0].astype(float)
    if conversion.mask:
        number = ((raw[:, 0] & conversion.mask) != 0).astype(float)
        return [float(value) for value in number]
    if conversion.size == 2:
        number = number + 256.0 * raw[:, 1]
    elif conversion.signed:
        number = np.where(number > 127, number - 256, number)
    exact = (number * conversion.numerator + conversion.constant) / conversion.denominator
    return [float(value) for value in exact]


def training_cars() -> list[Car]:
    """Return the cars for weighing: sound ones, and each defect at many amounts."""
    cars = [Car(seed, _kind(seed)) for seed in range(460)]
    for number, defect in enumerate(BY_NAME):
        for index in range(34):
            seed = 10_000 + number * 1000 + index
            random = Random(f"{seed} amount")
            amount = random.uniform(0.35, 1.1) if index % 3 else random.uniform(1.0, 1.8)
            cars.append(Car(seed, _kind(index), {defect: round(amount, 3)}))
    return cars


def cars_with_each(drive: str, each: int, first: int, share: float = 1.0) -> list[Car]:
    """Return `each` cars of every defect at about `share` of a noticeable amount.

    `first`: the lowest of their seeds.
    """
    cars = []
    for number, defect in enumerate(BY_NAME):
        for index in range(each):
            seed = first + number * 1000 + index
            amount = share * Random(f"{seed} amount").uniform(0.9, 1.15)
            cars.append(Car(seed, drive, {defect: round(amount, 3)}))
    return cars


def sound_cars(count: int, first: int) -> list[Car]:
    """Return sound cars."""
    return [Car(seed, "whole") for seed in range(first, first + count)]


def pairs_of_defects(count: int, first: int) -> list[Car]:
    """Return cars with two defects of different keys, each noticeable."""
    cars = []
    for seed in range(first, first + count):
        random = Random(f"{seed} pair")
        one, other = random.sample(sorted(BY_NAME), 2)
        while BY_NAME[one].key == BY_NAME[other].key:
            other = random.choice(sorted(BY_NAME))
        cars.append(Car(seed, "whole", {one: 1.0, other: 1.0}))
    return cars


@dataclass(frozen=True, slots=True)
class Sets:
    """The cars on which the ranking is tried, by what is asked of it."""

    noticeable: Sequence[Car]
    half: Sequence[Car]
    idle: Sequence[Car]
    pairs: Sequence[Car]
    sound: Sequence[Car]
    curve: Sequence[Car] = ()  # at other amounts


def validation_sets() -> Sets:
    """Return the cars by which the constants of judging are chosen."""
    return Sets(
        noticeable=cars_with_each("whole", 3, 200_000),
        half=cars_with_each("whole", 3, 230_000, 0.5),
        idle=cars_with_each("idle", 2, 260_000),
        pairs=pairs_of_defects(40, 290_000),
        sound=sound_cars(220, 300_000),
    )


AMOUNTS: Final = (0.15, 0.3, 0.75, 1.3)
"""Shares of a noticeable amount at which cars are measured, besides a half and a whole."""


def measured_sets(*, quick: bool = False) -> Sets:
    """Return the cars that are measured; none is used for weighing or choosing."""
    each = partial(min, 1) if quick else int
    curve = [
        car
        for place, amount in enumerate(() if quick else AMOUNTS)
        for car in cars_with_each("whole", 4, 700_000 + 100 * place, amount)
    ]
    return Sets(
        noticeable=cars_with_each("whole", each(5), 500_000),
        half=cars_with_each("whole", each(4), 550_000, 0.5),
        idle=cars_with_each("idle", each(4), 600_000),
        pairs=pairs_of_defects(10 if quick else 60, 800_000),
        sound=sound_cars(20 if quick else 1000, 900_000),
        curve=curve,
    )


def _kind(index: int) -> str:
    return ("mixed", "mixed", "idle", "mixed", "mixed", "mixed", "warm-up")[index % 7]
