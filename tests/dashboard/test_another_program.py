"""A dashboard and `mikas log` on one folder: what one records the other does not change."""

from __future__ import annotations

import pytest

from dashboard.rig import rig
from mikas.files.locks import hold
from two_programs_rig import another_recording


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    folder = tmp_path_factory.mktemp("two")
    (folder / "recordings").mkdir()
    with rig(folder, None) as it, another_recording(folder / "recordings" / "log.pcapng") as other:
        it.other, it.folder = other, folder / "recordings"
        yield it


def test_it_is_listed_and_read(desk):
    assert [it["id"] for it in desk.get("/recordings")["recordings"]] == ["log.pcapng"]
    assert desk.get("/recordings/log.pcapng/file").content


def test_it_is_not_changed(desk):
    at = {"time": 1.0, "label": "x"}
    changes = [
        desk.post("/changes", {"kind": "delete_recording", "id": "log.pcapng"}, 409),
        desk.put("/recordings/log.pcapng/note", {"text": "mine"}, 400),
        desk.put("/recordings/log.pcapng/car", {"car": "GAZ-3110"}, 400),
    ]
    for refused in changes:
        assert "another program is writing to this file" in refused["en"]
        assert "end it there, first" in refused["en"]
        assert "дождитесь её конца или завершите её" in refused["ru"]
    assert desk.put("/recordings/log.pcapng/marker", at, 404)["code"] == "NotFound"


def test_one_that_begins_after_the_confirmation_was_shown_is_kept_too(desk):
    path = desk.folder / "later.pcapng"
    path.write_bytes((desk.folder / "log.pcapng").read_bytes())
    shown = desk.post("/changes", {"kind": "delete_recording", "id": path.name})
    with path.open("r+b") as file:
        hold(file)
        refused = desk.post(f"/changes/{shown['nonce']}", status=409)
    assert "another program" in refused["en"]
    assert path.exists()
    shown = desk.post("/changes", {"kind": "delete_recording", "id": path.name})
    desk.post(f"/changes/{shown['nonce']}")
    assert not path.exists()
