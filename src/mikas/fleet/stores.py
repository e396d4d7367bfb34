"""Whole files by name in a place: each is written at once, so no reader sees a part of one.

On a disk that is a temporary name which is renamed, on an object store one put. What fails is a
`FleetError` with the place. What lies in a place may be a stranger's: no link in it is followed,
neither for reading nor for writing nor for removing, and no file is read beyond a size.
"""

from __future__ import annotations

import errno
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path, PurePosixPath
from shutil import rmtree
from stat import S_ISDIR
from tempfile import TemporaryDirectory
from time import time
from typing import Any, Final
from uuid import uuid4

from mikas.errors import FleetError, UnfitFile
from mikas.files import check_regular, check_unlinked, read_regular, too_large, utf_8
from mikas.fleet.places import (
    PARTS,
    as_path,
    errors_of,
    file_system,
    info_of,
    is_of_file,
    is_url,
    shown,
)
from mikas.i18n import Text

_NOT_UTF_8: Final = Text(
    "the name of a dataset's folder must be UTF-8; choose another one",
    "имя папки набора должно быть в UTF-8; выберите другое",
)
_GONE: Final = Text("{name}: there is no such file", "{name}: такого файла нет")
_NO_FILE: Final = Text("this is no file", "это не файл")
_UNFIT: Final = Text("{name}: {reason}", "{name}: {reason}")
_OLD: Final = 86_400.0  # s after which a part is a killed program's
_TIMES: Final = 5  # that a folder is read or made which another process changes
_OBJECT_STORES: Final = frozenset(
    ("s3", "s3a", "gs", "gcs", "abfs", "abfss", "az", "adl", "oci", "oss", "r2", "memory")
)


@dataclass(frozen=True, slots=True)
class FolderContents:
    """The files of a folder by name, and why others of it can't be used."""

    files: dict[str, bytes] = field(default_factory=dict)
    unfit: dict[str, Text] = field(default_factory=dict)

    def add(self, name: str, data: bytes | None) -> None:
        if data is not None:
            self.files[name] = data


class Store(ABC):
    """The files of one place, by names with `/`."""

    def __init__(self, place: str) -> None:
        self.place = place

    @abstractmethod
    def read(self, name: str, most: int) -> bytes | None:
        """Return a file's content, at most `most` bytes; None: there is no such file."""

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

    def contents(self, folder: str, suffix: str, most: int) -> FolderContents:
        """Return the files of a folder with such names, as they were at one time."""
        for _ in range(_TIMES):
            names = [name for name in self.names(folder) if name.endswith(suffix)]
            found = self._read_all(folder, names, most)
            if len(found.files) + len(found.unfit) == len(names):
                break  # else one was replaced meanwhile, by a name not listed
        return found

    def _read_all(self, folder: str, names: list[str], most: int) -> FolderContents:
        found = FolderContents()
        for name in names:
            try:
                data = self.read(f"{folder}/{name}", most)
            except FleetError as error:
                if not is_of_file(error):
                    raise
                found.unfit[name] = error.problem
            else:
                found.add(name, data)
        return found

    @abstractmethod
    def sizes(self, names: Iterable[str], most: int) -> Mapping[str, int | Text]:
        """Return the size of each file, or why it can't be used: none there, a link, too large."""

    def clear(self, run: str) -> None:  # noqa: B027  (those of a URL are in temporary folders)
        """Remove the unfinished files of a run, whose processes may have been ended."""

    def tidy(self) -> None:  # noqa: B027  (an object store keeps no part of a put)
        """Remove what killed programs have left, a day later."""


class DiskStore(Store):
    """A folder of this computer."""

    def __init__(self, place: str) -> None:
        super().__init__(place)
        self.root: Path = as_path(place)
        try:
            utf_8(self.root)
        except ValueError:
            raise FleetError(shown(place), _NOT_UTF_8) from None

    def read(self, name: str, most: int) -> bytes | None:
        with self._errors_of(name), suppress(FileNotFoundError):
            return read_regular(self._at(name), most)
        return None

    def write(self, name: str, data: bytes) -> None:
        with self._errors_of(name):
            part = self._made(PARTS) / uuid4().hex
            try:
                with part.open("xb") as file:
                    file.write(data)
                self._rename(part, name)
            finally:
                part.unlink(missing_ok=True)  # Ctrl-C may have come between

    def put(self, name: str, file: Path) -> None:
        with self._errors_of(name):
            self._rename(file, name)

    def remove(self, name: str) -> None:
        with self._errors_of(name), suppress(FileNotFoundError):
            self._at(name).unlink()
            with suppress(OSError):  # the folder of a car or a day that has no other file
                for folder in list(PurePosixPath(name).parents)[:-2]:
                    (self.root / folder).rmdir()

    def names(self, folder: str) -> list[str]:
        with self._errors_of(folder), suppress(FileNotFoundError):
            return sorted(path.name for path in self._at(folder, is_folder=True).iterdir())
        return []

    @contextmanager
    def workshop(self, run: str) -> Iterator[Path]:
        with self._errors_of(PARTS):
            folder = self._made(PARTS) / f"{run}-{uuid4().hex}"
            folder.mkdir()
        try:
            yield folder
        finally:
            rmtree(folder, ignore_errors=True)

    def sizes(self, names: Iterable[str], most: int) -> Mapping[str, int | Text]:
        found: dict[str, int | Text] = {}
        checked = self._checked()
        for name in names:
            folder, _, whole = name.rpartition("/")
            try:
                with self._errors_of(name):
                    status = (checked(folder) / whole).lstat()
                    check_regular(status)
                    if status.st_size > most:
                        raise too_large(most)
                    found[name] = status.st_size
            except FleetError as error:
                if isinstance(error.__cause__, FileNotFoundError):
                    found[name] = _GONE.filled(name=name)
                elif is_of_file(error):
                    found[name] = error.problem
                else:  # the place fails, which says nothing of the file
                    raise
        return found

    def clear(self, run: str) -> None:
        for left in self._parts(f"{run}-*"):
            rmtree(left, ignore_errors=True)

    def tidy(self) -> None:
        for left in self._parts("*"):
            with suppress(OSError):
                status = left.lstat()
                if time() - status.st_mtime > _OLD:
                    rmtree(left, ignore_errors=True) if S_ISDIR(status.st_mode) else left.unlink()

    def _parts(self, pattern: str) -> list[Path]:
        with suppress(OSError):
            return list(self._at(PARTS, is_folder=True).glob(pattern))
        return []

    @contextmanager
    def _errors_of(self, name: str) -> Iterator[None]:
        """Name the file, too, where the place is fine and the file is not what it should be."""
        try:
            with errors_of(self.place):
                yield
        except FleetError as error:
            if is_of_file(error):
                problem = _UNFIT.filled(name=name, reason=error.problem)
                raise FleetError(error.place, problem).caused_by(error) from error.__cause__
            raise

    def _at(self, name: str, *, is_folder: bool = False) -> Path:
        """Return the path of a file. Raises `UnfitFile` if a folder of it is a link."""
        folder, _, whole = name.rpartition("/")
        checked = self._checked()
        return checked(name) if is_folder else checked(folder) / whole

    def _checked(self) -> Callable[[str], Path]:
        """Return what gives the path of a folder, and looks at each folder once."""

        @cache
        def checked(name: str) -> Path:
            if not name:
                return self.root
            above, _, own = name.rpartition("/")
            path = checked(above) / own
            check_unlinked(path.lstat())
            return path

        return checked

    def _made(self, name: str) -> Path:
        """Make a folder and those above it, through no link below the place; return its path."""
        self.root.mkdir(parents=True, exist_ok=True)
        path = self.root
        for part in PurePosixPath(name).parts:
            path /= part
            with suppress(FileExistsError):
                path.mkdir()
            check_unlinked(path.lstat())
        return path

    def _rename(self, part: Path, name: str) -> None:
        with part.open("rb+") as file:
            os.fsync(file.fileno())
        folder, _, whole = name.rpartition("/")
        for _ in range(3):  # another add may just have removed an empty folder
            with suppress(FileNotFoundError):
                part.replace(self._made(folder) / whole)
                return
        part.replace(self._at(name))


class UrlStore(Store):
    """A place of fsspec."""

    system: Any  # fsspec carries no types
    root: str

    def __init__(self, place: str) -> None:
        super().__init__(place)
        self.system, self.root = file_system(place)
        names = self.system.protocol
        names = (names,) if isinstance(names, str) else names
        self.is_object_store: bool = not _OBJECT_STORES.isdisjoint(names)

    def read(self, name: str, most: int) -> bytes | None:
        with errors_of(self.place), suppress(FileNotFoundError):
            self.system.invalidate_cache()
            _size_of(info_of(self.system, self._at(name)), most)
            return bytes(self.system.cat_file(self._at(name)))
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

    def _read_all(self, folder: str, names: list[str], most: int) -> FolderContents:
        found = FolderContents()
        if not names:
            return found
        with errors_of(self.place):  # many at a time where the store can
            listed = self.system.ls(self._at(folder), detail=True)
            sizes = {PurePosixPath(info["name"]).name: info for info in listed}
            paths = []
            for name in names:
                try:
                    self._size(f"{folder}/{name}", sizes.get(name), most)
                except FileNotFoundError:  # replaced meanwhile
                    pass
                except UnfitFile as error:
                    found.unfit[name] = error.text
                else:
                    paths.append(self._at(f"{folder}/{name}"))
            for path, data in (self.system.cat(paths, on_error="return") if paths else {}).items():
                if not isinstance(data, Exception):
                    found.add(PurePosixPath(path).name, data)
                elif not isinstance(data, FileNotFoundError):
                    raise data
        return found

    def sizes(self, names: Iterable[str], most: int) -> Mapping[str, int | Text]:
        found: dict[str, int | Text] = {}
        with errors_of(self.place):
            self.system.invalidate_cache()
            listed: dict[str, dict[str, Any]] = {}
            with suppress(FileNotFoundError):
                every = self.system.find(self.root, detail=True)
                listed = {path.removeprefix(f"{self.root}/"): info for path, info in every.items()}
            for name in set(names):
                try:
                    found[name] = self._size(name, listed.get(name), most)
                except FileNotFoundError:
                    found[name] = _GONE.filled(name=name)
                except UnfitFile as error:
                    found[name] = _UNFIT.filled(name=name, reason=error.text)
        return found

    def _at(self, name: str) -> str:
        return f"{self.root}/{name}"

    def _size(self, name: str, listed: Mapping[str, Any] | None, most: int) -> int:
        """Return the size of a file: of a list of files, which may have names in another encoding,
        or no sizes, as a web server's; what it lacks is asked for.
        """
        if listed is None or listed.get("size") is None:
            listed = info_of(self.system, self._at(name))
        return _size_of(listed, most)

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


def _size_of(info: Mapping[str, Any], most: int) -> int:
    """Return the size of a store's file. Raises `UnfitFile` for more than `most` bytes."""
    if info.get("type", "file") != "file":
        raise UnfitFile(errno.EINVAL, _NO_FILE)
    size = int(info.get("size") or 0)
    if size > most:
        raise too_large(most)
    return size


def store(place: str) -> Store:
    """Return the store of a place. Raises `MissingExtra`, `FleetError`."""
    return UrlStore(place) if is_url(place) else DiskStore(place)
