"""Captures of virtual cars with a defect, through the wire into a dataset: each has its cause."""

from __future__ import annotations

from datetime import UTC, datetime

import pytest

import mikas
from fleet_rig import BEGAN, add_here, ask
from mikas.catalog import shipped
from mikas.causes.rows import CHANNELS
from mikas.client.cars import CarDetails
from mikas.fleet.query.database import opened
from mikas.fleet.report.figures import figures
from mikas.fleet.report.findings import find
from mikas.fleet.report.page import render
from mikas.recording import CaptureWriter
from mikas.recording.annotations.events import car_note

SIM = "sim:?clock=simulated"
RATE = 1.0  # readings a second
CARS = {
    "LEAK": "&scenario=mixed&car=leak:9",
    "SOUND": "&scenario=mixed",
    "STOOD": "&scenario=mixed&car=leak:9",
}
SECONDS = {"LEAK": 780, "SOUND": 780, "STOOD": 8}


def capture(path, car: str) -> None:
    url = f"{SIM}{CARS[car]}"
    with CaptureWriter(path, url=url) as sink, mikas.connect(url, sink=sink) as ecu:
        sink.note(car_note(ecu.tester.link.now(), CarDetails(plate=car)))
        ecu.faults()
        for _ in ecu.watch(*CHANNELS, method="batch", rate=RATE, count=int(SECONDS[car] * RATE)):
            pass


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    home = tmp_path_factory.mktemp("causes")
    (home / "in").mkdir()
    for car in CARS:
        capture(home / "in" / f"{car}.pcapng", car)
    add_here(home / "in", to=home / "set")
    return home / "set"


def test_each_car_has_its_verdict_and_the_defective_one_its_cause(dataset) -> None:
    asked = "SELECT plate, verdict, cause, likelihood FROM drives ORDER BY plate"
    leak, *others = ask(dataset, asked)
    assert leak in [("LEAK", "causes", "leak", it) for it in ("probable", "almost-certain")]
    assert others == [("SOUND", "sound", None, None), ("STOOD", "cannot-tell", None, None)]


def test_the_report_leaves_drives_without_a_date_out_and_says_so(dataset) -> None:
    """A simulated clock does not count from 1970: a car of such drives has no cause by date."""
    with opened(str(dataset)) as database:
        now = datetime.fromtimestamp(BEGAN, UTC).replace(tzinfo=None)
        page = render(find(figures(database, shipped(), now), shipped()), "en")
    assert "without a date" in page
