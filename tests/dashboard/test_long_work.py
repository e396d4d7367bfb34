"""A recording whose report or summary never ends: what still works meanwhile, and what ends it."""

from __future__ import annotations

import shutil
import socket
from dataclasses import replace
from threading import Event

import pytest

from dashboard.recordings_rig import record
from dashboard.rig import rig
from mikas.cancellation import check_cancelled
from mikas.dashboard.library import service
from mikas.recording.summary import summarise
from mikas.report.from_recording import find_in_recording


class Crafted:
    """Reads as `read` does, except `bad.pcapng`, which never ends by itself."""

    def __init__(self, read):
        self._read = read
        self.began, self.ended, self.count = Event(), Event(), 0

    def __call__(self, what, *args, **options):
        if getattr(what, "path", what).name != "bad.pcapng":  # of a recording, or a path
            return self._read(what, *args, **options)
        self.count += 1
        self.began.set()
        try:
            while not self.ended.wait(1e-3):  # leaves the computer to the other threads
                check_cancelled()
        finally:
            self.ended.set()


@pytest.fixture
def desk(tmp_path):
    folder = tmp_path / "recordings"
    folder.mkdir()
    record(folder / "good.pcapng")
    shutil.copy(folder / "good.pcapng", folder / "bad.pcapng")
    with rig(tmp_path, None) as it:
        yield it


@pytest.fixture
def report(monkeypatch):
    crafted = Crafted(find_in_recording)
    monkeypatch.setattr("mikas.report.from_recording.find_in_recording", crafted)
    return crafted


def request_of(desk, path):
    """A client that waits for `path`."""
    client = socket.create_connection(("127.0.0.1", desk.port))
    client.sendall(f"GET /api{path} HTTP/1.1\r\nHost: 127.0.0.1:{desk.port}\r\n\r\n".encode())
    return client


def test_a_crafted_recording_holds_up_nothing_and_ends_with_its_client(desk, report):
    with request_of(desk, "/recordings/bad.pcapng/report"):
        assert report.began.wait(60)
        assert len(desk.get("/recordings")["recordings"]) == 2
        assert desk.get("/recordings/bad.pcapng")["problem"] is None
        assert desk.get("/recordings/good.pcapng/rows")["times"]
        assert desk.get("/recordings/good.pcapng/export").content
        assert "Engine report" in desk.get("/recordings/good.pcapng/report").text
        assert not report.ended.is_set()
    assert report.ended.wait(60)


def test_the_end_of_the_program_does_not_wait_for_a_report(tmp_path, report):
    (tmp_path / "recordings").mkdir()
    record(tmp_path / "recordings" / "bad.pcapng")
    with rig(tmp_path, None) as it:
        client = request_of(it, "/recordings/bad.pcapng/report")
        assert report.began.wait(60)
    assert report.ended.is_set()
    with client:
        answer = client.makefile("rb").read().decode()
    assert answer.startswith("HTTP/1.1 409")
    assert "the dashboard is closing" in answer


def test_a_report_past_its_deadline_names_the_command_that_has_none(desk, report):
    desk.get("/recordings/bad.pcapng")  # so that it is open
    lane = desk.dashboard.library.files
    lane.limits = replace(lane.limits, deadline=0)
    error = desk.get("/recordings/bad.pcapng/report", 504)
    assert report.ended.is_set()
    assert error["code"] == "TookTooLong"
    assert "mikas report FILE -o OUT.html" in error["en"]
    assert "mikas report ФАЙЛ -o ОТЧЁТ.html" in error["ru"]


def test_a_recording_that_can_not_be_summarised_is_in_the_list_with_its_problem(desk, monkeypatch):
    desk.get("/recordings/good.pcapng")
    crafted = Crafted(summarise)
    monkeypatch.setattr(service, "summarise", crafted)
    monkeypatch.setattr(service, "_SUMMARY_TIME", 1e-3)
    for _ in range(2):
        problems = {it["id"]: it["problem"] for it in desk.get("/recordings")["recordings"]}
        assert problems["good.pcapng"] is None
        assert "took longer" in problems["bad.pcapng"]["en"]
        assert "заняло больше" in problems["bad.pcapng"]["ru"]
    assert crafted.ended.is_set()
    assert crafted.count == 1  # it is not tried again for each list
    assert desk.get("/recordings/bad.pcapng")["problem"] is not None
