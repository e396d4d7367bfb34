"""Files in folders that others may write to, opened without a surprise.

A name in such a folder may be a link to a file elsewhere, a pipe that never answers, a device, or a
file of terabytes. Only a regular file is opened, and what was opened is checked, not only its name.
`follow`: the name was given by the user, who may mean a link. Windows has no flag that refuses a
link: there the name is checked before and compared with the opened file.

A file that has a second name (a hard link) is read, as copies of backups are, but not changed in
place: the other name may be in another folder.
"""

from __future__ import annotations

import errno
import hashlib
import os
import stat
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO, Final, Literal

from mikas.cleaning import clean_json
from mikas.errors import UnfitFile, UsageError
from mikas.i18n import Text

Mode = Literal["rb", "r+b", "a+b"]

_FLAGS: Final[dict[Mode, int]] = {
    "rb": os.O_RDONLY,
    "r+b": os.O_RDWR,
    "a+b": os.O_RDWR | os.O_APPEND | os.O_CREAT,
}
_NO_FOLLOW: Final[int] = getattr(os, "O_NOFOLLOW", 0)
_ALWAYS: Final[int] = sum(
    getattr(os, name, 0)
    for name in ("O_NONBLOCK", "O_CLOEXEC", "O_NOCTTY", "O_BINARY", "O_NOINHERIT")
)

ABSENT: Final = (FileNotFoundError, NotADirectoryError)
"""Errors of a path without a file; of the second kind where a folder of the path is none."""

_JUNCTION: Final = 0xA000_0003  # stat.IO_REPARSE_TAG_MOUNT_POINT, on Windows only

_LONGEST: Final = 255  # bytes of a name, of Cyrillic half as many letters

_LINK: Final = Text(
    "this is a link to another file, which is not followed; put the file itself here",
    "это ссылка на другой файл, по ней не переходят; положите сюда сам файл",
)
_FOLDER: Final = Text("this is a folder, not a file", "это папка, а не файл")
_NO_FILE: Final = Text(
    "this is a pipe or a device; only a file can be used here",
    "это канал или устройство; здесь нужен файл",
)
_TWO_NAMES: Final = Text(
    "this file has a second name (a hard link), so it is not changed; replace it by a copy",
    "у этого файла есть второе имя (жёсткая ссылка), поэтому он не изменяется; замените его копией",
)
_REPLACED: Final = Text(
    "another program has just replaced this file; try again",
    "другая программа только что заменила этот файл; попробуйте ещё раз",
)
_NO_CURRENT: Final = Text(
    "{name}: the current folder was removed; go to another one, or give the whole path",
    "{name}: текущая папка удалена; перейдите в другую или укажите путь целиком",
)
_TOO_LARGE: Final = Text(
    "the file is larger than {most} KB, the most that is read here",
    "файл больше {most} КБ, больше здесь не читается",
)


def open_regular(
    path: Path, mode: Mode = "rb", *, follow: bool = False, buffering: int = -1
) -> BinaryIO:
    """Open a regular file, never waiting. "a+b" creates a missing one.

    Raises `OSError`; `UnfitFile` for anything but a regular file, for a link unless `follow`, and
    for a change of a file that has a second name.
    """
    before = None
    try:
        before = path.stat(follow_symlinks=follow)
        _check(before, mode)  # opening a device may have effects
    except FileNotFoundError:
        if mode != "a+b":
            raise
    flags = _FLAGS[mode] | _ALWAYS | (0 if follow else _NO_FOLLOW)
    try:
        descriptor = os.open(path, flags, 0o666)
    except OSError as error:
        if error.errno == errno.ELOOP and not follow:  # a link since the check
            raise UnfitFile(errno.ELOOP, _LINK) from error
        raise
    try:
        after = os.fstat(descriptor)
        _check(after, mode)
        if not (_NO_FOLLOW or follow or before is None or os.path.samestat(before, after)):
            raise UnfitFile(errno.ELOOP, _REPLACED)
        return os.fdopen(descriptor, mode, buffering)
    except BaseException:
        os.close(descriptor)
        raise


def _check(status: os.stat_result, mode: Mode) -> None:
    """Raise `UnfitFile` unless this is a regular file, and one that may be changed."""
    check_regular(status)
    if mode != "rb" and status.st_nlink > 1:
        raise UnfitFile(errno.EMLINK, _TWO_NAMES)


def check_regular(status: os.stat_result) -> None:
    """Raise `UnfitFile` unless `status` is that of a regular file."""
    check_unlinked(status)
    if stat.S_ISDIR(status.st_mode):
        raise UnfitFile(errno.EISDIR, _FOLDER)
    if not stat.S_ISREG(status.st_mode):
        raise UnfitFile(errno.EINVAL, _NO_FILE)


def check_unlinked(status: os.stat_result) -> None:
    """Raise `UnfitFile` if `status` is that of a link: on Windows also a junction of folders."""
    if stat.S_ISLNK(status.st_mode) or getattr(status, "st_reparse_tag", 0) == _JUNCTION:
        raise UnfitFile(errno.ELOOP, _LINK)


def too_large(most: int) -> UnfitFile:
    """Return the error of a file that has more than `most` bytes."""
    return UnfitFile(errno.EFBIG, _TOO_LARGE.filled(most=most // 1024))


def read_regular(path: Path, most: int, *, follow: bool = False) -> bytes:
    """Return the content of a regular file of at most `most` bytes. Raises as `open_regular`."""
    with open_regular(path, follow=follow) as file:
        is_too_large = os.fstat(file.fileno()).st_size > most  # not read in vain at each request
        data = b"" if is_too_large else file.read(most + 1)
    if is_too_large or len(data) > most:
        raise too_large(most)
    return data


def read_json(path: Path, most: int) -> Any:  # noqa: ANN401  (any JSON)
    """Return the JSON in a regular file of at most `most` bytes, cleaned.

    Raises `OSError` as `open_regular`, and `ValueError` for anything but JSON that can be used.
    """
    import json

    try:
        return clean_json(json.loads(read_regular(path, most).decode()))
    except RecursionError:
        raise ValueError("nested too deep") from None


def beside(path: Path, ending: str) -> Path:
    """Return `path` with `ending` after its name, which is cut where the system would refuse it.

    A name that is cut has a digest of the whole, so two such files have two names.
    """
    name, room = os.fsencode(path.name), _LONGEST - len(os.fsencode(ending))
    if len(name) <= room:
        return path.with_name(f"{path.name}{ending}")
    mark = f"-{hashlib.sha256(name).hexdigest()[:8]}{ending}"
    kept = name[: _LONGEST - len(os.fsencode(mark))].decode("utf-8", "ignore")
    return path.with_name(f"{kept}{mark}")


def absolute(path: Path) -> Path:
    """Return the absolute path. Raises `UsageError` if the current folder was removed."""
    try:
        return path.absolute()
    except FileNotFoundError as error:
        raise UsageError(problem=_NO_CURRENT.filled(name=path)).caused_by(error, path) from error


def utf_8(path: Path) -> str:
    """Return a path for a library that takes UTF-8, whatever the locale. Raises `ValueError`."""
    return os.fsencode(path).decode()


def open_files() -> int:
    """Return how many files this process has open; 0 where the system does not list them."""
    try:
        return sum(1 for _ in Path("/dev/fd").iterdir())
    except OSError:
        return 0


def allow_open(count: int) -> int:
    """Let this process open `count` files at a time, as far as the system does; return how many."""
    try:
        import resource
    except ImportError:  # Windows, which has no such limit
        return count
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft == resource.RLIM_INFINITY:
        return count
    wanted = count if hard == resource.RLIM_INFINITY else min(count, hard)
    if soft < wanted:
        with suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
            soft = wanted
    return soft
