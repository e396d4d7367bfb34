"""The cars of a file: which of its recordings are of one car.

Files are joined end to end (`cat`), or merged by other tools, and one car's drives stay one car's.
A plate says best whose a recording is, then the car's name, then the unit. Units of two cars may
say the same of themselves, but none is on two ports at once. A recording without all of these is
the only known car's that was on its port; else each port is a car of its own. One that has lost its
beginning, and so its port, is the only car's of the file.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from mikas.catalog import Catalog, shipped
from mikas.client.cars import CarDetails, plain_plate
from mikas.errors import CaptureError
from mikas.i18n import Text
from mikas.recording.annotations.events import RecordedUnit, car_of, unit_of
from mikas.recording.capture.notes import Note

_MOST_NAMED: Final = 10


@dataclass(frozen=True, slots=True)
class PortSpan:
    """Where and when a recording was made. `span`: gives the times of its first and last packet."""

    port: str
    span: Callable[[], tuple[float, float] | None] = lambda: None

    def excludes(self, other: PortSpan) -> bool:
        """Return whether both were made at the same time, on two ports."""
        if self.place == other.place:
            return False
        mine, others = self.span(), other.span()
        return bool(mine and others and mine[0] < others[1] and others[0] < mine[1])

    @property
    def place(self) -> str:
        """The port without its options, which may be others at another time."""
        return self.port.partition("?")[0]


@dataclass(frozen=True, slots=True)
class RecordedCar:
    """One car of a file. `recordings`: their numbers; `ports`: where it was, the first one first.

    The port of a recording that has lost its beginning is "".
    """

    recordings: tuple[int, ...]
    details: CarDetails
    unit: RecordedUnit | None
    ports: tuple[str, ...]

    @property
    def name(self) -> Text:
        """The car's name or plate; else the unit's model, or the port."""
        model = self.unit.model if self.unit else None
        words = self.details.name or (None if model else self.ports[0])
        if words is not None:
            return Text(words or "?", words or "?")
        return model or Text("?", "?")

    def is_same(self, other: RecordedCar, runs: Mapping[int, PortSpan]) -> bool:
        """Return whether both are recordings of one car, as far as they show it."""
        mine, others = self.details, other.details
        if mine.plate and others.plate:
            return plain_plate(mine.plate) == plain_plate(others.plate)
        if mine.car and others.car:
            return mine.car.casefold().split() == others.car.casefold().split()
        if self.unit is None or other.unit is None:
            return False
        if not self.unit.identity.may_be(other.unit.identity):
            return False
        if {*self.ports, *other.ports} == {self.ports[0]}:
            return True
        own = [runs[number] for number in self.recordings if number in runs]
        theirs = [runs[number] for number in other.recordings if number in runs]
        return not any(one.excludes(another) for one in own for another in theirs)

    @property
    def is_known(self) -> bool:
        """Whether anything says whose the recordings are."""
        return bool(self.details) or self.unit is not None

    def joined(self, other: RecordedCar) -> RecordedCar:
        """Return both as one car's; the latter's details count more."""
        numbers = tuple(sorted((*self.recordings, *other.recordings)))
        ports = tuple(dict.fromkeys((*self.ports, *other.ports)))
        unit = self.unit or other.unit
        return RecordedCar(numbers, other.details.over(self.details), unit, ports)


def cars_of(
    notes: Iterable[Note], runs: Mapping[int, PortSpan], catalog: Catalog | None = None
) -> list[RecordedCar]:
    """Return the cars of a file, in the order of their first recordings.

    `runs`: of each recording with packets, by its number.
    """
    by_recording: dict[int, list[Note]] = defaultdict(list)
    for note in notes:
        by_recording[note.recording].append(note)
    known: list[RecordedCar] = []
    unknown: dict[str, RecordedCar] = {}  # by port
    for number in sorted({*runs, *by_recording}):
        mine = by_recording[number]
        port = runs[number].place if number in runs else ""
        car = RecordedCar((number,), car_of(mine), unit_of(mine, catalog or shipped()), (port,))
        if not car.is_known:
            unknown[port] = unknown[port].joined(car) if port in unknown else car
            continue
        same = (at for at in range(len(known) - 1, -1, -1) if known[at].is_same(car, runs))
        at = next(same, None)
        if at is None:
            known.append(car)
        else:
            known[at] = known[at].joined(car)
    for port, car in sorted(unknown.items(), reverse=True):  # that of no port is the last
        there = [at for at, each in enumerate(known) if not port or port in each.ports]
        if len(there) == 1:
            known[there[0]] = known[there[0]].joined(car)
        else:
            known.append(car)
    return sorted(known, key=lambda car: car.recordings)


class SeveralCars(CaptureError):
    """A file holds the recordings of several cars, which are never read as one."""


def several(cars: Sequence[RecordedCar]) -> Text:
    """Return that a file holds several cars' recordings, and what to do."""
    named = [car.name for car in cars[:_MOST_NAMED]]
    more = "…" if len(cars) > _MOST_NAMED else ""
    en = ", ".join(f"{number}: {name.en}" for number, name in enumerate(named, 1)) + more
    ru = ", ".join(f"{number}: {name.ru}" for number, name in enumerate(named, 1)) + more
    return Text(
        f"it holds recordings of {len(cars)} cars ({en}); `mikas split` makes a file of each",
        f"в файле записи нескольких машин, их {len(cars)} ({ru}); `mikas split` делает из него по "
        "файлу на каждую",
    )
