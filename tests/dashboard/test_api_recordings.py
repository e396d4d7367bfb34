"""Recordings through the API: the list, one, its rows, its comment, its deletion."""

from __future__ import annotations

import json
import os
import shutil
from http.client import HTTPConnection
from itertools import product

import numpy as np
import pytest

import mikas
from dashboard.recordings_rig import record
from dashboard.rig import ME, OTHER, rig
from mikas.dashboard.library import service
from mikas.recording import CaptureReader
from mikas.recording.annotations.events import comment_of


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Two recordings, made once: `drive` with two faults, `cold`."""
    folder = tmp_path_factory.mktemp("made")
    record(folder / "drive.pcapng", "&faults=13,55", count=400)
    record(folder / "cold.pcapng", "&scenario=cold-start", count=60)
    return folder


@pytest.fixture
def desk(made, tmp_path):
    shutil.copytree(made, tmp_path / "recordings")
    with rig(tmp_path, None) as it:
        yield it


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "recordings"


def ids(desk):
    return [it["id"] for it in desk.get("/recordings")["recordings"]]


# --- the list


def test_the_list_has_size_length_and_date_the_latest_first(desk, folder) -> None:
    os.utime(folder / "cold.pcapng", (1, 1))
    drive, cold = desk.get("/recordings")["recordings"]
    assert (drive["id"], cold["id"]) == ("drive.pcapng", "cold.pcapng")
    assert drive["bytes"] == (folder / "drive.pcapng").stat().st_size
    assert drive["date"] is None  # a simulated clock knows no calendar
    assert drive["length"] > 10
    assert drive["model"] == {"en": "Mikas 7.1", "ru": "Микас 7.1"}
    assert drive["passport"][0] == "МИКАС 7.1"
    assert (drive["samples"], drive["samples_exact"]) == (400, True)
    assert drive["rate"] == pytest.approx(400 / drive["length"], rel=0.05)
    assert (drive["faults"], cold["faults"]) == ([13, 55], [])
    assert (drive["gaps"], drive["markers"], drive["note"]) == (1, 1, "")
    assert (drive["open"], drive["problem"]) == (False, None)


def test_no_folder_is_an_empty_list(tmp_path) -> None:
    with rig(tmp_path, None) as it:
        assert it.get("/recordings") == {"recordings": [], "problem": None, "left_out": []}
        assert it.get("/recordings/a.pcapng", 404)["code"] == "NotFound"


def test_a_recording_is_summed_up_once(desk, folder, monkeypatch) -> None:
    from mikas.recording.summary import summarise

    listed = []

    def counted(path, catalog):
        listed.append(path.name)
        return summarise(path, catalog)

    monkeypatch.setattr("mikas.dashboard.library.service.summarise", counted)
    for _ in range(3):
        assert len(ids(desk)) == 2
    assert sorted(listed) == ["cold.pcapng", "drive.pcapng"]
    with (folder / "drive.pcapng").open("ab") as file:
        file.write(b"\0\0\0\0")
    ids(desk)
    assert listed.count("drive.pcapng") == 2
    (folder / "cold.pcapng").unlink()
    assert ids(desk) == ["drive.pcapng"]


def test_only_recordings_are_listed(desk, folder, tmp_path) -> None:
    outside = tmp_path / "outside.pcapng"
    shutil.copy(folder / "cold.pcapng", outside)
    (folder / "link.pcapng").symlink_to(outside)
    (folder / "folder.pcapng").mkdir()
    (folder / ".hidden.pcapng").write_bytes(b"")
    (folder / "notes.txt").write_text("mine")
    (folder / "dumps").mkdir()
    assert sorted(ids(desk)) == ["cold.pcapng", "drive.pcapng"]
    for name in ("link.pcapng", "folder.pcapng", ".hidden.pcapng", "notes.txt"):
        assert desk.get(f"/recordings/{name}", 404)["code"] == "NotFound"


def test_what_is_no_recording_is_listed_with_its_problem(desk, folder) -> None:
    (folder / "empty.pcapng").write_bytes(b"")
    (folder / "foreign.pcapng").write_bytes(b"\xd4\xc3\xb2\xa1" + b"\0" * 40)
    found = {it["id"]: it for it in desk.get("/recordings")["recordings"]}
    for name in ("empty.pcapng", "foreign.pcapng"):
        assert found[name]["problem"]["ru"]
        assert (found[name]["samples"], found[name]["gaps"]) == (None, None)
        detail = desk.get(f"/recordings/{name}")
        assert (detail["channels"], detail["events"], detail["first"]) == ([], [], None)
        assert desk.get(f"/recordings/{name}/rows", 400)["code"] == "CaptureError"
    assert found["drive.pcapng"]["problem"] is None


NOWHERE = [
    "..", "../drive.pcapng", "..%2Fdrive.pcapng", "%2E%2E%2Fsecret.pcapng", "..%5Csecret.pcapng",
    "%2Fetc%2Fpasswd", "drive.pcapng%00", "C:secret.pcapng", "recordings%2F..%2F..%2Fsecret.pcapng",
    "secret.pcapng", "drive", "drive.pcapng.pcapng", "%0Adrive.pcapng", "a" * 5000 + ".pcapng",
]  # fmt: skip


def test_nothing_else_can_be_reached(desk, folder, tmp_path) -> None:
    shutil.copy(folder / "cold.pcapng", tmp_path / "secret.pcapng")
    raw = HTTPConnection("127.0.0.1", desk.port)
    for name, what in product(NOWHERE, ["", "/rows", "/file", "/export?format=csv", "/report"]):
        raw.request("GET", f"/api/recordings/{name}{what}", headers=ME)  # as it is, not tidied up
        answer = raw.getresponse()
        reported = answer.read().decode()
        assert answer.status == 404, (name, what, reported)
        assert json.loads(reported)["error"]["code"] == "NotFound"
        assert str(tmp_path) not in reported
    raw.close()


# --- one


def test_a_recording_has_its_channels_its_time_and_its_problems(desk, folder) -> None:
    it = desk.get("/recordings/drive.pcapng")
    frame = mikas.open(folder / "drive.pcapng").to_pandas().dropna(how="all")
    assert it["channels"] == list(frame.columns)
    begin, end = mikas.open(folder / "drive.pcapng").span
    assert begin - 2 < it["first"] <= begin < end <= it["last"] < end + 2
    assert it["problems"] == []
    kinds = {event["kind"]: event for event in it["events"]}
    assert kinds["marker"]["label"] == "here"
    assert kinds["gap"]["reason"] == {"en": "no echo", "ru": "нет эха"}
    assert kinds["unit"]["version_code"] == "0A"


def test_a_marker_is_changed_without_reading_the_packets(desk, folder, monkeypatch) -> None:
    events = desk.get("/recordings/drive.pcapng")["events"]
    [marker] = [it for it in events if it["kind"] == "marker"]
    with monkeypatch.context() as patch:
        patch.setattr(service, "Recording", None)
        desk.dashboard.library._open.clear()  # noqa: SLF001
        desk.put("/recordings/drive.pcapng/marker", {"time": marker["time"], "label": "there"})
        desk.put("/recordings/drive.pcapng/marker", {"time": 1.5, "label": "nowhere"}, 404)
    events = desk.get("/recordings/drive.pcapng")["events"]
    assert [it["label"] for it in events if it["kind"] == "marker"] == ["there"]


def test_two_sessions_in_one_file_have_the_span_of_both(desk, folder) -> None:
    both = (folder / "drive.pcapng").read_bytes() + (folder / "cold.pcapng").read_bytes()
    (folder / "both.pcapng").write_bytes(both)
    it = desk.get("/recordings/both.pcapng")
    assert (it["first"], it["last"]) == mikas.open(folder / "both.pcapng").span


def test_a_damaged_one_says_where(desk, folder) -> None:
    path = folder / "drive.pcapng"
    path.write_bytes(path.read_bytes()[:-3001])
    it = desk.get("/recordings/drive.pcapng")
    (problem,) = it["problems"]
    assert 0 < problem["offset"] < path.stat().st_size
    assert problem["ru"]
    assert it["problem"] is None


# --- rows


def test_all_rows_are_those_of_the_library(desk, folder) -> None:
    reported = desk.get("/recordings/drive.pcapng/rows", points=1000, names="UACC,TWAT,FUEL_FLOW")
    frame = mikas.open(folder / "drive.pcapng").to_pandas().dropna(how="all")
    assert reported["names"] == ["UACC", "TWAT", "FUEL_FLOW"]
    assert reported["decimated"] is False
    assert len(reported["times"]) == 400
    for name, column in zip(reported["names"], reported["values"], strict=True):
        values = np.array([np.nan if value is None else value for value in column])
        np.testing.assert_array_equal(values, frame[name].to_numpy())


def test_a_window_has_the_rows_of_its_time_only(desk) -> None:
    detail = desk.get("/recordings/drive.pcapng")
    begin, end = detail["first"] + 2, detail["first"] + 4
    reported = desk.get("/recordings/drive.pcapng/rows", **{"from": begin, "to": end})
    assert reported["names"] == detail["channels"]
    assert min(reported["times"]) >= begin - 1e-6
    assert max(reported["times"]) <= end + 1e-6
    assert 30 < len(reported["times"]) < 120
    nothing = desk.get("/recordings/drive.pcapng/rows", **{"from": end + 1e9})
    assert nothing["times"] == []


def test_spikes_stay_when_there_are_too_many_rows(desk, folder) -> None:
    reported = desk.get("/recordings/drive.pcapng/rows", points=20, names="FREQX")
    frame = mikas.open(folder / "drive.pcapng").to_pandas().dropna(how="all")
    assert reported["decimated"] is True
    assert len(reported["times"]) <= 24
    shown = [value for value in reported["values"][0] if value is not None]
    assert (min(shown), max(shown)) == (frame.FREQX.min(), frame.FREQX.max())


def test_wrong_queries_for_rows_are_refused(desk) -> None:
    for query in (
        {"names": "TWATT"}, {"names": "0x1A"}, {"points": 1}, {"points": 10**9}, {"from": "x"},
        {"to": "nan"}, {"from": "inf"},
    ):  # fmt: skip
        assert desk.get("/recordings/drive.pcapng/rows", 400, **query)["ru"]


def test_a_recording_is_opened_once_and_two_are_kept(desk, folder, monkeypatch) -> None:
    from mikas.dashboard.library import service

    opened = []

    class Counted(service.Recording):
        def __init__(self, path, *rest) -> None:
            opened.append(path.name)
            super().__init__(path, *rest)

    monkeypatch.setattr(service, "Recording", Counted)
    shutil.copy(folder / "cold.pcapng", folder / "third.pcapng")
    for name in ("drive", "cold", "drive", "cold", "third", "cold", "third", "drive"):
        desk.get(f"/recordings/{name}.pcapng/rows", points=2)
    assert [name.removesuffix(".pcapng") for name in opened] == ["drive", "cold", "third", "drive"]


# --- the note


def test_a_note_is_kept_in_the_file_itself(desk, folder) -> None:
    path = folder / "drive.pcapng"
    before = path.read_bytes()
    assert desk.put("/recordings/drive.pcapng/note", {"text": "после замены свечей"})["note"] == (
        "после замены свечей"
    )
    assert path.read_bytes().startswith(before)
    assert comment_of(CaptureReader(path).notes()) == "после замены свечей"
    desk.put("/recordings/drive.pcapng/note", {"text": "before the plugs"})
    assert desk.get("/recordings/drive.pcapng")["note"] == "before the plugs"
    assert len(mikas.open(path).to_pandas().dropna(how="all")) == 400
    assert mikas.open(path).problems == ()
    assert "before the plugs" in desk.get("/recordings/drive.pcapng/report").text


def test_a_wrong_note_is_refused(desk, folder, tmp_path) -> None:
    assert desk.put("/recordings/none.pcapng/note", {"text": "x"}, 404)["code"] == "NotFound"
    assert desk.put("/recordings/drive.pcapng/note", {"text": "x" * 10_001}, 400)["ru"]
    no_id = desk.client.put("/api/recordings/drive.pcapng/note", json={"text": "x"})
    assert no_id.status_code == 400
    (folder / "empty.pcapng").write_bytes(b"")
    assert desk.put("/recordings/empty.pcapng/note", {"text": "x"}, 400)["code"] == "CaptureError"
    assert (folder / "empty.pcapng").read_bytes() == b""


# --- deleting


def ask_to_delete(desk, name="drive.pcapng", status=200, headers=ME):
    wish = {"kind": "delete_recording", "id": name}
    return desk.post("/changes", wish, status, headers=headers)


def test_a_recording_is_deleted_only_after_a_confirmation(desk, folder) -> None:
    asked = ask_to_delete(desk)
    assert asked["before"]["id"] == "drive.pcapng"
    assert asked["meaning"]["ru"]
    assert (folder / "drive.pcapng").exists()
    assert desk.post(f"/changes/{asked['nonce']}")["after"] is None
    assert not (folder / "drive.pcapng").exists()
    assert ids(desk) == ["cold.pcapng"]
    assert desk.post(f"/changes/{asked['nonce']}", status=410)["code"] == "ConfirmationExpired"


def test_what_was_confirmed_must_still_be_so(desk, folder) -> None:
    asked = ask_to_delete(desk)
    with (folder / "drive.pcapng").open("ab") as file:
        file.write(b"\0\0\0\0")
    assert desk.post(f"/changes/{asked['nonce']}", status=409)["code"] == "ConfirmationOutdated"
    assert (folder / "drive.pcapng").exists()
    asked = ask_to_delete(desk)
    (folder / "drive.pcapng").unlink()
    assert desk.post(f"/changes/{asked['nonce']}", status=409)["code"] == "ConfirmationOutdated"


def test_only_its_own_client_may_confirm(desk, folder) -> None:
    asked = ask_to_delete(desk)
    desk.post("/control/take", {"force": True}, headers=OTHER)
    refused = desk.post(f"/changes/{asked['nonce']}", status=410, headers=OTHER)
    assert refused["code"] == "ConfirmationExpired"
    assert (folder / "drive.pcapng").exists()


def test_nothing_else_can_be_deleted(desk, folder, tmp_path) -> None:
    secret = tmp_path / "secret.pcapng"
    shutil.copy(folder / "cold.pcapng", secret)
    (folder / "link.pcapng").symlink_to(secret)
    for name in ("../secret.pcapng", "none.pcapng", "", ".", "link.pcapng", str(secret)):
        assert ask_to_delete(desk, name, 404)["code"] == "NotFound"
    assert secret.exists()
