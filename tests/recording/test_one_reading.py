"""What is made of a recording reads its file once, and holds it for what is made next.

Two searches go over the file before that: for what other tools have done to it
(`capture/edited`), and for changes of the computer's date, which hold for what is before them.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from bench.recorded import recorded
from crafted_harness import counted

import mikas
from mikas.catalog import shipped
from mikas.dashboard.library.folder import RecordingFolder
from mikas.dashboard.library.service import RecordingService, References
from mikas.fleet.interpreting import InterpretingSettings, interpret
from mikas.guided.loading import load as load_tests
from mikas.guided.recorded import run_over
from mikas.recording.export import export
from mikas.recording.recorded_faults import faults_in
from mikas.recording.recording import Recording
from mikas.recording.search import SearchCondition, search
from mikas.recording.table import raw_recording
from mikas.replay import load
from mikas.report.from_recording import find_in_recording

WINDOW = 1 << 16  # bytes that are read at the begin and at each note


@pytest.fixture(scope="module")
def drive(tmp_path_factory) -> Path:
    return recorded(tmp_path_factory.mktemp("drive") / "drive.pcapng", 0.1, lap=60)


def exported(recording: Recording, out: Path) -> None:
    about, events = recording.about, recording.events
    export(out, recording.channels, recording.rows(), events=events, about=about)


def compared(path: Path, folder: Path) -> None:
    for interpretation in ("corrected", "literal"):
        (made := folder / interpretation).mkdir()
        interpret(path, path.name, "ab" * 16, InterpretingSettings(shipped(), interpretation), made)


CONSUMERS: dict[str, tuple[Callable[[Path, Path], object], int]] = {
    "csv": (lambda path, to: exported(mikas.open(path), to / "a.csv"), 1),
    "literal": (
        lambda path, to: exported(mikas.open(path, interpretation="literal"), to / "a.parquet"),
        1,
    ),
    "report": (lambda path, _: find_in_recording(mikas.open(path)), 1),
    "fleet, twice": (compared, 2),
    "faults": (lambda path, _: faults_in(mikas.open(path)), 1),
    "find": (
        lambda path, _: search(mikas.open(path), SearchCondition(shipped(), "FUEL_FLOW > 3")),
        1,
    ),
    "guided tests": (
        lambda path, _: [
            run_over(test, recording, [step.name for step in test.steps])
            for recording in [mikas.open(path)]
            for test in load_tests(shipped()).tests.values()
        ],
        1,
    ),
    "replay": (lambda path, _: load(path), 1),
}


@pytest.mark.parametrize(("consumer", "times"), CONSUMERS.values(), ids=CONSUMERS)
def test_the_file_is_opened_once_and_read_once(drive, tmp_path, consumer, times):
    with counted(drive) as files:
        consumer(drive, tmp_path)
    assert len(files) == times
    size = drive.stat().st_size
    searches = 2 * size * (1 + 64 / WINDOW)  # each window overlaps the next by 64 bytes
    most = searches + size + WINDOW * (3 + len(mikas.open(drive).notes))
    assert sum(file.taken for file in files) <= times * most < times * 4 * size


def test_the_dashboard_makes_everything_of_the_recording_that_it_has_opened(drive, tmp_path):
    references = References(tmp_path / "marks", tmp_path / "virtual")
    library = RecordingService(
        RecordingFolder(drive.parent), references, shipped(), "corrected",
        clock=lambda: 0.0, in_progress=lambda: None,
    )  # fmt: skip
    file = library.folder.one(drive.name)
    with counted(drive) as files:
        assert library.opened(file).window(0, 2e9)[0].values
        exported(library.opened(file, latest=True).interpreted("literal"), tmp_path / "a.csv")
        assert find_in_recording(library.opened(file, latest=True)).measured.rows
        faults_in(library.opened(file))
    assert len(files) == 1


def test_a_recording_too_long_to_be_held_is_read_again_with_the_same_rows(drive, monkeypatch):
    held = Recording(drive, shipped(), "literal")
    monkeypatch.setattr(raw_recording, "_MOST_HELD", 1 << 16)
    again = Recording(drive, shipped(), "literal")
    for one, other in zip(held.stretches(), again.stretches(), strict=True):
        assert one[0] == other[0]
        assert one[1].times.tobytes() == other[1].times.tobytes()
        for name, column in one[1].values.items():
            assert column.tobytes() == other[1].values[name].tobytes()
    assert held.row_count == again.row_count > 0
    assert held.span == again.span
