"""Faults that were stored and are no more: a report made just after erasing is not a clean one."""

from __future__ import annotations

from pathlib import Path

import pytest
from report_harness import START, rows
from report_harness import found as found_in

import mikas
from mikas.catalog import shipped
from mikas.recording import CaptureWriter
from mikas.recording.annotations.events import faults_note
from mikas.report.findings import Findings, Outcome, find
from mikas.report.from_recording import find_in_recording
from mikas.report.page import render
from mikas.report.sections.summary import summary_sentence
from mikas.report.subject import ClearedFaults, cleared_faults
from mikas.sampling.events import FaultReading

IDLE = "sim:?clock=simulated&scenario=warm-idle"


def after(*gone: ClearedFaults, read: float = START + 30, stored: tuple[int, ...] = ()) -> Findings:
    from dataclasses import replace

    it = found_in(rows(), faults=stored)
    return find(replace(it.subject, cleared=gone, faults_read=read), it.measured)


def gone(*codes: int, time: float = START + 20, erased: bool = True) -> ClearedFaults:
    return ClearedFaults(time, tuple(map(shipped().fault, codes)), erased)


def test_a_report_right_after_erasing_is_not_green() -> None:
    it = after(gone(13, 53, 17, 99))
    assert it.outcome is Outcome.OPEN
    reported = summary_sentence(it)
    assert reported.en.startswith("No faults are stored now; ")
    assert reported.ru.startswith("Сейчас ошибок в памяти блока нет; ")
    for code in ("13", "53", "17"):
        assert code in reported.en
        assert code in reported.ru
    assert "not known yet" in reported.en
    page = render(it, "ru")
    assert "Сброшены в " in page
    assert shipped().fault(53).text.ru in page
    assert "считайте ошибки снова" in page
    assert "read the faults again" in render(it, "en")


def test_faults_that_stayed_away_for_long_are_good_news() -> None:
    it = after(gone(13), read=START + 20 + 900)
    assert it.outcome is Outcome.GOOD
    assert "13" in summary_sentence(it).en
    assert "not known yet" not in summary_sentence(it).en


def test_what_came_back_is_what_counts() -> None:
    it = after(gone(13), stored=(13,))
    assert it.outcome is Outcome.ATTENTION
    assert summary_sentence(it).en.startswith("1 fault is stored: 13; ")


def test_a_message_that_was_erased_changes_nothing() -> None:
    messages = [it.code for it in shipped().faults.values() if it.informational]
    it = after(gone(messages[0]))
    assert it.outcome is Outcome.GOOD


def test_faults_that_vanish_without_an_erase_are_not_cleared() -> None:
    it = after(gone(13, erased=False))
    assert it.outcome is Outcome.OPEN
    assert "erased" not in summary_sentence(it).en
    assert "сброшен" not in summary_sentence(it).ru


def test_faults_that_are_gone_between_two_readings_are_cleared() -> None:
    heard = [
        FaultReading(1, (13, 53)),
        FaultReading(2, (53, 17), erased=True),
        FaultReading(3, (53, 17)),
        FaultReading(4, ()),
    ]
    (first, second) = cleared_faults(heard, shipped())
    assert (first.time, first.erased, [it.code for it in first.faults]) == (2, True, [13])
    assert (second.time, second.erased, [it.code for it in second.faults]) == (4, False, [53, 17])


@pytest.fixture
def erased(tmp_path: Path) -> Path:
    path, url = tmp_path / "erased.pcapng", f"{IDLE}&faults=13,53"
    with CaptureWriter(path, url=url) as sink, mikas.connect(url, sink=sink) as ecu:
        ecu.faults()
        ecu.erase_faults()
        for _ in ecu.watch(method="batch", count=300):
            pass
    return path


def test_a_report_of_a_recording_has_the_cleared_faults(erased) -> None:
    it = find_in_recording(mikas.open(erased))
    assert it.subject.faults == ()
    (gone_,) = it.cleared
    assert (gone_.erased, {fault.code for fault in gone_.faults}) == (True, {13, 53})
    assert it.outcome is Outcome.OPEN


def test_faults_read_before_the_recording_began_count(tmp_path) -> None:
    path = tmp_path / "later.pcapng"
    with CaptureWriter(path, url=IDLE) as sink, mikas.connect(IDLE, sink=sink) as ecu:
        readings = [
            FaultReading(1.0, (13, 53)),
            FaultReading(2.0, (53,), True),
            FaultReading(3.0, (53,)),
        ]
        sink.note(faults_note(ecu.tester.link.now(), readings))
        for _ in ecu.watch(method="batch", count=20):
            pass
    it = find_in_recording(mikas.open(path))
    assert [each.code for each in it.subject.faults or ()] == [53]
    assert it.subject.faults_read == 3.0
    assert [fault.code for each in it.cleared for fault in each.faults] == [13]


@pytest.mark.parametrize(
    "reported", [None, 3, {}, [3], [{"time": "x", "codes": []}], [{"time": 1, "codes": [256]}]]
)
def test_a_damaged_note_of_readings_is_passed_over(reported, tmp_path) -> None:
    from mikas.recording.capture.notes import Kind, Note

    path = tmp_path / "a.pcapng"
    with CaptureWriter(path, url=IDLE) as sink:
        sink.note(Note(Kind.FAULTS, 1.0, {"readings": reported}))
    assert find_in_recording(mikas.open(path)).subject.faults is None
