"""One contract for a folder, a store in memory and one that speaks S3 (moto's server)."""

from __future__ import annotations

import logging
import os
import threading
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import ClassVar

import pytest
from fsspec.implementations.local import LocalFileSystem

from fleet_rig import BEGAN, DAY, add_here, ask, counts, make
from mikas.errors import FleetError, UsageError
from mikas.fleet.places import as_local, recordings_in, shown
from mikas.fleet.query.database import opened
from mikas.fleet.stores import FolderContents, store
from sql_attacks import READS, WRITES, attack

pytest.importorskip("moto")
MOST = 1 << 20
SECRET = "wJalrXUtnFEMIK7MDENGbPxRfiCYEXAMPLEKEY"


@contextmanager
def s3() -> Iterator[str]:
    """Give the URL of a bucket; its server and its credentials are in the environment."""
    import fsspec
    from moto.server import ThreadedMotoServer

    logging.getLogger("werkzeug").setLevel(logging.CRITICAL)
    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    given = {
        "AWS_ACCESS_KEY_ID": "AKIAIOSFODNN7EXAMPLE", "AWS_SECRET_ACCESS_KEY": SECRET,
        "AWS_ENDPOINT_URL": f"http://{host}:{port}", "AWS_DEFAULT_REGION": "us-east-1",
    }  # fmt: skip
    before = {name: os.environ.get(name) for name in given}
    os.environ.update(given)
    try:
        system = fsspec.filesystem("s3", skip_instance_cache=True)
        system.mkdir("cars", create_parents=True)
        yield "s3://cars"
    finally:
        for name, value in before.items():
            os.environ.pop(name)
            if value is not None:
                os.environ[name] = value
        server.stop()
        fsspec.filesystem("s3").clear_instance_cache()


@pytest.fixture(scope="module")
def bucket() -> Iterator[str]:
    with s3() as url:
        yield url


@pytest.fixture(params=["folder", "memory", "s3"])
def place(request, tmp_path) -> str:
    match request.param:
        case "folder":
            return str(tmp_path / "store")
        case "memory":
            return f"memory://{uuid.uuid4().hex}/store"
    return f"{request.getfixturevalue('bucket')}/{uuid.uuid4().hex}"


def test_every_store_keeps_the_contract(place, tmp_path) -> None:
    files = store(place)
    files.tidy()
    assert files.read("a/b.txt", MOST) is None
    assert files.names("") == files.names("a") == []
    assert files.contents("a", ".txt", MOST) == FolderContents()
    files.remove("a/b.txt")
    files.write("a/b.txt", b"one")
    files.write("a/car=Волга 1%2F/c.txt", b"two")
    assert files.read("a/b.txt", MOST) == b"one"
    files.write("a/b.txt", b"three")
    with files.workshop("run") as folder:
        part = folder / "part"
        part.write_bytes(b"four" * 5000)
        files.put("a/d.txt", part)
    assert files.names("a") == ["b.txt", "car=Волга 1%2F", "d.txt"]
    assert files.names("") == ["a"] or files.names("") == [".parts", "a"]
    assert files.contents("a/car=Волга 1%2F", ".txt", MOST).files == {"c.txt": b"two"}
    again = store(place)
    assert again.read("a/d.txt", MOST) == b"four" * 5000
    files.remove("a/b.txt")
    files.remove("a/b.txt")
    assert again.read("a/b.txt", MOST) is None
    assert again.names("a") == ["car=Волга 1%2F", "d.txt"]


def test_recordings_of_a_store_become_a_dataset_in_it(place, tmp_path) -> None:
    import fsspec

    home = f"{place}/in"
    for number in range(2):
        file = make(tmp_path / f"{number}.pcapng", began=BEGAN + number * DAY)
        system, path = fsspec.core.url_to_fs(home)
        system.makedirs(path, exist_ok=True)
        system.pipe_file(f"{path}/{number}.pcapng", file.read_bytes())
    system.pipe_file(f"{path}/bad.pcapng", b"no")
    system.pipe_file(f"{path}/notes.txt", b"no")
    assert len(list(recordings_in(home))) == 3
    assert counts(add_here(home, to=f"{place}/set")) == (2, 0, 0, 1)
    assert counts(add_here(home, to=f"{place}/set")) == (0, 0, 2, 1)
    rows = "SELECT car, count(*), count(DISTINCT day) FROM samples GROUP BY car"
    assert ask(f"{place}/set", rows) == [("A101MP52", 2 * 239, 2)]
    assert counts(add_here(f"{home}/0.pcapng", to=f"{place}/set")) == (0, 0, 1, 0)
    with pytest.raises(FleetError, match="no such file or folder"):
        list(recordings_in(f"{place}/nothing"))


def test_an_empty_folder_made_in_a_console_is_a_place_for_a_dataset(bucket, tmp_path) -> None:
    import fsspec

    file = make(tmp_path / "drive.pcapng")
    home = f"{bucket}/{uuid.uuid4().hex}"
    system, path = fsspec.core.url_to_fs(home)
    for folder in ("", "/_ledger"):
        system.pipe_file(f"{path}{folder}/", b"")
        assert add_here(file, to=home).bad == []
        assert ask(home, "SELECT count(*) FROM samples") == [(239,)]


class OneConnection(LocalFileSystem):
    """A file system like FTP's: one request at a time, no file that stays open, lists of names in
    another encoding, and a folder that another process makes at the same time is an error.
    """

    protocol = "one"
    requests = threading.Lock()
    tried: ClassVar[set[str]] = set()

    @contextmanager
    def alone(self) -> Iterator[None]:
        assert self.requests.acquire(blocking=False), "two requests at a time"
        try:
            yield
        finally:
            self.requests.release()

    def info(self, path: str, **given) -> dict:
        with self.alone():
            return super().info(path, **given)

    def cat_file(self, path: str, start=None, end=None, **_) -> bytes:
        with self.alone():
            return Path(self._strip_protocol(path)).read_bytes()

    def find(self, path: str, **_) -> dict[str, dict]:
        found = super().find(path, detail=True)
        return {name.encode().decode("latin-1"): info for name, info in found.items()}

    def makedirs(self, path: str, exist_ok: bool = False) -> None:
        if path not in self.tried:
            self.tried.add(path)
            raise FileExistsError(path)
        super().makedirs(path, exist_ok=exist_ok)

    def _open(self, path: str, mode: str = "rb", **given):
        assert "r" not in mode
        return super()._open(path, mode, **given)


def test_a_dataset_is_read_through_a_single_connection(tmp_path) -> None:
    import fsspec

    fsspec.register_implementation("one", OneConnection, clobber=True)
    for number in range(4):
        make(tmp_path / "in" / f"{number}.pcapng", plate="Волга 1", began=BEGAN + number * DAY)
    home = f"one://{tmp_path / 'set'}"
    assert counts(add_here(tmp_path / "in", to=home)) == (4, 0, 0, 0)
    assert counts(add_here(tmp_path / "in", to=home)) == (0, 0, 4, 0)
    rows = "SELECT count(*), count(DISTINCT file) FROM samples JOIN drives USING (drive)"
    assert ask(home, rows) == [(4 * 239, 4)]


def test_a_url_shows_no_name_and_no_password() -> None:
    assert shown(f"sftp://me:{SECRET}@host/x") == "sftp://host/x"
    assert shown("s3://bucket/a@b") == "s3://bucket/a@b"


@pytest.mark.parametrize(
    "url", [f"ftp://me:{SECRET}@127.0.0.1:9/x", f"nothing://me:{SECRET}@host/x", "s3://no-bucket/x"]
)
def test_a_place_that_does_not_answer_is_said_in_words(url, bucket) -> None:
    with pytest.raises(FleetError) as failed:
        list(recordings_in(url))
    assert SECRET not in str(failed.value)
    assert "me:" not in str(failed.value)
    assert str(failed.value).startswith(shown(url))


def test_refused_credentials_are_said_and_not_shown(monkeypatch) -> None:
    import fsspec

    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", SECRET)
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "AKIAIOSFODNN7EXAMPLE")
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:9")
    monkeypatch.setenv("AWS_MAX_ATTEMPTS", "1")
    fsspec.filesystem("s3").clear_instance_cache()
    with pytest.raises(FleetError) as failed:
        store("s3://cars/set").write("x", b"data")
    assert SECRET not in str(failed.value)
    assert "AKIA" not in str(failed.value)
    fsspec.filesystem("s3").clear_instance_cache()


def test_a_remote_file_is_a_local_one_for_the_time(bucket, tmp_path) -> None:
    store(bucket).write("one.pcapng", b"data")
    with as_local(f"{bucket}/one.pcapng") as path:
        assert path.read_bytes() == b"data"
        assert path.name == "one.pcapng"
    assert not path.exists()


def test_a_question_changes_and_reaches_nothing_in_a_bucket(bucket, tmp_path) -> None:
    import fsspec

    home = f"{bucket}/{uuid.uuid4().hex}"
    add_here(make(tmp_path / "drive.pcapng"), to=home)
    system, path = fsspec.core.url_to_fs(home)

    def objects() -> dict[str, bytes]:
        system.invalidate_cache()
        found: dict[str, bytes] = system.cat(system.find(path))
        return found

    before = objects()
    (table,) = (name for name in before if "/samples/" in name)
    with opened(home) as database:
        for sql in WRITES + READS:
            for place in (f"s3://{table}", f"dataset://{table.removeprefix(f'{path}/')}"):
                with pytest.raises(UsageError):
                    list(database.ask(attack(sql, home, place)).rows)
    assert objects() == before
