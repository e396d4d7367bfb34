"""The figures of the fleet's report: which readings of the faults are a car's."""

from __future__ import annotations

from datetime import datetime, timedelta

from fleet_rig import BEGAN, DAY, add_here, make
from mikas.catalog import shipped
from mikas.fleet.query.database import opened
from mikas.fleet.report.figures import CarFigures, figures
from mikas.fleet.report.findings import find
from mikas.fleet.report.sentences import remarks
from mikas.recording.annotations.events import faults_note
from mikas.recording.capture.writer import append_note
from mikas.sampling.events import FaultReading

NOW = datetime(2026, 6, 1)


def only_car(dataset) -> CarFigures:
    with opened(str(dataset)) as database:
        (car,) = figures(database, shipped(), NOW).cars
    return car


def test_a_reading_without_a_date_is_left_out_but_not_denied(tmp_path) -> None:
    for began in (100.0, BEGAN + 400 * DAY):
        make(tmp_path / f"{began}.pcapng", began=began, faults=(13,))
        add_here(tmp_path / f"{began}.pcapng", to=tmp_path / "set")
    car = only_car(tmp_path / "set")
    assert (car.readings, car.read) == ([], True)
    with opened(str(tmp_path / "set")) as database:
        (found,) = find(figures(database, shipped(), NOW), shipped()).cars
    said = [text.en for text in remarks(found)]
    assert not any("never read" in text for text in said)
    assert sum(text.startswith("Left out: 1 drive") for text in said) == 2


def test_a_reading_before_a_recording_counts_once_for_all_that_have_it(tmp_path) -> None:
    """The dashboard reads the faults, and then records twice."""
    read = faults_note(BEGAN, [FaultReading(BEGAN - 60, (13, 17)), FaultReading(BEGAN - 50, (13,))])
    for number in range(2):
        file = make(tmp_path / "in" / f"{number}.pcapng", began=BEGAN + 300 * number, faults=(13,))
        append_note(file, read)
    add_here(tmp_path / "in", to=tmp_path / "set")
    car = only_car(tmp_path / "set")
    began = datetime(2026, 3, 2, 7, 30)
    assert [(it.time - began, it.codes) for it in car.readings[:2]] == [
        (timedelta(seconds=-60), (13, 17)),
        (timedelta(seconds=-50), (13,)),
    ]
    assert [it.codes for it in car.readings[2:]] == [(13,), (13,)]
