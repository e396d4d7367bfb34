"""A recording's report: its last session, with what its notes and its wire tell."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import pytest

import mikas
from mikas.catalog import shipped
from mikas.errors import CaptureError
from mikas.i18n import Text
from mikas.recording import CaptureWriter
from mikas.recording.annotations.events import note_of
from mikas.recording.formatting import date_of
from mikas.report.findings import BandPosition, Outcome
from mikas.report.from_recording import find_in_recording
from mikas.report.page import render
from mikas.sampling.events import Gap, Marker, TextNote
from session_header_harness import write_session_header

IDLE = "sim:?clock=simulated&scenario=warm-idle"


def record(
    path: Path,
    url: str = IDLE,
    *names: str,
    count: int = 300,
    faults: bool = True,
    method: str = "batch",
    head: bool = True,
) -> Path:
    with CaptureWriter(path, url=url) as sink, mikas.connect(url, sink=sink) as ecu:
        if head:
            write_session_header(
                sink,
                ecu.tester.link.now(),
                version_code=ecu.version_code,
                passports=ecu.passport().pieces,
                catalog_version=ecu.catalog.version,
                adapter="a cable",
                echo=True,
            )
        if faults:
            ecu.faults()
        for _ in ecu.watch(*names, method=method, count=count):
            pass
    return path


@pytest.fixture
def drive(tmp_path: Path) -> Path:
    return record(tmp_path / "drive.pcapng", f"{IDLE}&faults=13,55")


def test_a_report_has_unit_values_and_faults_of_the_recording(drive: Path) -> None:
    found = find_in_recording(mikas.open(drive))
    subject, measured = found.subject, found.measured
    assert subject.unit is not None
    assert subject.unit.model.text.en == "Mikas 7.1"
    assert subject.unit.program[0] == "МИКАС 7.1"
    assert [fault.code for fault in subject.faults or ()] == [13, 55]
    conditions = subject.conditions
    assert (conditions.file, conditions.adapter) == ("drive.pcapng", "a cable")
    assert (conditions.echo, conditions.sessions, conditions.damaged) == (
        True,
        1,
        0,
    )
    assert subject.conditions.port.startswith(IDLE)
    assert subject.conditions.date is None  # a simulated clock knows no calendar
    assert measured.rows >= 300
    assert {value.mark for value in found.rated} == {BandPosition.INSIDE}
    assert len(found.rated) == 7  # all but the air flow, whose sensor is faulty
    assert found.outcome is Outcome.ATTENTION
    assert {"FUEL_FLOW", "FILLING", "DUTY"} <= {
        value.channel.name for value in found.values if value.unrated
    }
    assert "FUEL_USED" in measured.curves
    assert "FUEL_USED" not in measured.whole


def test_the_values_are_those_of_the_recording(drive: Path) -> None:
    found = find_in_recording(mikas.open(drive))
    frame = mikas.open(drive).to_pandas()
    for name in ("UACC", "TWAT", "JAIR", "DUTY", "FUEL_FLOW"):
        values = frame[name].dropna()
        stats = found.measured.whole[name]
        assert stats.count == len(values)
        decimals = shipped().channel(name).decimals + 2
        assert stats.least == pytest.approx(values.min(), abs=10**-decimals)
        assert stats.most == pytest.approx(values.max(), abs=10**-decimals)


def test_faults_that_were_never_read_are_not_known(tmp_path: Path) -> None:
    found = find_in_recording(mikas.open(record(tmp_path / "a.pcapng", count=50, faults=False)))
    assert found.subject.faults is None


def test_the_last_answer_about_faults_counts(tmp_path: Path) -> None:
    path = tmp_path / "erased.pcapng"
    url = f"{IDLE}&faults=13"
    with CaptureWriter(path, url=url) as sink, mikas.connect(url, sink=sink) as ecu:
        assert [fault.code for fault in ecu.faults()] == [13]
        ecu.erase_faults()
        for _ in ecu.watch(count=5):
            pass
    assert find_in_recording(mikas.open(path)).subject.faults == ()


def test_without_a_session_header_the_unit_is_unknown(tmp_path: Path) -> None:
    found = find_in_recording(mikas.open(record(tmp_path / "bare.pcapng", count=5, head=False)))
    assert found.subject.unit is None
    render(found, "ru")


def test_values_read_one_at_a_time_are_judged_at_warm_idle(tmp_path: Path) -> None:
    path = record(
        tmp_path / "one.pcapng", IDLE, "TWAT", "FREQ", "THR", "UACC", method="single", count=600
    )
    found = find_in_recording(mikas.open(path))
    assert found.measured.idle.enough
    assert {value.channel.name for value in found.rated} == {"TWAT", "FREQ", "THR", "UACC"}


def test_a_cold_engine_is_not_judged(tmp_path: Path) -> None:
    url = "sim:?clock=simulated&scenario=cold-start"
    found = find_in_recording(mikas.open(record(tmp_path / "cold.pcapng", url)))
    assert found.rated == ()
    assert found.measured.idle.spans == ()


def test_of_several_sessions_the_last_is_reported(tmp_path: Path) -> None:
    first = record(tmp_path / "a.pcapng", f"{IDLE}&faults=13", count=400)
    second = record(tmp_path / "b.pcapng", f"{IDLE}&faults=17", count=100)
    both = tmp_path / "both.pcapng"
    both.write_bytes(first.read_bytes() + second.read_bytes())
    found = find_in_recording(mikas.open(both))
    assert [fault.code for fault in found.subject.faults or ()] == [17]
    assert found.subject.conditions.sessions == 2
    assert found.measured.rows == find_in_recording(mikas.open(second)).measured.rows


def test_notes_of_the_recording_are_in_the_report(tmp_path: Path) -> None:
    path = tmp_path / "noted.pcapng"
    with CaptureWriter(path, url=IDLE) as sink, mikas.connect(IDLE, sink=sink) as ecu:
        for _ in ecu.watch(count=5):
            pass
        sink.note(note_of(TextNote(1.0, "after the new plugs")))
        sink.note(note_of(Marker(2.0, "here")))
        sink.note(note_of(Gap(3.0, 3.0, 5.0, Text("no echo", "нет эха"))))
        sink.note(note_of(Gap(6.0, 6.0, None, Text("no echo", "нет эха"))))
    found = find_in_recording(mikas.open(path))
    assert found.subject.notes == ("after the new plugs",)
    pauses = found.subject.conditions.interruptions
    assert [(pause.began, pause.ended) for pause in pauses] == [(3.0, 5.0), (6.0, None)]
    assert pauses[0].reason == Text("no echo", "нет эха")
    assert "after the new plugs" in render(found, "en")


def test_a_cut_recording_is_reported_as_far_as_it_goes(drive: Path) -> None:
    drive.write_bytes(drive.read_bytes()[:-3001])
    found = find_in_recording(mikas.open(drive))
    assert found.subject.conditions.damaged == 1
    assert found.measured.rows > 100


def test_an_empty_recording_has_an_open_outcome(tmp_path: Path) -> None:
    empty = tmp_path / "empty.pcapng"
    with CaptureWriter(empty, url=IDLE):
        pass
    found = find_in_recording(mikas.open(empty))
    assert (found.outcome, found.rated, found.subject.faults) == (Outcome.OPEN, (), None)
    assert render(found, "en")
    with pytest.raises(CaptureError, match="nowhere"):
        find_in_recording(mikas.open(tmp_path / "nowhere.pcapng"))


def test_the_catalog_of_today_judges(drive: Path, tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text(
        '[parameter.UACC]\nreference = [15, 16]\nmeaning.low = "not enough"\n[fault.13]\n'
        'text = "mine"\n',
        "utf-8",
    )
    found = find_in_recording(mikas.open(drive, catalogs=[own]))
    (value,) = found.abnormal
    assert (value.channel.name, value.mark, value.meaning.en) == (
        "UACC",
        BandPosition.LOW,
        "not enough",
    )
    assert "mine" in render(found, "en")


def test_a_time_is_a_date_only_on_a_real_clock() -> None:
    assert date_of(None) is None
    assert date_of(12345.0) is None
    date = date_of(1_780_000_000.0)
    assert isinstance(date, datetime)
    assert date.timestamp() == 1_780_000_000
    assert date.tzinfo is not None
