"""Places: names that are not UTF-8, folders that can't be read, URLs of the files below a URL."""

from __future__ import annotations

import os
from shutil import make_archive

import pytest
from fsspec.implementations.local import LocalFileSystem
from fsspec.registry import known_implementations

from fleet_rig import BEGAN, DAY, add_here, ask, counts, make
from mikas.errors import FleetError
from mikas.fleet.ledger import FOLDER
from mikas.fleet.places import FoundFile, as_path, recordings_in, shown
from mikas.fleet.stores import DiskStore, store

OLD_NAME = "Волга".encode("cp1251")


@pytest.mark.posix
def test_names_of_another_encoding_are_read_and_printable(tmp_path) -> None:
    good = make(tmp_path / "drive.pcapng").read_bytes()
    folder = tmp_path / "in" / os.fsdecode(OLD_NAME)
    try:
        folder.mkdir(parents=True)
    except OSError:
        return  # macOS has no such names
    (folder / os.fsdecode(OLD_NAME + b".pcapng")).write_bytes(good)
    (folder / os.fsdecode(b"bad" + OLD_NAME + b".pcapng")).write_bytes(b"no")
    result = add_here(tmp_path / "in", to=tmp_path / "set")
    assert counts(result) == (1, 0, 0, 1)
    assert result.bad[0].file.endswith(r"/bad\udcc2\udcee\udceb\udce3\udce0.pcapng")
    ((name,),) = ask(tmp_path / "set", "SELECT file FROM drives")
    assert name == r"\udcc2\udcee\udceb\udce3\udce0.pcapng"
    assert counts(add_here(tmp_path / "in", to=tmp_path / "set")) == (0, 0, 1, 1)


def test_a_folder_that_cannot_be_read_is_named(tmp_path, monkeypatch) -> None:
    make(tmp_path / "in" / "drive.pcapng")
    (closed := tmp_path / "in" / "closed").mkdir()
    scandir = os.scandir

    def refusing(path):  # root may read every folder
        if path == str(closed):
            raise PermissionError(13, "Permission denied", str(closed))
        return scandir(path)

    monkeypatch.setattr(os, "scandir", refusing)
    result = add_here(tmp_path / "in", to=tmp_path / "set")
    assert counts(result) == (1, 0, 0, 1)
    assert result.bad[0].file == str(closed)
    assert result.bad[0].reason == ("Permission denied", "нет прав доступа")


class Host:
    """A file system like that of FTP: its names do not have the host."""

    def __init__(self) -> None:
        self.files = {"/in/a.pcapng": 5, "/in/deep/b.pcapng": 6, "/in/c.txt": 7}

    def invalidate_cache(self) -> None: ...

    def isfile(self, path: str) -> bool:
        return path in self.files

    def info(self, path: str) -> dict:
        return {"name": path, "size": self.files[path]}

    def find(self, path: str, *, detail: bool) -> dict:
        return {name: self.info(name) for name in self.files if name.startswith(f"{path}/")}


@pytest.mark.parametrize(
    ("place", "path", "urls"),
    [
        (
            "ftp://me:secret@host:2121/in/", "/in",
            ["ftp://me:secret@host:2121/in/a.pcapng", "ftp://me:secret@host:2121/in/deep/b.pcapng"],
        ),
        ("ftp://host", "", ["ftp://host/in/a.pcapng", "ftp://host/in/deep/b.pcapng"]),
        ("ftp://host/in/a.pcapng", "/in/a.pcapng", ["ftp://host/in/a.pcapng"]),
        (
            "zip://in::ftp://host/all.zip", "/in",
            ["zip://in/a.pcapng::ftp://host/all.zip", "zip://in/deep/b.pcapng::ftp://host/all.zip"],
        ),
        (
            "simplecache::ftp://host/in", "/in",
            ["simplecache::ftp://host/in/a.pcapng", "simplecache::ftp://host/in/deep/b.pcapng"],
        ),
    ],
)  # fmt: skip
def test_the_files_below_a_url_keep_its_host(monkeypatch, place, path, urls) -> None:
    monkeypatch.setattr("mikas.fleet.places.file_system", lambda _: (Host(), path))
    found = list(recordings_in(place))
    assert [file.url for file in found] == urls
    assert {type(file) for file in found} == {FoundFile}


def names_of_disk() -> list[str]:
    """All names that fsspec has for the folders of this computer."""
    every = known_implementations.items()
    own = {name for name, it in every if it["class"].endswith(".local.LocalFileSystem")}
    return sorted(own | set(LocalFileSystem.protocol))


def test_every_name_of_a_folder_of_this_computer_is_a_path(tmp_path) -> None:
    for name in names_of_disk():
        place = f"{name}://{tmp_path}"
        assert isinstance(store(place), DiskStore)
        assert as_path(place) == tmp_path


CHAINS = (
    *("simplecache::{}", "filecache::{}", "blockcache::{}", "cached::{}", "simplecache://::{}"),
    *("dir://::{}", "simplecache::dir://::{}", "asyncwrapper::{}"),
)


@pytest.mark.posix
def test_no_address_leads_through_a_link_to_a_folder(tmp_path) -> None:
    """`local://` was read, and written, through a link in place of `_ledger`."""
    make(tmp_path / "in" / "a.pcapng")
    add_here(tmp_path / "in", to=tmp_path / "set")
    (tmp_path / "set" / FOLDER).rename(tmp_path / "outside")
    (tmp_path / "set" / FOLDER).symlink_to(tmp_path / "outside")
    make(tmp_path / "new" / "b.pcapng", began=BEGAN + DAY)
    for name in names_of_disk():
        for chain in ("{}", *CHAINS):
            place = chain.format(f"{name}://{tmp_path / 'set'}")
            for use in (
                lambda to=place: ask(to, "FROM drives"),
                lambda to=place: add_here(tmp_path / "new", to=to),
            ):
                with pytest.raises(FleetError, match=r"link|by its path"):
                    use()
    assert len(list((tmp_path / "outside").iterdir())) == 1


def test_a_dataset_in_an_archive_of_this_computer_is_read(tmp_path) -> None:
    make(tmp_path / "in" / "a.pcapng")
    add_here(tmp_path / "in", to=tmp_path / "set")
    archive = make_archive(str(tmp_path / "all"), "zip", tmp_path, "set")
    assert ask(f"zip://set::file://{archive}", "SELECT count(*) FROM drives") == [(1,)]


def test_a_place_is_shown_without_its_secrets_and_in_utf_8() -> None:
    assert shown("sftp://me:secret@host/x") == "sftp://host/x"
    assert shown("/media/\udcc2.pcapng") == r"/media/\udcc2.pcapng"
