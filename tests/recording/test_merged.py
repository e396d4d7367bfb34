"""Files that other tools merged: what belongs to a port or a section stays with it."""

from __future__ import annotations

from pathlib import Path

import pytest

import mikas
from merged_harness import MERGES, merged, needs_wireshark, ran, record, shifted
from mikas.errors import CaptureError
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.reader import CaptureReader, Problem
from mikas.recording.capture.scan import RawBlock, scan
from mikas.recording.recording import Recording
from mikas.recording.splitting import cars_in, split
from mikas.recording.summary import summarise
from mikas.replay.build import load
from mikas.report.from_recording import find_in_recording

pytestmark = needs_wireshark
ONE, TWO = "A111AA52", "B222BB52"


@pytest.fixture(params=[True, False], ids=["notes first", "packets first"])
def both(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Path, Path]:
    head = request.param
    one = record(tmp_path / "one.pcapng", ONE, version=9, port="/dev/ttyUSB0", head=head)
    two = record(
        tmp_path / "two.pcapng", TWO, faults="53", port="/dev/ttyUSB1", count=60, head=head
    )
    return one, two


def values(path: Path) -> list[tuple[float, float]]:
    frame = mikas.open(path).to_pandas()
    return [(round(at, 6), value) for at, value in zip(frame.index, frame["FREQ"], strict=True)]


@pytest.mark.parametrize("how", MERGES)
def test_plate_model_and_faults_are_of_one_car(tmp_path: Path, both, how: str) -> None:
    """The report had the plate of one car, the model of the other, and no faults."""
    path = merged(how, tmp_path / "merged.pcapng", *both)
    recording = Recording(path, mikas.open(both[0]).catalog, last_car=True)
    assert [car.details.plate for car in recording.raw.cars] == [ONE, TWO]
    assert not recording.problems
    subject = find_in_recording(recording).subject
    assert subject.unit is not None
    assert (subject.car.plate, subject.unit.model.text.en) == (TWO, "Mikas 7.1")
    assert [fault.code for fault in subject.faults or ()] == [53]
    assert [car.en for car in subject.conditions.cars] == [ONE, TWO]


@pytest.mark.parametrize("how", MERGES)
def test_what_was_merged_is_split_into_the_same(tmp_path: Path, both, how: str) -> None:
    path = merged(how, tmp_path / "merged.pcapng", *both)
    parts = [part for _, part in split(path, path)]
    assert [part.name for part in parts] == ["merged-1.pcapng", "merged-2.pcapng"]
    for part, file in zip(parts, both, strict=True):
        assert values(part) == values(file)
        wanted, found = mikas.open(file), mikas.open(part)
        assert found.unit is not None
        assert found.unit == wanted.unit
        assert found.raw.notes == wanted.raw.notes
        assert [(it.direction, it.data, it.time) for it in CaptureReader(part)] == [
            (it.direction, it.data, it.time) for it in CaptureReader(file)
        ]


@pytest.mark.parametrize("how", MERGES)
def test_no_reader_mixes_two_cars(tmp_path: Path, both, how: str) -> None:
    path = merged(how, tmp_path / "merged.pcapng", *both)
    for read in (mikas.open, load):
        with pytest.raises(CaptureError, match="mikas split") as refused:
            read(path)
        assert ONE in str(refused.value)
        assert TWO in str(refused.value)
    problem = summarise(path).problem
    assert problem is not None
    assert f"1: {ONE}, 2: {TWO}" in problem.en


def test_two_drives_of_a_car_stay_one(tmp_path: Path) -> None:
    one = record(tmp_path / "one.pcapng", ONE, port="/dev/ttyUSB0")
    later = record(tmp_path / "later.pcapng", ONE, port="/dev/ttyUSB3")
    for how in MERGES:
        path = merged(how, tmp_path / f"{how}.pcapng", one, later)
        assert len(cars_in(path)) == 1
        assert len(mikas.open(path).to_pandas()) == 2 * len(values(one)), how


@pytest.mark.parametrize("arguments", [(), ("-a",), ("-I", "none"), ("-I", "any")])
def test_cars_on_ports_of_one_name_are_kept_apart(tmp_path: Path, arguments) -> None:
    """Recorded one after the other; `mergecap` makes one interface of both."""
    one = record(tmp_path / "one.pcapng", ONE, version=9, port="/dev/ttyUSB0")
    two = record(tmp_path / "two.pcapng", TWO, faults="53", port="/dev/ttyUSB0")
    later = shifted(two, tmp_path / "later.pcapng", 100)
    path = tmp_path / "merged.pcapng"
    ran("mergecap", *arguments, "-w", path, later, one)
    parts = sorted(
        (part for _, part in split(path, path)), key=lambda part: mikas.open(part).span or ()
    )
    assert [mikas.open(part).unit for part in parts] == [mikas.open(it).unit for it in (one, two)]
    assert [values(part) for part in parts] == [values(one), values(two)]


def test_cars_mixed_in_one_port_are_not_read(tmp_path: Path) -> None:
    """Nothing says whose a packet is: two computers have recorded on ports of one name."""
    one = record(tmp_path / "one.pcapng", ONE, version=9, port="/dev/ttyUSB0")
    two = record(tmp_path / "two.pcapng", TWO, faults="53", port="/dev/ttyUSB0")
    path = merged("mergecap", tmp_path / "merged.pcapng", one, two)
    items = list(CaptureReader(path))
    assert [type(item) for item in items] == [Problem]
    assert "mergecap -I none" in items[0].text.en
    assert [car.details.plate for car in cars_in(merged(MERGES[3], path, one, two))] == [ONE, TWO]


def test_notes_without_their_place_are_left_out_and_named(tmp_path: Path, both) -> None:
    """`reordercap` puts all notes in front of all packets."""
    path = merged("mergecap", tmp_path / "merged.pcapng", *both)
    ran("reordercap", path, tmp_path / "ordered.pcapng")
    if mikas.open(both[0]).notes[0].offset < 200:  # the notes were in front
        assert len(cars_in(tmp_path / "ordered.pcapng")) == 2
        return
    recording = Recording(tmp_path / "ordered.pcapng", mikas.open(both[0]).catalog, last_car=True)
    assert not recording.notes
    assert "notes (6) are left out" in recording.problems[-1].text.en


@pytest.mark.parametrize("how", MERGES)
def test_damage_in_a_merged_file_costs_no_other_values(tmp_path: Path, both, how: str) -> None:
    path = merged(how, tmp_path / "merged.pcapng", *both)
    with path.open("rb") as file:
        packets = [
            it for it in scan(file) if isinstance(it, RawBlock) and it.kind == pcapng.ENHANCED
        ]
    data = bytearray(path.read_bytes())
    spoilt = packets[len(packets) // 2]
    data[spoilt.offset + 4 : spoilt.offset + 8] = b"\xff" * 4
    path.write_bytes(bytes(data[: packets[-1].offset + 10]))
    for part, file in zip([part for _, part in split(path, path)], both, strict=True):
        assert set(values(part)) <= set(values(file))
        assert values(part)
    assert any(
        "unfinished packet" in it.text.en for it in CaptureReader(path) if isinstance(it, Problem)
    )
