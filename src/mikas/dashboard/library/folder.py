"""The folder of recordings: its files by name, and the names of new ones.

An id is a file's name in the folder, and nothing else: no path, no link to elsewhere. Others may
write to the folder: anything but a regular file with a usable name is left out with its reason,
and the number of files is bounded.

A name made here is a file on every system, also once it is copied to another one: Linux counts 255
bytes, Windows reserves characters and the names of devices, and drops dots and spaces at the end.
Nor does it look like another name or like an option of a command.
"""

from __future__ import annotations

import errno
import os
import re
import time
import unicodedata
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import BinaryIO, Final, NamedTuple

from mikas.cleaning import REPLACEMENT, clean_line
from mikas.dashboard.errors import NotFound
from mikas.errors import (
    CaptureError,
    UnfitFile,
    reason_of,
    unusable_file,
)
from mikas.files import check_regular, open_regular
from mikas.files.locks import check_free
from mikas.i18n import Text
from mikas.recording.capture.packed import packed_suffix

SUFFIX: Final = ".pcapng"
_MAX_SHOWN: Final = 60  # characters of an id that was not found
_MOST_SEEN: Final = 100_000  # names of a folder that are looked at
_MOST_LISTED: Final = 2000
_MOST_SAID: Final = 20  # files left out, each with its reason

_SEPARATORS: Final = r'[/\\:*?"<>|]'
_UNFIT: Final = re.compile(rf"(?:{_SEPARATORS}|[\s{REPLACEMENT}])+")
# With all behind a dot. Windows takes the superscripts for digits, and drops spaces.
_DEVICE: Final = re.compile(
    r"(?i)^(con|prn|aux|nul|conin\$|conout\$|(?:com|lpt)[0-9\u00b9\u00b2\u00b3])(?=\s*(?:\.|$))"
)
_JOINERS: Final = "\u200c\u200d"  # in Persian, and in emoji
_ENDS: Final = f" .{_JOINERS}"
_BEGINS: Final = f"{_ENDS}-~"  # a hidden file, an option, a home folder
_MOST_GIVEN: Final = 1000  # characters of a name that are looked at
_MOST_CHARACTERS: Final = 100
_MOST_BYTES: Final = 200  # of 255; the rest is for ` (12).pcapng.part`
_MOST_FOUND: Final = 240  # bytes of a name in a folder; the program adds `.json.new`

_NAME: Final = Text(
    "the name has characters that can't be shown or used, or is too long; rename the file",
    "в имени есть знаки, которые нельзя показать, или оно слишком длинное; переименуйте файл",
)
_PACKED: Final = Text(
    "the file is packed; unpack it in this folder",
    "файл сжат; распакуйте его в этой папке",
)
_OLDER: Final = Text(
    "older files that are not listed: {count}; move some to another folder",
    "старых файлов, которых нет в списке: {count}; перенесите часть в другую папку",
)
_MORE: Final = Text(
    "more files that can't be used here: {count}", "ещё файлов, которые здесь не годятся: {count}"
)


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


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A file that is not listed, and why. `name`: to be shown only; empty: not of one file."""

    name: str
    problem: Text


class Listing(NamedTuple):
    """The files of a folder, the latest first."""

    files: list[RecordingFile]
    left_out: list[LeftOut]


def files_in(folder: Path, suffix: str, most: int) -> Listing:
    """Return the regular files with this suffix, at most `most`; none if there is no folder."""
    left_out: list[LeftOut] = []
    found: list[tuple[int, str]] = []
    unfit = 0
    for entry in _entries(folder, suffix):
        try:
            status = entry.stat(follow_symlinks=False)
            check_regular(status)
            if not entry.name.endswith(suffix):
                raise UnfitFile(errno.EINVAL, _PACKED)
            if not is_file_name(entry.name, suffix):
                raise UnfitFile(errno.EINVAL, _NAME)
            found.append((-status.st_mtime_ns, entry.name))
        except FileNotFoundError:
            continue  # deleted meanwhile
        except OSError as error:
            unfit += 1
            if unfit <= _MOST_SAID:
                left_out.append(LeftOut(clean_line(entry.name, 100), reason_of(error)))
    for text, count in ((_MORE, unfit - _MOST_SAID), (_OLDER, len(found) - most)):
        if count > 0:
            left_out.append(LeftOut("", text.filled(count=count)))
    files = []
    for _, name in sorted(found)[:most]:
        with suppress(OSError):  # deleted meanwhile
            files.append(_file_at(folder / name))  # on Windows an entry does not know all of it
    return Listing(files, left_out)


def _entries(folder: Path, suffix: str) -> Iterator[os.DirEntry[str]]:
    """Yield the entries with this suffix, and packed ones; hidden files are somebody's own."""
    try:
        with os.scandir(folder) as entries:
            for entry in islice(entries, _MOST_SEEN):
                is_one = entry.name.endswith(suffix) or packed_suffix(entry.name)
                if is_one and not entry.name.startswith("."):
                    yield entry
    except OSError:  # nothing was kept yet, or the drive is gone
        return


@dataclass(frozen=True, slots=True)
class RecordingFolder:
    """The recordings in `folder`, which need not exist. Any thread may call."""

    folder: Path

    def all(self) -> Listing:
        """Return the latest recordings, the latest first."""
        return files_in(self.folder, SUFFIX, _MOST_LISTED)

    def one(self, identity: str) -> RecordingFile:
        """Return the recording of that id. Raises `NotFound`."""
        if is_file_name(identity, SUFFIX):
            try:
                return _file_at(self.folder / identity)
            except (OSError, ValueError):
                pass
        raise NotFound(name=clean_line(identity, _MAX_SHOWN))

    def new_path(self, name: str | None) -> Path:
        """Return the path of a new recording: of `name`, or of the date and time."""
        stem = file_stem(name, SUFFIX) or time.strftime("%Y-%m-%d %H-%M-%S")
        path, number = self.folder / f"{stem}{SUFFIX}", 2
        while os.path.lexists(path):
            path, number = self.folder / f"{stem} ({number}){SUFFIX}", number + 1
        return path

    def delete(self, file: RecordingFile) -> None:
        """Delete the file. Raises `CaptureError`, also if another program is recording to it."""
        try:
            check_free(file.path)
            file.path.unlink()
        except OSError as error:
            failed = CaptureError(str(file.path), reason_of(error))
            raise failed.caused_by(error, file.path) from error


def opened(path: Path, identity: str) -> BinaryIO:
    """Open a kept file to read it. Raises `NotFound` if it is gone, else `UsageError`."""
    try:
        return open_regular(path)
    except FileNotFoundError:
        raise NotFound(name=identity) from None
    except OSError as error:
        raise unusable_file(path, error) from error


def _file_at(path: Path) -> RecordingFile:
    """Return the file at `path`. Raises `OSError`, for links and anything else."""
    status = path.lstat()
    check_regular(status)
    return RecordingFile(path, status.st_size, (status.st_mtime_ns, status.st_size, status.st_ino))


def file_stem(name: str | None, suffix: str) -> str:
    """Return `name` as a file name without `suffix`; empty if no character of it fits."""
    fit = unicodedata.normalize("NFC", clean_line(name or "", _MOST_GIVEN))
    fit = "".join(each for each in fit if each in _JOINERS or unicodedata.category(each) != "Cf")
    fit = _UNFIT.sub(" ", fit).strip(_ENDS).removesuffix(suffix).lstrip(_BEGINS)
    fit = fit[:_MOST_CHARACTERS].encode()[:_MOST_BYTES].decode(errors="ignore").strip(_ENDS)
    return _DEVICE.sub(r"\1-", fit)


def is_file_name(name: str, suffix: str) -> bool:
    """Whether a file of this name is used: it can be shown as it is, and is no path."""
    return (
        name.endswith(suffix)
        and not name.startswith(".")
        and clean_line(name) == name
        and not re.search(_SEPARATORS, name)
        and len(name.encode()) <= _MOST_FOUND
    )
