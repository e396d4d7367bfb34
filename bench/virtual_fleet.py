"""Recordings of a virtual fleet: each drive is one of the engine model, with its car's defects.

The bytes on the line are computed, not sampled over a simulated wire: a recording of half an hour
is made in seconds. Also for the tests of `mikas fleet`, and for its pictures.

python -m bench.virtual_fleet FOLDER     the ten cars of the documentation, twelve drives each
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from random import Random
from typing import Final

from mikas.catalog import Catalog, shipped
from mikas.catalog.loading.source import parse_source
from mikas.client import Passport
from mikas.client.cars import CarDetails
from mikas.commands import Datum, ReadFaults, ReadParameters
from mikas.framing import encode
from mikas.i18n import Text
from mikas.link.base import Direction
from mikas.recording.annotations.events import car_note, catalog_note, note_of
from mikas.recording.capture.writer import CaptureWriter
from mikas.sampling.events import Gap, UnitFound
from mikas.virtual.cars import EngineCar
from mikas.virtual.model.engine import Engine
from mikas.virtual.scenarios.scenario import from_source

BYTE: Final = 10 / 9600
NAMES: Final = (
    "TWAT", "FREQ", "FREQX", "UOZ", "UACC", "INJ", "JAIR", "THR", "RXX", "SSM", "FSM", "TAIR",
)  # fmt: skip
BEGAN: Final = datetime(2026, 3, 2, 7, 30, tzinfo=UTC).timestamp()
DAY: Final = 86_400.0
IDLE: Final = """
duration = 7200
[start]
ambient = {ambient}
coolant = 84
running = true
[timeline]
throttle = 0
gear = 0
[condition]
{condition}
"""
DRIVE: Final = """
duration = 7200
[start]
ambient = {ambient}
coolant = {coolant}
[timeline]
key = 1
starter = [[0, 0], [2, 1], [8, 0]]
gear = [[0, 0], [60, 0], [61, 4], [{leave}, 4], [{stop}, 0]]
speed = [[0, 0], [60, 0], [90, 60], [{leave}, 60], [{stop}, 0]]
[condition]
{condition}
"""


@dataclass(frozen=True, slots=True)
class Drive:
    """One recording. `began`: UNIX time; `condition`: lines of the scenario's; `faults`: stored."""

    began: float
    seconds: float = 1500.0
    ambient: float = 12.0
    condition: Mapping[str, float] = field(default_factory=dict)
    faults: Sequence[int] = ()
    plate: str = ""
    car: str = ""
    mileage: int | None = None
    passport: tuple[str, ...] = ("МИКАС 7.1", "241.3763", "", "2000.09.27", "", "", "", "")
    rate: float = 1.0
    gap: tuple[float, float] | None = None  # s from its begin
    names: Sequence[str] = NAMES
    warm: bool = False  # it idles all the time, warm from the first second on
    seed: int = 0


def record(path: Path, drive: Drive, catalog: Catalog | None = None) -> None:
    """Write the recording of a drive."""
    known = catalog or shipped()
    data = [Datum(known.parameter(n).code, known.parameter(n).size) for n in drive.names]
    request = ReadParameters(tuple(dict.fromkeys(data)))
    answers = _answers(replace(drive, began=0.0, gap=None, plate="", car="", mileage=None), request)
    details = CarDetails(drive.car, drive.plate, drive.mileage, "")
    program, calibration = drive.passport[:3], drive.passport[3:]
    unit = UnitFound(
        drive.began, 0x0A, Passport(program, calibration), adapter="FT232", echo=True,
        catalog=known.version,
    )  # fmt: skip
    with CaptureWriter(path, url="/dev/ttyUSB0") as writer:
        writer.note(note_of(unit))
        writer.note(catalog_note(drive.began, known.version))
        if details:
            writer.note(car_note(drive.began, details))
        faults = ReadFaults()
        _exchange(writer, faults.body(), faults.respond(tuple(drive.faults)), drive.began)
        for number in range(1, int(drive.seconds * drive.rate)):
            since = number / drive.rate
            if drive.gap is None or not drive.gap[0] <= since < drive.gap[1]:
                answer = answers[number - 1]
                _exchange(writer, request.body(), answer, drive.began + since)
        if drive.gap is not None:
            first, last = (drive.began + each for each in drive.gap)
            writer.note(note_of(Gap(last, first, last, Text("no echo", "нет эха"))))


def _answers(drive: Drive, request: ReadParameters) -> list[bytes]:
    """Return the car's answers, one after the other; of a drive that was made before, the same."""
    if (key := repr(drive)) not in _made:
        condition = "\n".join(f"{name} = {value}" for name, value in drive.condition.items())
        leave = max(100.0, drive.seconds - 150)
        text = (IDLE if drive.warm else DRIVE).format(
            ambient=drive.ambient, coolant=drive.ambient, leave=leave, stop=leave + 25,
            condition=condition,
        )  # fmt: skip
        engine = Engine(from_source(parse_source("car.toml", text.encode())), drive.seed)
        car = EngineCar(engine, shipped(), faults=drive.faults)
        times = (number / drive.rate for number in range(1, int(drive.seconds * drive.rate)))
        _made[key] = [
            b"".join(car.raw(it.code, time) for it in request.parameters) for time in times
        ]
    return _made[key]


_made: dict[str, list[bytes]] = {}


def _exchange(writer: CaptureWriter, request: bytes, answer: bytes, time: float) -> None:
    wire = encode(request)
    writer.record(Direction.SENT, wire, time)
    begin = time + len(wire) * BYTE + 0.002
    writer.record(Direction.RECEIVED, wire + encode(answer), begin)


@dataclass(frozen=True, slots=True)
class VirtualCar:
    """A car of the fleet. `wear`: what changes from its first drive to its last, each from … to."""

    plate: str
    name: str
    condition: Mapping[str, float] = field(default_factory=dict)
    wear: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    faults: Mapping[int, tuple[int, int]] = field(default_factory=dict)  # by drives, from … to

    def drives(self, count: int, seconds: float = 1500.0) -> Iterator[Drive]:
        """Yield its drives, one every five days, at temperatures that differ."""
        random = Random(self.plate)
        for number in range(count):
            share = number / max(1, count - 1)
            worn = {name: a + share * (b - a) for name, (a, b) in self.wear.items()}
            began = BEGAN + number * 5 * DAY + random.uniform(0, 8 * 3600)
            stored = [code for code, (a, b) in self.faults.items() if a <= number < b]
            yield Drive(
                began, seconds, random.uniform(4, 20), {**self.condition, **worn}, stored,
                self.plate, self.name, 100_000 + number * 700, seed=random.randrange(10_000),
            )  # fmt: skip


FLEET: Final = (
    VirtualCar("А101МР52", "ГАЗ-3110"),
    VirtualCar("А102МР52", "ГАЗ-3110"),
    VirtualCar("А103МР52", "ГАЗ-3110", condition={"thermostat": 0.6}),
    VirtualCar("А104МР52", "ГАЗель"),
    VirtualCar("А105МР52", "ГАЗель", condition={"alternator": 0.5}),
    VirtualCar("А106МР52", "ГАЗель", wear={"idle_passage": (1.0, 0.45)}),
    VirtualCar("А107МР52", "ГАЗель", faults={17: (8, 12)}),
    VirtualCar("А108МР52", "ГАЗель", condition={"air_meter": 0.72}),
    VirtualCar("А109МР52", "ГАЗ-3110"),
    VirtualCar("А110МР52", "ГАЗ-3110"),
)
"""Ten cars: five are sound, one has a fault stored since its ninth drive, four have a defect."""


def make(folder: Path, cars: Iterable[VirtualCar] = FLEET, drives: int = 12) -> list[Path]:
    """Write the recordings of a fleet, a folder for each car; return them."""
    made = []
    for car in cars:
        home = folder / car.plate
        home.mkdir(parents=True, exist_ok=True)
        for drive in car.drives(drives):
            at = datetime(1970, 1, 1, tzinfo=UTC) + timedelta(seconds=drive.began)
            made.append(home / f"{at:%Y-%m-%d %H-%M}.pcapng")
            record(made[-1], drive)
    return made


if __name__ == "__main__":
    print(len(make(Path(sys.argv[1]))), "recordings")
