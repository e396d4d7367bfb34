"""Which recordings of a file are of one car, where some have nothing that says so."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import mikas
from merged_harness import needs_wireshark, ran, record
from mikas.errors import CaptureError
from mikas.recording import CaptureWriter
from mikas.recording.annotations.cars import PortSpan, cars_of
from mikas.recording.capture.reader import CaptureReader
from mikas.recording.splitting import cars_in, split
from mikas.recording.summary import summarise

ONE, TWO, THREE = "/dev/ttyUSB0", "/dev/ttyUSB1", "/dev/ttyUSB2"


def bare(path: Path, port: str, count: int = 20) -> Path:
    """Record a car without its unit, plate or name."""
    url = "sim:?clock=simulated&scenario=warm-idle"
    with CaptureWriter(path, url=port) as sink, mikas.connect(url, sink=sink) as ecu:
        for _ in ecu.watch("FREQ", method="batch", count=count):
            pass
    return path


def joined(out: Path, *files: Path) -> Path:
    out.write_bytes(b"".join(file.read_bytes() for file in files))
    return out


def recordings(path: Path) -> list[tuple[int, ...]]:
    return [car.recordings for car in cars_in(path)]


def test_unknown_recordings_of_two_ports_are_two_cars(tmp_path: Path) -> None:
    """They were one car's, and their values in one table."""
    files = [bare(tmp_path / f"{at}.pcapng", port) for at, port in enumerate((ONE, TWO, ONE))]
    path = joined(tmp_path / "all.pcapng", *files)
    assert recordings(path) == [(0, 2), (1,)]
    with pytest.raises(CaptureError, match=f"1: {ONE}, 2: {TWO}"):
        mikas.open(path)
    problem = summarise(path).problem
    assert problem is not None
    assert "mikas split" in problem.en
    first, second = [part for _, part in split(path, path)]
    assert first.read_bytes() == joined(tmp_path / "both", files[0], files[2]).read_bytes()
    assert second.read_bytes() == files[1].read_bytes()


@needs_wireshark
@pytest.mark.parametrize("arguments", [(), ("-a",)])
def test_unknown_recordings_of_two_ports_that_are_merged_are_two_cars(
    tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    files = [bare(tmp_path / f"{at}.pcapng", port) for at, port in enumerate((ONE, TWO))]
    path = tmp_path / "all.pcapng"
    ran("mergecap", *arguments, "-w", path, *files)
    assert recordings(path) == [(0,), (1,)]


def test_an_unknown_recording_is_of_the_only_car_of_its_port(tmp_path: Path) -> None:
    a = record(tmp_path / "a.pcapng", "A111AA52", port=ONE)
    a_elsewhere = record(tmp_path / "a2.pcapng", "A111AA52", port=TWO)
    b = record(tmp_path / "b.pcapng", "B222BB52", port=THREE)
    first, second = bare(tmp_path / "first.pcapng", ONE), bare(tmp_path / "second.pcapng", TWO)
    path = joined(tmp_path / "all.pcapng", first, a, b, a_elsewhere, second)
    assert recordings(path) == [(0, 1, 3, 4), (2,)]


def test_an_unknown_recording_is_of_none_of_two_cars_of_its_port(tmp_path: Path) -> None:
    """It was of the one that came first."""
    a = record(tmp_path / "a.pcapng", "A111AA52", port=ONE)
    b = record(tmp_path / "b.pcapng", "B222BB52", port=ONE)
    path = joined(tmp_path / "all.pcapng", bare(tmp_path / "it.pcapng", ONE), a, b)
    assert recordings(path) == [(0,), (1,), (2,)]


def test_an_unknown_recording_without_its_beginning_is_of_the_only_car(tmp_path: Path) -> None:
    begin, rest = bare(tmp_path / "it.pcapng", ONE), bare(tmp_path / "rest.pcapng", TWO)
    data = begin.read_bytes()
    for _ in range(2):  # the section and the port
        data = data[int.from_bytes(data[4:8], "little") :]
    headless = tmp_path / "headless.pcapng"
    headless.write_bytes(data)
    path = joined(tmp_path / "all.pcapng", headless, rest)
    assert recordings(path) == [(0, 1)]
    assert recordings(joined(tmp_path / "three.pcapng", headless, rest, begin)) == [
        (0,),
        (1,),
        (2,),
    ]


def test_units_that_say_the_same_on_two_ports_at_once_are_two_cars(tmp_path: Path) -> None:
    """Units with one program have one passport: the plate of one was the other's, too."""
    one = record(tmp_path / "one.pcapng", "", port=ONE)
    two = record(tmp_path / "two.pcapng", "", port=TWO)
    assert recordings(joined(tmp_path / "both.pcapng", one, two)) == [(0,), (1,)]
    assert recordings(joined(tmp_path / "again.pcapng", one, one)) == [(0, 1)]
    with pytest.raises(CaptureError, match="2 cars"):
        mikas.open(joined(tmp_path / "all.pcapng", one, two, one))


@pytest.mark.parametrize(("begin", "cars"), [(9.0, [(0,), (1,)]), (10.0, [(0, 1)])])
def test_the_same_unit_on_another_port_later_is_the_same_car(
    tmp_path: Path, begin: float, cars: list[tuple[int, ...]]
) -> None:
    notes = list(CaptureReader(record(tmp_path / "it.pcapng", "", port=ONE)).notes())
    later = [replace(note, recording=1) for note in notes]
    runs = {0: PortSpan(ONE, lambda: (0.0, 10.0)), 1: PortSpan(TWO, lambda: (begin, 20.0))}
    assert [car.recordings for car in cars_of([*notes, *later], runs)] == cars
