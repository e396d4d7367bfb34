"""Whole files by name in a place: each is written at once, so no reader sees a part of one.

On a disk that is a temporary name which is renamed, on an object store one put. What fails is a
`FleetError` with the place.
"""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath
from shutil import rmtree
from tempfile import TemporaryDirectory
from time import time
from typing import Final
from uuid import uuid4

from mikas.errors import FleetError
from mikas.fleet.places import PARTS, as_path, errors_of, file_system, is_url, is_utf_8, shown
from mikas.i18n import Text

_NOT_UTF_8: Final = Text(
    "the name of a dataset's folder must be UTF-8; choose another one",
    "имя папки набора должно быть в UTF-8; выберите другое",
)
_OLD: Final = 86_400.0  # s after which a part is a killed program's
_TIMES: Final = 5  # that a folder is read or made which another process changes
_OBJECT_STORES: Final = frozenset(
    ("s3", "s3a", "gs", "gcs", "abfs", "abfss", "az", "adl", "oci", "oss", "r2", "memory")
)


class Store(ABC):
    """The files of one place, by names with `/`."""

    def __init__(self, place: str) -> None:
        self.place = place

    @abstractmethod
    def read(self, name: str) -> bytes | None:
        """Return a file's content; None: there is no such file."""

    @abstractmethod
    def write(self, name: str, data: bytes) -> None:
        """Write a whole file at once, or replace it."""

    @abstractmethod
    def put(self, name: str, file: Path) -> None:
        """Write the content of `file`, at once; `file` may be gone afterwards."""

    @abstractmethod
    def remove(self, name: str) -> None:
        """Remove a file; a missing one is removed already."""

    @abstractmethod
    def names(self, folder: str) -> list[str]:
        """Return the names in a folder, sorted; none without it."""

    @contextmanager
    def workshop(self, run: str) -> Iterator[Path]:
        """Give a folder for unfinished files, from which `put` is quick; removed at the end.

        `run`: a name, for `clear`.
        """
        with TemporaryDirectory(prefix=f"mikas-{run}-", ignore_cleanup_errors=True) as folder:
            yield Path(folder)

    def contents(self, folder: str) -> dict[str, bytes]:
        """Return all files of a folder by name, as they were at one time."""
        for _ in range(_TIMES):
            names = self.names(folder)
            found = self._read_all(folder, names)
            if len(found) == len(names):  # else one was replaced meanwhile, by a name not listed
                break
        return found

    def _read_all(self, folder: str, names: list[str]) -> dict[str, bytes]:
        found = {name: self.read(f"{folder}/{name}") for name in names}
        return {name: data for name, data in found.items() if data is not None}

    @abstractmethod
    def missing(self, names: Iterable[str]) -> set[str]:
        """Return those of the names that no file has."""

    def clear(self, run: str) -> None:  # noqa: B027  (those of a URL are in temporary folders)
        """Remove the unfinished files of a run, whose processes may have been ended."""

    def tidy(self) -> None:  # noqa: B027  (an object store keeps no part of a put)
        """Remove what killed programs have left, a day later."""


class DiskStore(Store):
    """A folder of this computer."""

    def __init__(self, place: str) -> None:
        super().__init__(place)
        self.root = as_path(place)
        if not is_utf_8(str(self.root)):
            raise FleetError(shown(place), _NOT_UTF_8)

    def read(self, name: str) -> bytes | None:
        with errors_of(self.place), suppress(FileNotFoundError):
            return (self.root / name).read_bytes()
        return None

    def write(self, name: str, data: bytes) -> None:
        with errors_of(self.place):
            parts = self.root / PARTS
            parts.mkdir(parents=True, exist_ok=True)
            part = parts / uuid4().hex
            try:
                part.write_bytes(data)
                self._rename(part, name)
            finally:
                part.unlink(missing_ok=True)  # Ctrl-C may have come between

    def put(self, name: str, file: Path) -> None:
        with errors_of(self.place):
            self._rename(file, name)

    def remove(self, name: str) -> None:
        with errors_of(self.place):
            (self.root / name).unlink(missing_ok=True)
            with suppress(OSError):  # the folder of a car or a day that has no other file
                for folder in list(PurePosixPath(name).parents)[:-2]:
                    (self.root / folder).rmdir()

    def names(self, folder: str) -> list[str]:
        with errors_of(self.place), suppress(FileNotFoundError):
            return sorted(path.name for path in (self.root / folder).iterdir())
        return []

    @contextmanager
    def workshop(self, run: str) -> Iterator[Path]:
        folder = self.root / PARTS / f"{run}-{uuid4().hex}"
        with errors_of(self.place):
            folder.mkdir(parents=True)
        try:
            yield folder
        finally:
            rmtree(folder, ignore_errors=True)

    def missing(self, names: Iterable[str]) -> set[str]:
        with errors_of(self.place):
            return {name for name in names if not (self.root / name).is_file()}

    def clear(self, run: str) -> None:
        for left in (self.root / PARTS).glob(f"{run}-*"):
            rmtree(left, ignore_errors=True)

    def tidy(self) -> None:
        for left in (self.root / PARTS).glob("*"):
            with suppress(OSError):
                if time() - left.stat().st_mtime > _OLD:
                    rmtree(left, ignore_errors=True) if left.is_dir() else left.unlink()

    def _rename(self, part: Path, name: str) -> None:
        with part.open("rb+") as file:
            os.fsync(file.fileno())
        whole = self.root / name
        for _ in range(3):  # another add may just have removed an empty folder
            whole.parent.mkdir(parents=True, exist_ok=True)
            with suppress(FileNotFoundError):
                part.replace(whole)
                return
        part.replace(whole)


class UrlStore(Store):
    """A place of fsspec."""

    def __init__(self, place: str) -> None:
        super().__init__(place)
        self.system, self.root = file_system(place)
        protocol = self.system.protocol
        known = {protocol} if isinstance(protocol, str) else set(protocol)
        self.is_object_store = bool(known & _OBJECT_STORES)

    def read(self, name: str) -> bytes | None:
        with errors_of(self.place), suppress(FileNotFoundError):
            data: bytes = self.system.cat_file(self._at(name))
            return data
        return None

    def write(self, name: str, data: bytes) -> None:
        with self._target(name) as target:
            self.system.pipe_file(target, data)

    def put(self, name: str, file: Path) -> None:
        with self._target(name) as target:
            self.system.put_file(str(file), target)

    def remove(self, name: str) -> None:
        with errors_of(self.place), suppress(FileNotFoundError):
            self.system.rm_file(self._at(name))

    def names(self, folder: str) -> list[str]:
        with errors_of(self.place), suppress(FileNotFoundError):
            self.system.invalidate_cache()
            listed = self.system.ls(self._at(folder), detail=False)
            mine = self._at(folder).rstrip("/")  # as a console of S3 makes an empty folder
            return sorted(PurePosixPath(it).name for it in listed if it.rstrip("/") != mine)
        return []

    def _read_all(self, folder: str, names: list[str]) -> dict[str, bytes]:
        if not names:
            return {}
        with errors_of(self.place):  # many at a time where the store can
            paths = [self._at(f"{folder}/{name}") for name in names]
            found = self.system.cat(paths, on_error="return")
            for each in found.values():
                if isinstance(each, Exception) and not isinstance(each, FileNotFoundError):
                    raise each
            read = {PurePosixPath(path).name: data for path, data in found.items()}
            return {name: data for name, data in read.items() if isinstance(data, bytes)}

    def missing(self, names: Iterable[str]) -> set[str]:
        with errors_of(self.place):
            self.system.invalidate_cache()
            listed: set[str] = set()
            with suppress(FileNotFoundError):
                listed |= {it.removeprefix(f"{self.root}/") for it in self.system.find(self.root)}
            # A list may have names in another encoding: what it does not have is read.
            return {name for name in set(names) - listed if self.read(name) is None}

    def _at(self, name: str) -> str:
        return f"{self.root}/{name}"

    @contextmanager
    def _target(self, name: str) -> Iterator[str]:
        """Give the path to write a file to, which has its name once it is whole."""
        with errors_of(self.place):
            if self.is_object_store:
                yield self._at(name)
                return
            self._make_folder(self._at(str(PurePosixPath(name).parent)))
            part = f"{self._at(name)}.{uuid4().hex}.part"
            yield part
            self.system.mv(part, self._at(name))

    def _make_folder(self, path: str) -> None:
        for _ in range(_TIMES):
            self.system.invalidate_cache()
            with suppress(Exception):  # another process made a part of it; a write says the rest
                self.system.makedirs(path, exist_ok=True)
                return


def store(place: str) -> Store:
    """Return the store of a place. Raises `MissingExtra`, `FleetError`."""
    return UrlStore(place) if is_url(place) else DiskStore(place)
