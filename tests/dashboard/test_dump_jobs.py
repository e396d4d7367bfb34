"""Dumps as jobs: between samples, paused, resumed, verified, compared; nothing lost or doubled."""

from __future__ import annotations

import json
import threading
from types import SimpleNamespace

import pytest

from dashboard.dumps_rig import XRAM, ended, hold, let_go, until_read, when
from dashboard.rig import ME, OTHER, rig
from mikas.client.memory.dumps import Dump


@pytest.fixture
def held(monkeypatch):
    """Dumps stop behind each piece, until `let_go`."""
    hold(monkeypatch)
    return monkeypatch


def memory(it, first, count):
    data = ""
    for address in range(first, first + count, 1024):
        size = min(1024, first + count - address)
        data += it.get("/memory/xram", address=str(address), count=size)["data"]
    return bytes.fromhex(data)


def test_a_dump_is_what_the_unit_holds(idle):
    samples = idle.get("/state")["samples"]
    dump = idle.post("/dumps", {**XRAM, "verify": True})
    assert (dump["state"], dump["done"], dump["total"]) == ("running", 0, 4096)
    dump = ended(idle, dump["id"], "done", "failed")
    assert (dump["state"], dump["done"], dump["differences"]) == ("done", 4096, 0)
    assert {block["state"] for block in dump["blocks"]} == {"done"}
    assert sum(block["count"] for block in dump["blocks"]) == 2048
    held = idle.client.get(f"/api/dumps/{dump['id']}/file").content
    assert held == memory(idle, 0x100, 2048)
    manifest = json.loads(
        (idle.dashboard.settings.dumps / f"{dump['file']}.json").read_text("utf-8")
    )
    assert (manifest["complete"], manifest["verified"]) == (True, True)
    assert idle.get("/state")["samples"] > samples  # it went on meanwhile


def test_it_is_paused_and_goes_on_behind_what_was_read(held, idle):
    name = idle.post("/dumps", XRAM)["id"]
    until_read(idle, name)
    paused = idle.post(f"/dumps/{name}/pause")
    assert paused["state"] == "paused"
    assert idle.get(f"/dumps/{name}")["done"] == paused["done"] < 2048
    assert idle.post(f"/dumps/{name}/pause")["state"] == "paused"
    assert idle.post(f"/dumps/{name}/resume")["state"] == "running"
    assert idle.post(f"/dumps/{name}/resume")["state"] == "running"  # a second click
    let_go(held, idle, name)
    assert ended(idle, name, "done", "failed")["state"] == "done"
    assert idle.post(f"/dumps/{name}/resume")["state"] == "done"
    assert idle.client.get(f"/api/dumps/{name}/file").content == memory(idle, 0x100, 2048)


def test_a_pulled_adapter_costs_nothing_that_was_read(held, idle):
    name = idle.post("/dumps", XRAM)["id"]
    until_read(idle, name, 300)
    idle.cars.pull()
    let_go(held, idle, name)
    waits = when(idle, name, lambda dump: dump["error"])
    assert waits["state"] == "running"
    assert waits["error"]["ru"]
    idle.cars.put_back()
    done = ended(idle, name, "done", "failed")
    assert (done["state"], done["error"]) == ("done", None)
    assert idle.client.get(f"/api/dumps/{name}/file").content == memory(idle, 0x100, 2048)


def test_a_dump_outlives_the_program(held, tmp_path):
    with rig(tmp_path, "sim:?scenario=warm-idle") as it:
        it.sampling()
        name = it.post("/dumps", XRAM)["id"]
        until_read(it, name, 300)
        it.post(f"/dumps/{name}/pause")
    with rig(tmp_path, "sim:?scenario=warm-idle") as it:
        it.sampling()
        found = it.get("/dumps")["dumps"]
        assert [(dump["id"], dump["state"]) for dump in found] == [(name, "paused")]
        assert 300 <= found[0]["done"] < 2048
        let_go(held, it, name)
        assert ended(it, name, "done", "failed")["state"] == "done"


def test_it_is_not_gone_on_with_on_another_unit(held, tmp_path):
    with rig(tmp_path, "sim:?scenario=warm-idle") as it:
        it.sampling()
        name = it.post("/dumps", XRAM)["id"]
        until_read(it, name)
        it.post(f"/dumps/{name}/pause")
        it.post("/connect", {"port": "sim:?model=5.4", "method": "batch", "rate": 5})
        it.until(lambda m: "5.4" in (m["state"]["model"] or {}).get("en", ""))
        it.sampling()
        it.post(f"/dumps/{name}/resume")
        failed = ended(it, name, "failed", "done")
        assert failed["state"] == "failed"
        assert "another unit" in failed["error"]["en"]


def test_a_second_dump_at_once_is_refused(held, idle):
    first = idle.post("/dumps", XRAM)["id"]
    assert idle.post("/dumps", XRAM, 409)["code"] == "Busy"
    idle.post(f"/dumps/{first}/pause")
    second = idle.post("/dumps", {"space": "ram", "last": 3})["id"]
    assert second != first
    ended(idle, second, "done")


def test_dumps_are_compared_and_deleted(idle):
    name = idle.post("/dumps", {"space": "xram", "first": 0x40, "last": 0x7F})["id"]
    ended(idle, name, "done")
    own = idle.client.get(f"/api/dumps/{name}/file").content
    other = bytes([own[0] ^ 1]) + own[1:] + b"\x55"
    reported = idle.client.post(f"/api/dumps/{name}/compare", content=other, headers=ME).json()
    assert reported["count"] == 2
    assert reported["differences"][0] == {
        "address": 0x40,
        "a": f"{own[0]:02X}",
        "b": f"{other[0]:02X}",
    }
    assert reported["differences"][1] == {"address": 0x80, "a": None, "b": "55"}
    shifted = f"/api/dumps/{name}/compare?first=65"
    assert idle.client.post(shifted, content=own[1:], headers=ME).json()["count"] == 1


def delete(it, name, status=200, headers=ME):
    return it.post("/changes", {"kind": "delete_dump", "id": name}, status, headers=headers)


def small(it):
    name = it.post("/dumps", {"space": "xram", "first": 0x40, "last": 0x7F})["id"]
    ended(it, name, "done")
    return name


def test_a_dump_is_deleted_only_after_a_confirmation(idle):
    name = small(idle)
    assert idle.client.delete(f"/api/dumps/{name}", headers=ME).status_code == 405
    assert delete(idle, name, 409, headers=OTHER)["code"] == "NotController"
    asked = delete(idle, name)
    assert asked["before"] == {"id": name, "file": f"{name}.bin", "done": 64, "total": 64}
    assert asked["lost"] == [asked["before"]]
    assert asked["meaning"]["ru"]
    assert idle.get(f"/dumps/{name}")["state"] == "done"
    idle.post(f"/changes/{asked['nonce']}", status=409, headers=OTHER)
    assert idle.post(f"/changes/{asked['nonce']}")["after"] is None
    assert idle.get(f"/dumps/{name}", 404)["code"] == "NotFound"
    assert idle.get("/dumps") == {"dumps": [], "left_out": []}
    assert not any(idle.dashboard.settings.dumps.iterdir())
    assert idle.post(f"/changes/{asked['nonce']}", status=410)["code"] == "ConfirmationExpired"
    assert delete(idle, name, 404)["code"] == "NotFound"


def test_a_dump_that_is_being_read_is_not_deleted(held, idle):
    name = idle.post("/dumps", XRAM)["id"]
    assert delete(idle, name, 409)["code"] == "Busy"
    idle.post(f"/dumps/{name}/pause")
    nonce = delete(idle, name)["nonce"]
    idle.post(f"/dumps/{name}/resume")
    assert idle.post(f"/changes/{nonce}", status=409)["code"] == "Busy"
    let_go(held, idle, name)
    ended(idle, name, "done")


def test_a_paused_dump_is_free_at_once_also_in_the_middle_of_a_piece(idle, monkeypatch):
    reading, go_on, advance = threading.Event(), threading.Event(), Dump.advance

    def slow(self, **more):
        def progress(count):
            reading.set()
            assert go_on.wait(60)
            more["progress"](count)

        advance(self, **{**more, "progress": progress})

    monkeypatch.setattr(Dump, "advance", slow)
    name = idle.post("/dumps", XRAM)["id"]
    assert reading.wait(60)
    job = idle.dashboard.dump_jobs.one(name)
    piece = job.piece

    def acquire(timeout):
        go_on.set()  # not before it is waited for
        return piece.acquire(timeout=timeout)

    job.piece = SimpleNamespace(acquire=acquire, release=piece.release)
    idle.post(f"/dumps/{name}/pause")
    idle.post(f"/changes/{delete(idle, name)['nonce']}")
    assert not any(idle.dashboard.settings.dumps.iterdir())


def test_a_dump_that_is_no_longer_as_it_was_shown_is_not_deleted(held, idle):
    name = idle.post("/dumps", XRAM)["id"]
    idle.post(f"/dumps/{name}/pause")
    nonces = [delete(idle, name)["nonce"] for _ in range(2)]
    let_go(held, idle, name)
    ended(idle, name, "done")
    assert idle.post(f"/changes/{nonces[0]}", status=409)["code"] == "ConfirmationOutdated"
    assert idle.client.get(f"/api/dumps/{name}/file").content == memory(idle, 0x100, 2048)
    idle.post(f"/changes/{delete(idle, name)['nonce']}")
    assert idle.post(f"/changes/{nonces[1]}", status=409)["code"] == "ConfirmationOutdated"


def test_a_dump_whose_file_can_not_be_removed_is_still_there(idle):
    name = small(idle)
    nonce = delete(idle, name)["nonce"]
    file = idle.dashboard.settings.dumps / f"{name}.bin"
    file.unlink()
    (file / "not a file").mkdir(parents=True)
    assert name in idle.post(f"/changes/{nonce}", status=400)["en"]
    assert idle.get(f"/dumps/{name}")["state"] == "done"


@pytest.mark.parametrize(
    "wish",
    [{"space": "ram", "first": 0, "last": 256}, {"space": "xram", "first": 9, "last": 8},
     {"space": "sfr", "last": 70000}, {"space": "rom", "last": 1}, {"space": "ram"},
     {"space": "ram", "last": 1, "block": 0}],
)  # fmt: skip
def test_a_range_that_makes_no_sense_is_refused(shared_idle, wish):
    assert shared_idle.post("/dumps", wish, 400)["ru"]
    assert shared_idle.get("/dumps") == {"dumps": [], "left_out": []}


def test_a_folder_that_can_not_be_written_is_an_error(idle):
    idle.dashboard.settings.recordings.write_text("in the way")
    name = idle.post("/dumps", XRAM)["id"]
    failed = ended(idle, name, "failed", "done")
    assert failed["state"] == "failed"
    assert "dumps" in failed["error"]["en"]


def test_what_is_not_there_is_not_found(shared_idle):
    for path in ("/dumps/x", "/dumps/..%2f..%2fetc"):
        assert shared_idle.get(path, 404)["code"] == "NotFound"
    assert shared_idle.client.get("/api/dumps/x/file").status_code == 404
