"""A dump's progress outlives the program, also of its second pass; a bug ends one dump only."""

from __future__ import annotations

import json
import time
from collections import deque

import pytest

from dashboard.dumps_rig import XRAM, ended, hold, until_read, when
from dashboard.rig import rig
from mikas.client.memory.dumps import Manifest, manifest_path
from mikas.dashboard.session import dump_jobs
from mikas.dashboard.session.dump_jobs import DumpJobs
from mikas.files import locks as file_locks

SMALL = {"space": "xram", "first": 0x40, "last": 0x7F}


def program(tmp_path):
    """Started on the same folder each time."""
    return rig(tmp_path, "sim:?scenario=warm-idle")


def hold_the_second_pass(monkeypatch, spoil):
    """It stops behind its first piece; before that the file is spoilt."""
    piece = DumpJobs._piece  # noqa: SLF001

    def first(self, ecu, job):
        if job.manifest.complete:
            spoil(job.file)
            hold(monkeypatch)
        return piece(self, ecu, job)

    monkeypatch.setattr(DumpJobs, "_piece", first)


def spoil(file):
    data = bytearray(file.read_bytes())
    data[0] ^= 1
    file.write_bytes(data)


def test_what_a_second_pass_found_outlives_the_program(tmp_path):
    with pytest.MonkeyPatch.context() as patch, program(tmp_path) as it:
        patch.setattr(dump_jobs, "TURN", 0)
        hold_the_second_pass(patch, spoil)
        it.sampling()
        name = it.post("/dumps", {**XRAM, "verify": True})["id"]
        until_read(it, name, 2049)
        before = it.post(f"/dumps/{name}/pause")
        assert (before["state"], before["total"], before["differences"]) == ("paused", 4096, 1)
    with program(tmp_path) as it:
        it.sampling()
        found = it.get(f"/dumps/{name}")
        assert found == before
        it.post(f"/dumps/{name}/resume")
        dump = ended(it, name, "done", "failed")
        assert (dump["state"], dump["done"], dump["differences"]) == ("done", 4096, 1)
        manifest = json.loads((it.dashboard.settings.dumps / f"{name}.bin.json").read_text("utf-8"))
        assert manifest["verified"] is False
    with program(tmp_path) as it:
        found = it.get(f"/dumps/{name}")
        assert (found["state"], found["done"], found["differences"]) == ("done", 4096, 1)


def test_a_second_pass_that_has_not_started_is_still_wanted(tmp_path, monkeypatch):
    hold(monkeypatch)
    with program(tmp_path) as it:
        it.sampling()
        name = it.post("/dumps", {**XRAM, "verify": True})["id"]
        until_read(it, name)
    with program(tmp_path) as it:
        found = it.get(f"/dumps/{name}")
        assert (found["state"], found["total"], found["differences"]) == ("paused", 4096, None)


def put(folder, name, held=64, **stored):
    """A dump's file and manifest, of one pass unless `stored` says more."""
    manifest = Manifest("xram", 0x40, 0x7F, "Mikas 7.1", 1, ("x",), 64, complete=True).as_json()
    for added in ("verify", "checked", "differences"):
        del manifest[added]
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{name}.bin"
    file.write_bytes(bytes(held))
    manifest_path(file).write_text(json.dumps({**manifest, **stored}), "utf-8")


def found(folder):
    it = DumpJobs(None, folder, time.monotonic)
    it.find()
    return it.jobs


@pytest.mark.parametrize(
    ("stored", "known"),
    [
        ({"verified": None}, ("done", 64, 64, None)),
        ({"verify": True, "checked": 20, "differences": 3}, ("paused", 84, 128, 3)),
        ({"held": 63, "verify": True, "checked": 20, "differences": 3}, ("paused", 63, 128, None)),
        ({"verify": True, "checked": 64, "differences": 2, "verified": False},
         ("done", 128, 128, 2)),
    ],
)  # fmt: skip
def test_the_progress_in_a_manifest_is_understood(tmp_path, stored, known):
    put(tmp_path, "a", **stored)
    job = found(tmp_path)["a"]
    assert (job.phase, job.done, job.total, job.manifest.differences) == known


@pytest.mark.parametrize(
    "stored",
    [{"checked": "9"}, {"checked": -1}, {"checked": 65}, {"differences": -1},
     {"differences": float("inf")}, {"space": "rom"}, {"space": []}, {"space": "ram", "last": 256},
     {"time": 1e300}, {"bytes_read": -1}, {"model": ["a"]}, {"version_code": 1 << 70}],
)  # fmt: skip
def test_what_is_no_manifest_is_no_dump_and_stops_nothing(tmp_path, stored):
    put(tmp_path, "a", **stored)
    put(tmp_path, "b")
    assert list(found(tmp_path)) == ["b"]


def test_a_file_that_was_cut_is_read_on_and_then_checked(idle):
    name = idle.post("/dumps", {**SMALL, "verify": True})["id"]
    ended(idle, name, "done")
    file = idle.dashboard.settings.dumps / f"{name}.bin"
    whole = file.read_bytes()
    file.write_bytes(whole[:10])
    idle.dashboard.dump_jobs.jobs.clear()
    idle.dashboard.dump_jobs.find()
    idle.post(f"/dumps/{name}/resume")
    dump = ended(idle, name, "done", "failed")
    assert (dump["state"], dump["done"], dump["differences"]) == ("done", 128, 0)
    assert file.read_bytes() == whole


def test_a_file_that_is_cut_in_the_second_pass_is_made_whole_first(idle):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dump_jobs, "TURN", 0)
        hold_the_second_pass(patch, lambda file: file.write_bytes(file.read_bytes()[:10]))
        name = idle.post("/dumps", {**SMALL, "verify": True})["id"]
        cut = when(idle, name, lambda dump: 0 < dump["done"] < 64)
        assert (cut["done"], cut["differences"]) == (10, None)
        idle.post(f"/dumps/{name}/pause")
    idle.post(f"/dumps/{name}/resume")
    dump = ended(idle, name, "done", "failed")
    assert (dump["state"], dump["done"], dump["differences"]) == ("done", 128, 0)


def test_a_missing_file_is_an_error(idle, monkeypatch):
    hold(monkeypatch)
    name = idle.post("/dumps", XRAM)["id"]
    until_read(idle, name)
    idle.post(f"/dumps/{name}/pause")
    (idle.dashboard.settings.dumps / f"{name}.bin").unlink()
    idle.post(f"/dumps/{name}/resume")
    failed = ended(idle, name, "failed", "done")
    assert failed["state"] == "failed"
    assert "is gone" in failed["error"]["en"]


def test_a_bug_in_one_dump_ends_that_one(idle):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(DumpJobs, "_piece", lambda *_: 1 // 0)
        name = idle.post("/dumps", SMALL)["id"]
        failed = ended(idle, name, "failed")
    assert failed["error"]["code"] == "InternalError"
    assert "ZeroDivisionError" in failed["error"]["ru"]
    assert idle.post(f"/dumps/{name}/pause")["state"] == "failed"
    ended(idle, idle.post("/dumps", {"space": "ram", "last": 3})["id"], "done")
    idle.post(f"/dumps/{name}/resume")
    assert ended(idle, name, "done", "failed")["error"] is None


def test_the_newest_comes_first(off):
    names = [
        "by hand",
        "xram-0040-007F-20260102-100000",
        "ram-0040-007F-20260102-100001",
        *(f"ram-0040-007F-20260102-100001-{number}" for number in (2, 3, 10)),
        "code-0040-007F-20260102-100002",
    ]
    for name in names:
        put(off.dashboard.settings.dumps, name)
    off.dashboard.dump_jobs.find()
    assert [dump["id"] for dump in off.get("/dumps")["dumps"]] == names[::-1]


class Cleared(deque):
    """A pace that a pause clears while it is looked at."""

    def __getitem__(self, at):
        self.clear()
        return super().__getitem__(at)


def test_a_pause_while_the_list_of_dumps_is_made_harms_nothing(off):
    """The list is made in a thread, dumps change in the event loop."""
    put(off.dashboard.settings.dumps, "a")
    off.dashboard.dump_jobs.find()
    job = off.dashboard.dump_jobs.jobs["a"]
    job.phase, job.pace = "running", Cleared([(0.0, 0), (1.0, 8)])
    try:
        assert off.get("/dumps")["dumps"][0]["speed"] == 8
    finally:
        job.phase = "paused"


def test_a_dump_that_another_program_reads_is_not_deleted(off):
    put(off.dashboard.settings.dumps, "a")
    off.dashboard.dump_jobs.find()
    file = off.dashboard.settings.dumps / "a.bin"
    with file.open("r+b") as held:
        file_locks.hold(held)
        refused = off.post("/changes", {"kind": "delete_dump", "id": "a"}, 409)
    assert "another program is writing to this file" in refused["en"]
    assert file.exists()
