"""Any recordings, merged in any way: nothing of one car is another's, and nothing is lost."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from itertools import count
from pathlib import Path
from typing import NamedTuple

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import mikas
from merged_harness import MERGES, merged, needs_wireshark, record, shifted
from mikas.link.base import Direction
from mikas.recording.capture.reader import CaptureReader, Packet, Problem
from mikas.recording.splitting import cars_in, split
from mikas.report.from_recording import find_in_recording

PORTS = ("/dev/ttyUSB0", "/dev/ttyUSB1")
GRID = 11e-6  # s; the time of a packet shows its recording


class Car(NamedTuple):
    """A car of which all is different from the others, but for a model."""

    plate: str
    version: int
    faults: str
    model: str


CARS = (
    Car("A111AA52", 9, "", "Mikas 5.4"),
    Car("B222BB52", 10, "53", "Mikas 7.1"),
    Car("C333CC52", 9, "13", "Mikas 5.4"),
)
Line = set[tuple[Direction, bytes, float]]


class Drive(NamedTuple):
    """A recording to be merged. `begin`: s."""

    car: Car
    port: str
    head: bool
    begin: float


drives = st.lists(
    st.builds(
        Drive,
        st.sampled_from(CARS),
        st.sampled_from(PORTS),
        st.booleans(),
        st.sampled_from([0.0, 0.4, 30.0, 3600.0]),
    ),
    min_size=2,
    max_size=3,
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("merged")


@pytest.fixture(scope="module")
def names() -> Iterator[int]:
    return count()


@cache
def recorded(folder: Path, drive: Drive) -> Path:
    car, port, head, _ = drive
    path = folder / f"{car.plate}-{PORTS.index(port)}-{head}.pcapng"
    return record(
        path, car.plate, version=car.version, faults=car.faults, port=port, head=head, count=8
    )


def made(folder: Path, name: str, drawn: list[Drive]) -> list[Path]:
    """Return the recordings; those of one car do not overlap."""
    files = []
    for number, drive in enumerate(drawn):
        plain = recorded(folder, drive._replace(begin=0.0))
        later = 1000.0 * [it.car for it in drawn[:number]].count(drive.car)
        seconds = drive.begin + later + number * GRID
        files.append(shifted(plain, folder / f"{name}-{number}.pcapng", seconds))
    return files


def packets(path: Path) -> Line:
    return {
        (it.direction, it.data, round(it.time, 6))
        for it in CaptureReader(path)
        if isinstance(it, Packet)
    }


def problems(path: Path) -> list[str]:
    return [it.text.en for it in CaptureReader(path) if isinstance(it, Problem)]


def parts_of(path: Path) -> list[Path]:
    return [part for _, part in split(path, path)] if len(cars_in(path)) > 1 else [path]


def check(part: Path, lines: dict[Car, Line]) -> Line:
    """Let all of a part be of one car; return its packets."""
    found = packets(part)
    owners = [car for car, line in lines.items() if line & found]
    assert len(owners) <= 1
    if not owners:
        return found
    (car,) = owners
    subject = find_in_recording(mikas.open(part)).subject
    assert subject.car.plate in ("", car.plate)
    if subject.unit is not None:
        assert subject.unit.model.text.en == car.model
    if subject.faults is not None:
        assert [str(it.code) for it in subject.faults] == [it for it in [car.faults] if it]
    return found


@needs_wireshark
@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(drawn=drives, how=st.sampled_from(MERGES))
@example(  # the notes of B in front may be of either port that begins then
    [
        Drive(CARS[0], PORTS[0], False, 0.0),
        Drive(CARS[0], PORTS[1], False, 0.0),
        Drive(CARS[1], PORTS[0], True, 0.0),
    ],
    "mergecap",
)
@example(  # one port of three recordings: two overlap, two have their notes in front
    [
        Drive(CARS[0], PORTS[1], False, 0.0),
        Drive(CARS[0], PORTS[1], True, 0.0),
        Drive(CARS[1], PORTS[1], True, 0.0),
    ],
    "mergecap",
)
@example(  # the largest step is between the recordings of one car
    [
        Drive(CARS[1], PORTS[1], False, 3600.0),
        Drive(CARS[1], PORTS[1], True, 0.0),
        Drive(CARS[0], PORTS[1], False, 0.0),
    ],
    "mergecap -a",
)
def test_nothing_of_a_car_is_given_to_another(folder: Path, names, drawn, how: str) -> None:
    name = f"{next(names)}"
    files = made(folder, name, drawn)
    lines: dict[Car, Line] = {}
    for drive, file in zip(drawn, files, strict=True):
        lines[drive.car] = lines.get(drive.car, set()) | packets(file)
    assert sum(map(len, lines.values())) == len(set().union(*lines.values()))
    path = merged(how, folder / f"{name}-merged.pcapng", *files)
    parts = parts_of(path)
    found = [check(part, lines) for part in parts]
    everything = set().union(*lines.values())
    mixed = any("lie mixed in one port" in it for it in problems(path))
    assert set().union(*found) == everything or mixed
    assert set().union(*found) <= everything
    assert sum(map(len, found)) == len(set().union(*found))
