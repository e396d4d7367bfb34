"""Draw virtual cars with known defects, their drivers and the weather; record their drives.

A car is drawn from a seed: the spread of a sound one (idle setting, meter ±8 %, sensor ±3 °C, a
little leak, a worn valve, a thin battery), one defect or two with amounts, a drive. The raw data of
all channels are kept as bytes, as the unit gives them, in `build/causes`, by what they depend on.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from random import Random
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mikas.catalog import Catalog, Parameter, shipped
from mikas.catalog.loading.source import parse_source
from mikas.virtual.cars import EngineCar
from mikas.virtual.defects.car import Car as WornCar
from mikas.virtual.defects.table import DEFECTS, SIDES, SOUND, Side, Value
from mikas.virtual.model.engine import Engine
from mikas.virtual.scenarios.scenario import Scenario, Start, from_source
from mikas.virtual.scenarios.timeline import ScenarioTimeline, Track

KEPT: Final = Path("build/causes")
Columns = Mapping[str, list[float]]


def name_of(side: Side) -> str:
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
    """A car in its drive. `defects`: amounts by the names of defects; none: sound."""

    seed: int
    drive: str  # "mixed", "whole" (begins with a start), "idle", "warm-up"
    defects: Mapping[str, float] = field(default_factory=dict)


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
    random = Random(f"{car.seed} car")
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


def drive_of(kind: str, random: Random) -> tuple[ScenarioTimeline, Start]:
    """Return a driver's actions and the car at second 0."""
    ambient = random.uniform(-15.0, 32.0)
    consumers = _steps(random, 900.0, lambda: random.choice((0, 0, 6, 12, 20, 28)))
    key = Track((0.0,), (1.0,), smooth=False)
    if kind == "idle":
        if random.random() < 0.6:
            start = _running(random, ambient)
            return _timeline(200.0, key, 0.0, consumers, [(0, 0.0)]), start
        coolant = random.uniform(70.0, 90.0)
        start = Start(ambient=ambient, coolant=coolant, coolant_at_start=coolant)
        return _timeline(200.0, key, random.uniform(2, 5), consumers, [(0, 0.0)]), start
    if kind == "warm-up":
        start = Start(ambient=ambient, coolant=ambient, coolant_at_start=ambient)
        return _timeline(600.0, key, random.uniform(2, 5), consumers, [(0, 0.0)]), start
    turn = random.random()
    begin, starter = 0.0, 0.0
    if kind == "whole":  # with the start of the engine
        turn *= 0.75
    if turn < 0.45:
        start = Start(ambient=ambient, coolant=ambient, coolant_at_start=ambient)
    elif turn < 0.75:
        coolant = random.uniform(45.0, 88.0)
        start = Start(ambient=ambient, coolant=coolant, coolant_at_start=coolant)
    else:
        start = _running(random, ambient)
    if not start.running:
        starter = random.uniform(2.0, 5.0)
        begin = starter + random.uniform(12.0, 60.0)
    speed = _journey(random, begin, random.uniform(680.0, 800.0))
    return _timeline(speed[-1][0] + random.uniform(30, 60), key, starter, consumers, speed), start


def _running(random: Random, ambient: float) -> Start:
    return Start(ambient=ambient, coolant=random.uniform(80.0, 91.0), coolant_at_start=ambient,
                 running=True)  # fmt: skip


def _timeline(
    duration: float, key: Track, starter: float, consumers: Track, speed: list[tuple[float, float]]
) -> ScenarioTimeline:
    turning = (0.0, starter, starter + 7.0) if starter else (0.0,)
    return ScenarioTimeline(
        duration=duration, loops=False, loop_from=0.0, key=key,
        starter=Track(turning, (0.0, 1.0, 0.0)[: len(turning)], smooth=False),
        load=Track((0.0,), (0.0,), smooth=False), consumers=consumers,
        speed=Track(tuple(t for t, _ in speed), tuple(v for _, v in speed)),
    )  # fmt: skip


def _steps(random: Random, seconds: float, draw: Callable[[], float]) -> Track:
    times, time = [0.0], 0.0
    while time < seconds:
        time += random.uniform(40.0, 250.0)
        times.append(time)
    return Track(tuple(times), tuple(float(draw()) for _ in times), smooth=False)


def _journey(random: Random, begin: float, end: float) -> list[tuple[float, float]]:
    """Return speeds over time: lights, streets and an open road, ridden calmly or hard."""
    temper = random.uniform(0.6, 1.5)
    points = [(0.0, 0.0), (begin + 0.1, 0.0)]
    time, now = begin + 0.1, 0.0
    open_road = random.uniform(0.2, 0.7)
    while time < end:
        here = random.random()
        if here < 0.3 and now > 0:
            goal, stay = 0.0, random.uniform(6.0, 40.0)
        elif here < 0.3 + open_road * 0.5:
            goal, stay = random.uniform(70.0, 115.0), random.uniform(15.0, 60.0)
        else:
            goal, stay = random.uniform(20.0, 62.0), random.uniform(8.0, 30.0)
        rate = temper * (random.uniform(2.0, 4.0) if goal > now else random.uniform(3.0, 7.0))
        if goal > now + 15 and random.random() < 0.3:
            rate = random.uniform(9.0, 20.0)  # km/h a second: the pedal to the floor
        time += max(2.0, abs(goal - now) / rate)
        points += [(time, goal), (time + stay, goal)]
        time, now = time + stay, goal
    if now:
        time += now / 5.0 + 2.0
        points.append((time, 0.0))
    return [*points, (time + random.uniform(40.0, 90.0), 0.0)]


@cache
def _catalog() -> Catalog:
    return shipped()


def raw_of(car: Car) -> tuple[NDArray[np.float64], NDArray[np.uint8], tuple[int, ...]]:
    """Return times, raw data (a row a reading) and the codes of the drive; kept on the disk."""
    scenario = scenario_of(car)
    random = Random(f"{car.seed} rate")
    rate = random.choice((2.5, 4.0, 5.0, 5.0, 7.0))
    text = f"{scenario.start} {scenario.condition} {scenario.timeline} {rate} {car.seed} {_model()}"
    path = KEPT / f"{hashlib.sha256(text.encode()).hexdigest()[:24]}.npz"
    if path.exists():
        with np.load(path) as kept:
            return kept["times"], kept["data"], tuple(kept["codes"].tolist())
    unit = EngineCar(Engine(scenario, car.seed % 1000), _catalog())
    times = np.arange(0.3, scenario.timeline.duration, 1 / rate)
    rows = [b"".join(unit.raw(code, float(time)) for code in unit.codes) for time in times]
    data = np.frombuffer(b"".join(rows), np.uint8).reshape(len(rows), -1)
    KEPT.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(path, times=times, data=data, codes=np.array(unit.codes))
    return times, data, unit.codes


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
        for index in range(38):
            seed = 10_000 + number * 1000 + index
            random = Random(f"{seed} amount")
            amount = random.uniform(0.4, 1.1) if index % 3 else random.uniform(1.0, 1.8)
            cars.append(Car(seed, _kind(index), {defect: round(amount, 3)}))
    return cars


def measured_cars(drive: str, each: int, first: int, share: float = 1.0) -> list[Car]:
    """Return `each` cars of every defect at about `share` of a noticeable amount.

    `first`: the lowest of their seeds, none of which is used for weighing.
    """
    cars = []
    for number, defect in enumerate(BY_NAME):
        for index in range(each):
            seed = first + number * 1000 + index
            amount = share * Random(f"{seed} amount").uniform(0.9, 1.15)
            cars.append(Car(seed, drive, {defect: round(amount, 3)}))
    return cars


def sound_cars(count: int, first: int = 900_000) -> list[Car]:
    """Return sound cars, of seeds that are not used for weighing."""
    return [Car(seed, "whole") for seed in range(first, first + count)]


def pairs_of_defects(count: int, first: int = 800_000) -> list[Car]:
    """Return cars with two defects of different keys, each noticeable."""
    cars = []
    for seed in range(first, first + count):
        random = Random(f"{seed} pair")
        one, other = random.sample(sorted(BY_NAME), 2)
        while BY_NAME[one].key == BY_NAME[other].key:
            other = random.choice(sorted(BY_NAME))
        cars.append(Car(seed, "whole", {one: 1.0, other: 1.0}))
    return cars


def _kind(index: int) -> str:
    return ("mixed", "mixed", "idle", "mixed", "mixed", "mixed", "warm-up")[index % 7]
