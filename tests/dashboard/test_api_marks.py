"""Moments of a recording marked afterwards, and what can't be marked."""

from __future__ import annotations

import errno
import gzip
import os

import pytest

import mikas
from dashboard.recordings_rig import record
from dashboard.rig import rig
from mikas.files.locks import hold
from mikas.recording.capture import writer

DRIVE = "/recordings/drive.pcapng"


@pytest.fixture
def desk(tmp_path):
    (tmp_path / "recordings").mkdir()
    record(tmp_path / "recordings" / "drive.pcapng", count=60)
    with rig(tmp_path, None) as it:
        yield it


@pytest.fixture
def file(tmp_path):
    return tmp_path / "recordings" / "drive.pcapng"


def mark(it, *markers, status=200, of=DRIVE):
    wanted = [{"time": time, "label": label} for time, label in markers]
    return it.post(f"{of}/markers", {"markers": wanted}, status)


def marks(it):
    events = it.get(DRIVE)["events"]
    found = [(event["time"], event["label"]) for event in events if event["kind"] == "marker"]
    return sorted(found)


def test_moments_are_marked_afterwards_named_removed_and_stand_in_the_file(desk, file):
    before, packets = marks(desk), file.read_bytes()
    first, last = mikas.open(file).span
    moments = [first + 0.1, (first + last) / 2]
    answer = mark(desk, (moments[0], "knock"), (moments[1], ""))
    times = [it["time"] for it in answer["markers"]]
    assert times == pytest.approx(moments, abs=1e-6)
    assert file.read_bytes().startswith(packets)  # appended
    assert marks(desk) == sorted([*before, (times[0], "knock"), (times[1], "")])
    desk.put(f"{DRIVE}/marker", {"time": times[1], "label": "then"})
    assert (times[1], "then") in marks(desk)
    mark(desk, (times[0], "knock again"))
    assert marks(desk) == sorted([*before, (times[0], "knock again"), (times[1], "then")])
    assert desk.get("/recordings")["recordings"][0]["markers"] == len(before) + 2
    labels = [event.label for event in mikas.open(file).events if event.kind == "marker"]
    assert sorted(labels) == sorted([*(label for _, label in before), "knock again", "then"])


def test_a_moment_that_the_recording_does_not_have_marks_nothing(desk, file):
    first, last = mikas.open(file).span
    before = file.read_bytes()
    assert mark(desk, (first, ""), (last + 60, ""), status=400)["code"] == "BadRequest"
    assert mark(desk, (first, ""), status=404, of="/recordings/none.pcapng")["code"] == "NotFound"
    assert mark(desk, status=400)["code"] == "BadRequest"
    assert file.read_bytes() == before


def test_a_file_that_may_only_be_read_says_so(desk, file, monkeypatch):
    time = mikas.open(file).span[0]
    opened = writer.open_regular

    def refused(path, mode="rb", **more):
        if "+" in mode:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return opened(path, mode, **more)

    monkeypatch.setattr(writer, "open_regular", refused)
    for path, body in (
        (f"{DRIVE}/markers", {"markers": [{"time": time}]}),
        (f"{DRIVE}/note", {"text": "mine"}),
    ):
        send = desk.post if path.endswith("markers") else desk.put
        error = send(path, body, 400)
        assert error["code"] == "CaptureError"
        assert "may only be read" in str(error)
        assert "только для чтения" in str(error)


def test_a_packed_file_says_that_it_is_packed(desk, file):
    packed = file.with_name("packed.pcapng")
    packed.write_bytes(gzip.compress(file.read_bytes()))
    moment = mikas.open(file).span[0]
    error = mark(desk, (moment, ""), status=400, of=f"/recordings/{packed.name}")
    assert "unpack it first" in str(error)


def test_a_file_that_another_program_writes_is_not_marked(desk, file):
    moment, before = mikas.open(file).span[0], file.read_bytes()
    with file.open("r+b") as held:
        hold(held)
        error = mark(desk, (moment, ""), status=400)
        assert "is writing to this file" in str(error)
    assert file.read_bytes() == before


def test_the_recording_in_progress_is_refused_and_a_moment_that_has_passed_is_marked_live(tmp_path):
    with rig(tmp_path, "sim:?scenario=warm-idle") as it:
        it.sampling()
        began = it.get("/state")["now"]
        started = it.post("/recording/start", {})["recording"]["file"]
        samples = it.get("/state")["samples"]
        it.until(lambda message: message["state"]["samples"] > samples + 40)
        of = f"/recordings/{started}"
        error = mark(it, (it.get("/state")["now"], ""), status=409, of=of)
        assert "still being written" in str(error)
        now = it.get("/state")["now"]
        passed = it.post("/recording/marker", {"label": "then", "time": now - 0.2})["time"]
        assert passed == pytest.approx(now - 0.2, abs=1e-6)
        it.post("/recording/marker", {"label": "before", "time": began - 1})
        it.post("/recording/stop", {})
        logged = [one for one in it.get(of)["events"] if one["kind"] == "marker"]
        assert [one["label"] for one in logged] == ["then"]
        assert logged[0]["time"] == pytest.approx(passed, abs=1e-5)


def test_a_recording_of_the_virtual_car_is_not_marked(desk):
    virtual = desk.get("/references")["virtual"][0]["id"]
    detail = desk.get(f"/recordings/{virtual}")
    error = mark(desk, (detail["first"], ""), status=409, of=f"/recordings/{virtual}")
    assert "part of the program" in str(error)
