"""Folders that others write to: one bad file costs no other, and a link leads nowhere."""

from __future__ import annotations

import json
import os
import socket
from contextlib import closing
from http.client import HTTPConnection, IncompleteRead
from pathlib import Path

import pytest

from dashboard.dumps_rig import ended
from dashboard.rig import ME, rig
from mikas.client.memory.dumps import Manifest, manifest_path
from mikas.dashboard.api.library import files
from mikas.dashboard.library import folder as library_folder
from mikas.dashboard.library.folder import RecordingFolder, files_in
from mikas.dashboard.session import dump_jobs

SECRET = b"root:x:0:0:"


def put(file: Path, *, held: int = 10, **stored: object) -> None:
    """A dump of 64 bytes that was begun, and its manifest."""
    manifest = Manifest("xram", 0x40, 0x7F, "Mikas 7.1", 1, ("x",), held).as_json()
    file.write_bytes(bytes(held))
    manifest_path(file).write_text(json.dumps({**manifest, **stored}), "utf-8")


@pytest.fixture
def dumps(tmp_path: Path) -> Path:
    folder = tmp_path / "recordings" / "dumps"
    folder.mkdir(parents=True)
    return folder


@pytest.mark.posix
def test_no_file_in_dumps_keeps_the_dashboard_from_starting(
    tmp_path: Path, dumps: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    secret = tmp_path / "passwd"
    secret.write_bytes(SECRET)
    put(dumps / "good.bin")
    monkeypatch.chdir(dumps)  # a socket's name is short
    for name in ("link", "pipe", "device", "folder", "long", "a\x9b2J", "a\u202e", "x" * 240):
        put(Path(f"{name}.bin"))
    for name in ("link", "pipe", "device", "folder"):
        Path(f"{name}.bin").unlink()
    Path("link.bin").symlink_to(secret)
    Path("device.bin").symlink_to("/dev/zero")
    Path("folder.bin").mkdir()
    os.mkfifo("pipe.bin")
    os.mkfifo("m-pipe.bin.json")
    Path("m-link.bin.json").symlink_to(secret)
    Path("m-device.bin.json").symlink_to("/dev/zero")
    Path("m-folder.bin.json").mkdir()
    for name, text in (("deep", "[" * 200_000), ("huge", "9" * 60_000), ("inf", '{"a":1e999}')):
        Path(f"m-{name}.bin.json").write_text(text)
    with Path("m-large.bin.json").open("wb") as large:
        large.truncate(1 << 40)
    for file in Path().glob("m-*.json"):
        file.with_suffix("").write_bytes(b"")
    for number, stored in enumerate(
        ({"model": []}, {"time": "now"}, {"first": True}, {"passport": [1]}, {"passport": 3},
         {"sha256": 5}, {"bytes_read": "9"}, {"version_code": 1e300}, {"last": 1 << 70})
    ):  # fmt: skip
        put(Path(f"k-{number}.bin"), **stored)
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("socket.bin")
        with rig(tmp_path, None) as it:
            listed = it.get("/dumps")
            for name in ("link", "m-link"):
                assert it.get(f"/dumps/{name}/file", 404)["code"] == "NotFound"
    assert sorted(dump["id"] for dump in listed["dumps"]) == ["good", "long"]
    why = {each["name"]: each["problem"] for each in listed["left_out"]}
    assert len(why) == 25
    assert "is a link to another file" in why["link.bin"]["en"]
    assert "is a link to another file" in why["m-link.bin.json"]["en"]
    assert "это канал или устройство" in why["pipe.bin"]["ru"]
    assert why["m-deep.bin.json"] == why["m-large.bin.json"]
    assert why["m-huge.bin.json"]["en"] == "it is no manifest of a dump"
    assert "larger than 64 KB" in why["m-large.bin.json"]["en"]
    assert "rename the file" in why["a\ufffd2J.bin"]["en"]


@pytest.mark.posix
def test_resuming_a_dump_writes_through_no_link(
    idle, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dump_jobs, "TURN", 0)
    secret = tmp_path / "passwd"
    folder = idle.dashboard.settings.dumps
    whole = {"space": "xram", "first": 0x40, "last": 0x7F}
    name = idle.post("/dumps", whole)["id"]
    assert ended(idle, name, "done", "failed")["state"] == "done"
    made = json.loads((folder / f"{name}.bin.json").read_text("utf-8"))
    unread = {"complete": False, "bytes_read": 0, "sha256": None}
    file = folder / "a.bin"
    manifest = manifest_path(file)
    for planted, make in (
        (file, lambda: file.symlink_to(secret)),
        (file, lambda: os.link(secret, file)),
        (file, lambda: os.mkfifo(file)),
        (manifest, lambda: manifest.symlink_to(secret)),
        (folder / "a.bin.json.new", lambda: (folder / "a.bin.json.new").symlink_to(secret)),
    ):
        secret.write_bytes(SECRET)
        put(file, **{**made, **unread})
        idle.dashboard.dump_jobs.jobs.clear()
        idle.dashboard.dump_jobs.find()
        planted.unlink(missing_ok=True)
        make()
        idle.post("/dumps/a/resume")
        dump = ended(idle, "a", "done", "failed")
        if planted.name.endswith(".new"):
            assert dump["state"] == "done"
        else:
            assert (dump["state"], dump["error"]["code"]) == ("failed", "UsageError")
        assert secret.read_bytes() == SECRET
        for each in folder.glob("a.bin*"):
            each.unlink()


def download(it, path: str) -> tuple[int, int, bytes]:
    """The status, the length promised, and the bytes that came."""
    with closing(HTTPConnection("127.0.0.1", it.port, timeout=60)) as raw:
        raw.request("GET", f"/api{path}", headers=ME)
        answer = raw.getresponse()
        length = int(answer.headers["Content-Length"])
        try:
            return answer.status, length, answer.read()
        except IncompleteRead as cut:
            return answer.status, length, cut.partial


@pytest.mark.posix
def test_a_download_gives_no_other_file_whatever_replaces_it_meanwhile(
    tmp_path: Path, monkeypatch, caplog
) -> None:
    """Between the look-up and the opening, and between the opening and the sending."""
    folder = tmp_path / "recordings"
    secret, other, file = tmp_path / "passwd", tmp_path / "other", folder / "a.pcapng"
    folder.mkdir()
    secret.write_bytes(SECRET)
    content = bytes(range(256)) * 1024

    def replace() -> None:
        other.write_bytes(b"other")
        other.replace(file)

    def relink() -> None:
        file.unlink()
        file.symlink_to(secret)

    def pipe() -> None:
        file.unlink()
        os.mkfifo(file)

    def grow() -> None:
        with file.open("ab") as out:
            out.write(b"more")

    def cut() -> None:
        os.truncate(file, 100)

    find, send = RecordingFolder.one, files.OpenFile.stream_response
    with rig(tmp_path, None) as it:
        for act, status, early, late in (
            (file.unlink, 404, None, content),
            (replace, 200, b"other", content),
            (relink, 400, None, content),
            (pipe, 400, None, content),
            (grow, 200, content + b"more", content),
            (cut, 200, content[:100], content[:100]),
        ):

            def one(self, identity, act=act):
                kept = find(self, identity)
                act()
                return kept

            async def stream(self, to, act=act):
                act()
                await send(self, to)

            with monkeypatch.context() as patch:
                file.unlink(missing_ok=True)
                file.write_bytes(content)
                patch.setattr(RecordingFolder, "one", one)
                got = download(it, "/recordings/a.pcapng/file")
            assert got[0] == status, act
            assert early is None or got[1:] == (len(early), early), act
            assert SECRET not in got[2]
            with monkeypatch.context() as patch:
                file.unlink(missing_ok=True)
                file.write_bytes(content)
                patch.setattr(files.OpenFile, "stream_response", stream)
                assert download(it, "/recordings/a.pcapng/file") == (200, len(content), late), act
    assert not [each for each in caplog.records if each.exc_info]


@pytest.mark.posix
def test_a_dump_whose_file_is_replaced_gives_no_more_than_its_range(
    tmp_path: Path, dumps: Path
) -> None:
    put(dumps / "a.bin")
    with rig(tmp_path, None) as it:
        assert download(it, "/dumps/a/file") == (200, 10, bytes(10))
        (dumps / "a.bin").write_bytes(bytes(1000))  # longer than its range: not of the dump
        assert download(it, "/dumps/a/file") == (200, 64, bytes(64))
        (dumps / "a.bin").unlink()
        assert download(it, "/dumps/a/file")[0] == 404
        compare = f"http://127.0.0.1:{it.port}/api/dumps/a/compare"
        body = {"headers": {**ME, "Content-Type": "application/octet-stream"}, "content": b"x"}
        assert it.client.post(compare, **body).status_code == 404
        os.mkfifo(dumps / "a.bin")
        assert download(it, "/dumps/a/file")[0] == 400
        assert "pipe" in it.client.post(compare, **body).json()["error"]["en"]


@pytest.mark.posix
def test_files_that_are_left_out_of_the_list_are_named_with_the_reason(
    tmp_path: Path, monkeypatch
) -> None:
    folder = tmp_path / "recordings"
    folder.mkdir()
    (folder / "link.pcapng").symlink_to("/etc/passwd")
    os.mkfifo(folder / "pipe.pcapng")
    (folder / "a\x9b2J.pcapng").write_bytes(b"")
    (folder / os.fsdecode(b"a\xff.pcapng")).write_bytes(b"")
    (folder / ".hidden.pcapng").write_bytes(b"")
    for number in range(5):
        (folder / f"{number}.pcapng").write_bytes(b"")
        os.utime(folder / f"{number}.pcapng", (number, number))
    monkeypatch.setattr(library_folder, "_MOST_LISTED", 3)
    listed = RecordingFolder(folder).all()
    assert RecordingFolder(folder).one("0.pcapng").id == "0.pcapng"
    assert [each.id for each in listed.files] == ["4.pcapng", "3.pcapng", "2.pcapng"]
    why = {each.name: each.problem.en for each in listed.left_out}
    assert sorted(why) == ["", "a\ufffd.pcapng", "a\ufffd2J.pcapng", "link.pcapng", "pipe.pcapng"]
    assert why[""] == "older files that are not listed: 2; move some to another folder"


@pytest.mark.parametrize("name", ["a.pcapng.gz", "a.pcapng.ZST", "a.zip", "a.pcapng.lz4"])
def test_a_packed_recording_that_is_not_listed_is_named(tmp_path: Path, name: str) -> None:
    """Nothing was said of it."""
    (tmp_path / name).write_bytes(b"")
    files, (left_out,) = RecordingFolder(tmp_path).all()
    assert (files, left_out.name) == ([], name)
    assert "unpack it" in left_out.problem.en


def test_a_folder_of_a_hundred_thousand_names_is_looked_at_in_part(
    tmp_path: Path, monkeypatch
) -> None:
    for number in range(30):
        (tmp_path / f"{number}.bin").symlink_to("none")
    found = files_in(tmp_path, ".bin", 10)
    assert (len(found.files), len(found.left_out)) == (0, 21)
    assert found.left_out[-1].problem.en == "more files that can't be used here: 10"
    monkeypatch.setattr(library_folder, "_MOST_SEEN", 7)
    assert len(files_in(tmp_path, ".bin", 10).left_out) == 7
    assert files_in(tmp_path / "none", ".bin", 10) == library_folder.Listing([], [])


def test_a_folder_that_is_replaced_while_it_is_listed_is_no_error(
    tmp_path: Path, monkeypatch
) -> None:
    folder = tmp_path / "dumps"
    folder.mkdir()
    for number in range(5):
        (folder / f"{number}.bin").write_bytes(b"1")
    check = library_folder.is_file_name

    def late(name: str, suffix: str) -> bool:
        if folder.is_dir():
            folder.rename(tmp_path / "gone")
            folder.write_bytes(b"no folder any more")
        return check(name, suffix)

    monkeypatch.setattr(library_folder, "is_file_name", late)
    assert len(files_in(folder, ".bin", 10).files) < 5


@pytest.mark.posix
def test_a_pipe_for_the_journal_or_the_presets_is_not_waited_for(tmp_path: Path) -> None:
    state = tmp_path / "state"
    state.mkdir()
    os.mkfifo(state / "journal.jsonl")
    os.mkfifo(state / "presets.json")
    with rig(tmp_path, None) as it:
        assert it.get("/journal") == {"entries": []}
        assert it.get("/presets") == {"presets": []}
        tile = {"kind": "gauge", "names": ["TWAT"], "span": 1}
        preset = {"id": "a", "name": {"en": "a", "ru": "a"}, "tiles": [tile]}
        assert it.put("/presets", {"presets": [preset]})["presets"][0]["id"] == "a"
        (state / "presets.json").write_text(json.dumps([preset] * 101))
        assert it.get("/presets") == {"presets": []}
