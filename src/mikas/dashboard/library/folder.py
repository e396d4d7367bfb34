"""The folder of recordings: which there are, by name, and what can be done to one as a file.

An id is a file's name in the folder, and nothing else: no path, no link to elsewhere. What a
recording says of itself is summed up once and remembered until its file changes: a recording of ten
hours is not read again for every list.
"""

from __future__ import annotations

import os
import re
import stat
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Generic, TypeVar

from mikas.dashboard.errors import NotFound
from mikas.dashboard.session.recorder import SUFFIX

T = TypeVar("T")

_NO_NAME: Final = re.compile(r'[\x00-\x1f\x7f/\\:*?"<>|]')
_SHOWN: Final = 60  # of a name that was asked for in vain


@dataclass(frozen=True, slots=True)
class Shelved:
    """One recording's file as it was found. `stamp`: changes when the file does."""

    path: Path
    bytes: int
    stamp: tuple[int, int, int]

    @property
    def id(self) -> str:
        """Its name in the API."""
        return self.path.name


class Shelf:
    """The recordings in `folder`, which need not exist. Any thread may ask."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def all(self) -> list[Shelved]:
        """The latest first."""
        found = list(self._found())
        return sorted(found, key=lambda it: (-it.stamp[0], it.id))

    def one(self, identity: str) -> Shelved:
        """The recording of that id. Raises `NotFound`."""
        if _is_name(identity) and (it := _shelved(self.folder / identity)):
            return it
        raise NotFound(name=identity[:_SHOWN])

    def _found(self) -> Iterator[Shelved]:
        try:
            names = [entry.name for entry in os.scandir(self.folder)]
        except OSError:  # nothing was recorded yet, or the stick is gone
            return
        for name in names:
            if _is_name(name) and (it := _shelved(self.folder / name)):
                yield it


def _is_name(name: str) -> bool:
    return name.endswith(SUFFIX) and not name.startswith(".") and not _NO_NAME.search(name)


def _shelved(path: Path) -> Shelved | None:
    """What is at `path`, if it is a file there itself."""
    try:
        status = path.lstat()
    except (OSError, ValueError):
        return None
    if not stat.S_ISREG(status.st_mode):
        return None
    return Shelved(path, status.st_size, (status.st_mtime_ns, status.st_size, status.st_ino))


class Remembered(Generic[T]):
    """What was made of each file, until the file changes; made by one thread at a time."""

    def __init__(self, make: Callable[[Path], T]) -> None:
        self._make = make
        self._kept: dict[str, tuple[tuple[int, int, int], T]] = {}
        self._making = threading.Lock()

    def of(self, it: Shelved) -> T:
        """What `make` returns for it, now or some time ago."""
        kept = self._kept.get(it.id)
        if kept is None or kept[0] != it.stamp:
            with self._making:
                kept = self._kept.get(it.id)
                if kept is None or kept[0] != it.stamp:
                    kept = (it.stamp, self._make(it.path))
                    self._kept[it.id] = kept
        return kept[1]

    def forget_all_but(self, there: list[Shelved]) -> None:
        """Forgets the files that are gone."""
        names = {it.id for it in there}
        for name in [name for name in self._kept if name not in names]:
            self._kept.pop(name, None)
