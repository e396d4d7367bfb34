"""Recordings from elsewhere: added whole or not at all, never over another file."""

from __future__ import annotations

import gzip
from contextlib import suppress

import httpx
import pytest

from dashboard.recordings_rig import record
from dashboard.rig import ME, rig
from merged_harness import record as record_car
from mikas.dashboard.security import middleware
from mikas.dashboard.security.middleware import MAX_BODY

LAN = {"lan": True, "lan_control": True, "hosts": ("garage",), "token": "a-token-of-the-test"}
ELSEWHERE = {"Host": "garage:{port}", "Authorization": f"Bearer {LAN['token']}"}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return record(tmp_path_factory.mktemp("made") / "drive.pcapng").read_bytes()


@pytest.fixture
def desk(tmp_path):
    with rig(tmp_path, None) as it:
        yield it


def add(desk, content, name="drive.pcapng", headers=ME):
    url = "/api/recordings"
    return desk.client.post(url, params={"name": name}, content=content, headers=headers)


def kept(tmp_path):
    folder = tmp_path / "recordings"
    return sorted(each.name for each in folder.iterdir()) if folder.exists() else []


def test_a_recording_from_elsewhere_is_one_like_any_other(desk, made, tmp_path):
    answer = add(desk, made)
    assert (answer.status_code, answer.json()) == (200, {"id": "drive.pcapng"})
    assert desk.get("/recordings/drive.pcapng/file").content == made
    assert desk.get("/recordings/drive.pcapng")["markers"] == 1
    assert kept(tmp_path) == ["drive.pcapng"]


def test_a_file_of_several_cars_becomes_a_file_of_each(desk, tmp_path):
    one = record_car(tmp_path / "one.pcapng", "A111AA52", version=9).read_bytes()
    two = record_car(tmp_path / "two.pcapng", "B222BB52", faults="53").read_bytes()
    assert add(desk, one + two, "both.pcapng").json() == {"id": "both-2.pcapng"}
    assert kept(tmp_path) == ["both-1.pcapng", "both-2.pcapng"]
    for name, content in (("both-1.pcapng", one), ("both-2.pcapng", two)):
        assert desk.get(f"/recordings/{name}/file").content == content
    (tmp_path / "recordings" / "by-hand.pcapng").write_bytes(one + two)
    (listed,) = (it for it in desk.get("/recordings")["recordings"] if it["id"] == "by-hand.pcapng")
    assert "1: A111AA52, 2: B222BB52" in str(listed)


def test_a_packed_recording_is_kept_unpacked(desk, made, tmp_path):
    assert add(desk, gzip.compress(made), "drive.pcapng.gz").status_code == 200
    assert kept(tmp_path) == ["drive.pcapng"]
    assert desk.get("/recordings/drive.pcapng/file").content == made
    assert add(desk, b"\x04\x22\x4d\x18" + bytes(99)).status_code == 400


def test_a_recording_that_a_phone_has_shared_has_its_own_name(desk, made, tmp_path):
    names = ["a.pcapng.txt", "b.pcapng (1).txt", "c.PCAPNG.TXT", "notes.txt"]
    given = [add(desk, made, name).json()["id"] for name in names]
    assert given == ["a.pcapng", "b.pcapng", "c.PCAPNG.pcapng", "notes.txt.pcapng"]
    assert add(desk, gzip.compress(made), "d.pcapng.txt.gz").json() == {"id": "d.pcapng"}


def test_no_file_is_replaced_and_no_name_is_a_path(desk, made, tmp_path):
    names = ["drive.pcapng", "drive", "../../drive.pcapng", "C:\\Users\\a.pcapng", "con.pcapng"]
    given = [add(desk, made, name).json()["id"] for name in names]
    assert given[:2] == ["drive.pcapng", "drive (2).pcapng"]
    assert sorted(given) == kept(tmp_path)
    assert len(set(given)) == len(names)


def test_another_file_is_refused_with_its_name(desk, made, tmp_path):
    for content in (b"", b"GIF89a", made[4:20]):
        answer = add(desk, content, "photo.pcapng")
        assert answer.status_code == 400
        assert "photo.pcapng" in answer.json()["error"]["en"]
    assert kept(tmp_path) == []


def test_what_does_not_come_whole_is_not_kept(desk, made, tmp_path):
    def cut():
        yield made[:1000]
        raise KeyboardInterrupt

    with suppress(KeyboardInterrupt, httpx.HTTPError):
        add(desk, cut())
    assert add(desk, made).json() == {"id": "drive.pcapng"}
    with desk.live() as live:
        live.until(lambda _: kept(tmp_path) == ["drive.pcapng"])


def test_only_this_computer_fills_its_disk_and_not_all_of_it(tmp_path, made, monkeypatch):
    with rig(tmp_path, None, **LAN) as it:
        headers = ME | {name: value.format(port=it.port) for name, value in ELSEWHERE.items()}
        answer = add(it, made, headers=headers)
        assert (answer.status_code, answer.json()["error"]["code"]) == (403, "OnlyHere")
        answer = add(it, b"x" * (MAX_BODY + 1), headers=headers)
        assert answer.status_code == 413
        monkeypatch.setattr(middleware, "MAX_RECORDING", 1000)
        assert add(it, made[:1001]).status_code == 413
    assert kept(tmp_path) == []
