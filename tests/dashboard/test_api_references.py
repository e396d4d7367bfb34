"""References through the API: marked recordings, and those of the virtual car."""

from __future__ import annotations

import shutil

import pytest

from dashboard.recordings_rig import record
from dashboard.rig import rig
from mikas.dashboard.library import service
from mikas.dashboard.library.service import References

IDLE = "virtual:warm-idle:7.1"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return record(tmp_path_factory.mktemp("made") / "drive.pcapng", count=20)


@pytest.fixture
def desk(made, tmp_path):
    (tmp_path / "recordings").mkdir()
    shutil.copy(made, tmp_path / "recordings")
    with rig(tmp_path, None) as it:
        yield it


def test_a_mark_stays_and_ends_with_its_recording(desk, tmp_path):
    marked = desk.put("/recordings/drive.pcapng/reference", {"on": True})
    assert marked["marked"] == ["drive.pcapng"]
    assert [it["reference"] for it in desk.get("/recordings")["recordings"]] == [True]
    proposal = desk.post("/changes", {"kind": "delete_recording", "id": "drive.pcapng"})
    assert "is a reference" in proposal["meaning"]["en"]
    desk.post(f"/changes/{proposal['nonce']}")
    assert desk.get("/references")["marked"] == []


def test_marks_in_a_damaged_file_are_none(tmp_path):
    marks = tmp_path / "references.json"
    kept = References(marks, tmp_path)
    for damage in (b"{", b'{"a": 1}', b"[1, null]", b"\xff"):
        marks.write_bytes(damage)
        assert kept.marked() == []
    kept.mark("a", on=True)
    kept.mark("b", on=True)
    assert kept.marked() == ["b", "a"]
    kept.mark("b", on=False)
    assert kept.marked() == ["a"]


def test_the_virtual_car_is_read_like_a_recording_and_changed_like_none(desk, monkeypatch):
    drive = service.DRIVES["warm-idle"]
    short = service.Drive(drive.scenario, 2.0, drive.rate, drive.text)
    monkeypatch.setitem(service.DRIVES, "warm-idle", short)
    assert IDLE in [it["id"] for it in desk.get("/references")["virtual"]]
    detail = desk.get(f"/recordings/{IDLE}")
    assert (detail["id"], detail["virtual"], detail["faults"]) == (IDLE, True, [])
    assert detail["model"]["en"] == "Mikas 7.1"
    rows = desk.get(f"/recordings/{IDLE}/rows?names=TWAT")
    assert len(rows["times"]) > 8
    desk.put(f"/recordings/{IDLE}/reference", {"on": True}, status=404)
    desk.put(f"/recordings/{IDLE}/note", {"text": "x"}, status=404)
    desk.post("/changes", {"kind": "delete_recording", "id": IDLE}, status=404)
    for other in ("virtual:other:7.1", "virtual:..:7.1"):
        desk.get(f"/recordings/{other}", status=404)


def test_it_is_recorded_without_the_users_own_folders(tmp_path, monkeypatch):
    """A browser has none of them, and what the user has learnt must not change the recording."""

    def refuse():
        raise AssertionError("the user's own folder")

    monkeypatch.setattr("mikas.home.state_folder", refuse)
    monkeypatch.delenv("MIKAS_STATE", raising=False)
    drive = service.DRIVES["warm-idle"]
    short = service.Drive(drive.scenario, 1.0, drive.rate, drive.text)
    monkeypatch.setitem(service.DRIVES, "warm-idle", short)
    assert References(tmp_path / "m", tmp_path / "made").virtual(IDLE).path.is_file()


def test_the_same_version_makes_the_same_recording(tmp_path, monkeypatch):
    drive = service.DRIVES["drive"]
    short = service.Drive(drive.scenario, 3.0, drive.rate, drive.text)
    monkeypatch.setitem(service.DRIVES, "drive", short)
    one, other = (
        References(tmp_path / "m", tmp_path / name).virtual("virtual:drive:5.4") for name in "ab"
    )
    assert one.path.read_bytes() == other.path.read_bytes()
    assert [it.name for it in (tmp_path / "a").iterdir()] == [one.path.name]
