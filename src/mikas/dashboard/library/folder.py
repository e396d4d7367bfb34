"""The folder of recordings: its files by name, and the names of new ones.

An id is a file's name in the folder, and nothing else: no path, no link to elsewhere.
"""

from __future__ import annotations

import re
import stat
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from mikas.dashboard.errors import NotFound
from mikas.errors import CaptureError, reason_of

SUFFIX: Final = ".pcapng"
_UNFIT: Final = re.compile(r'[\x00-\x1f\x7f/\\:*?"<>|]+')
_RESERVED: Final = re.compile(r"(?i)(?:con|prn|aux|nul|com\d|lpt\d)(?:\.|$)")
_MAX_NAME: Final = 100
_MAX_SHOWN: Final = 60  # characters of an id that was not found


@dataclass(frozen=True, slots=True)
class RecordingFile:
    """One recording's file as it was found. `stamp` changes when the file does."""

    path: Path
    bytes: int
    stamp: tuple[int, int, int]

    @property
    def id(self) -> str:
        """The recording's name in the API."""
        return self.path.name


class RecordingFolder:
    """The recordings in `folder`, which need not exist. Any thread may call."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def all(self) -> list[RecordingFile]:
        """Return all recordings, the latest first."""
        try:
            paths = list(self.folder.iterdir())
        except OSError:  # nothing was recorded yet, or the drive is gone
            return []
        found = [it for path in paths if _is_name(path.name) and (it := _file_at(path))]
        return sorted(found, key=lambda it: (-it.stamp[0], it.id))

    def one(self, identity: str) -> RecordingFile:
        """Return the recording of that id. Raises `NotFound`."""
        if _is_name(identity) and (found := _file_at(self.folder / identity)):
            return found
        raise NotFound(name=identity[:_MAX_SHOWN])

    def new_path(self, name: str | None) -> Path:
        """Return the path of a new recording: of `name`, or of the date and time."""
        stem = file_stem(name) or time.strftime("%Y-%m-%d %H-%M-%S")
        path, number = self.folder / f"{stem}{SUFFIX}", 2
        while path.exists():
            path, number = self.folder / f"{stem} ({number}){SUFFIX}", number + 1
        return path

    def delete(self, file: RecordingFile) -> None:
        """Delete the file. Raises `CaptureError`."""
        try:
            file.path.unlink()
        except OSError as error:
            raise CaptureError(str(file.path), reason_of(error)) from error


def file_stem(name: str | None) -> str:
    """Return `name` as a file name without suffix; empty if no character of it fits."""
    fit = _UNFIT.sub(" ", name or "").removesuffix(SUFFIX)
    fit = fit.strip(" .")[:_MAX_NAME].strip(" .")
    return f"{fit}-" if _RESERVED.match(fit) else fit


def _is_name(name: str) -> bool:
    return name.endswith(SUFFIX) and not name.startswith(".") and not _UNFIT.search(name)


def _file_at(path: Path) -> RecordingFile | None:
    """Return the file at `path`; None for links and anything else."""
    try:
        status = path.lstat()
    except (OSError, ValueError):
        return None
    if not stat.S_ISREG(status.st_mode):
        return None
    return RecordingFile(path, status.st_size, (status.st_mtime_ns, status.st_size, status.st_ino))
