"""Places of recordings and of the dataset: a folder of this computer, or a URL of fsspec (`s3://…`).

What fails is a `FleetError` with the place, without the user's name and password that a URL may
hold. fsspec is imported for a URL and for questions only.
"""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from mikas.cleaning import LOCAL, SECRET_VARIABLES, public_url, secrets_of, without
from mikas.errors import (
    FleetError,
    MikasError,
    MissingExtra,
    UnfitFile,
    library,
    reason_of,
    system_error,
)
from mikas.files import absolute
from mikas.fleet.object_stores import (
    PROTOCOLS,
    is_bare,
    is_of_bucket,
    keys_in_files,
    options,
    reason_of_store,
)
from mikas.home import expanded
from mikas.i18n import Text
from mikas.recording.capture.opening import copy_plain, is_packed
from mikas.recording.capture.packed import packed_suffix

if TYPE_CHECKING:
    from fsspec import AbstractFileSystem

PARTS: Final = ".parts"  # unfinished files on a disk; readers of Parquet pass names with a dot over
_NO_NAME: Final = (errno.ENAMETOOLONG, errno.ELOOP, errno.EINVAL)  # no file can have such a name
_NOT_THERE: Final = Text("there is no such file or folder", "такого файла или папки нет")
_LINK: Final = Text(
    "this is a link to another file, which is not followed; name that file itself",
    "это ссылка на другой файл, по ней не переходят; назовите сам файл",
)
_BEHIND: Final = Text(
    "this address leads to a folder of this computer; name the folder by its path",
    "этот адрес ведёт в папку этого компьютера; назовите её путь",
)


class FoundFile(NamedTuple):
    """A file to add. `stamp` changes with its content; `bad`: why it is not read."""

    url: str
    bytes: int
    stamp: str
    bad: Text | None = None


def require_database(*, asked: bool = False) -> None:
    """Raise `MissingExtra` if a library that reads and writes a dataset is not installed. `asked`:
    there will be questions to it.
    """
    for name in ("duckdb", "fsspec") if asked else ("duckdb",):
        library(name, feature="fleet", extra="fleet")


def shown(place: str) -> str:
    """Return the place as it may be shown and kept: without a user's name and password, and in
    UTF-8, which the name of a file need not be.
    """
    return public_url(place).encode("utf-8", "backslashreplace").decode()


def is_utf_8(text: str) -> bool:
    """Return whether a text from the system can be written in UTF-8."""
    return text == text.encode("utf-8", "replace").decode()


def is_url(place: str) -> bool:
    """Return whether the place is a URL, not a path of this computer, which may have a prefix."""
    return "://" in place and not place.startswith(LOCAL)


def as_path(place: str) -> Path:
    """Return the absolute path of a place that is no URL."""
    prefix = next(filter(place.startswith, LOCAL), "")
    return absolute(expanded(place.removeprefix(prefix)))


@contextmanager
def errors_of(place: str) -> Iterator[None]:
    """Turn what storage raises into a `FleetError` that names `place`."""
    try:
        yield
    except (MikasError, KeyboardInterrupt):
        raise
    except Exception as error:  # each store's client has errors of its own
        if not isinstance(error, OSError) and not is_url(place):
            raise
        file = shown(place) if is_url(place) else None  # a store's own may have a password
        raise FleetError(place, reason_in_store(error)).caused_by(error, file) from error


def is_of_file(error: FleetError) -> bool:
    """Return whether not the place has failed, but one file of it is not what it should be."""
    cause = error.__cause__
    return isinstance(cause, UnfitFile | IsADirectoryError | NotADirectoryError) or (
        isinstance(cause, OSError) and cause.errno in _NO_NAME
    )


def reason_in_store(error: Exception) -> Text:
    """Return in words why a store has failed."""
    if reason := reason_of_store(error):
        return _scrubbed(reason)
    if isinstance(error, OSError):
        return _scrubbed(reason_of(error))
    words = str(error).partition("\n")[0] or type(error).__name__
    return _scrubbed(Text(words, words))


def _scrubbed(text: Text) -> Text:
    """Return a store's words without the secrets of the environment and of ~/.aws; `FleetError`
    leaves out those of the place.
    """
    of_environment = (os.environ.get(name, "") for name in SECRET_VARIABLES)
    secrets = secrets_of(*of_environment, *keys_in_files())
    return Text(*(without(words, secrets) for words in text))


_ODD: Final = re.compile(r"://[^/?#@]*:(?!\d*[/?#])[^/?#@]*[/?#][^@]*@")
_SIGNS: Final = Text(
    "signs like / # ? @ : % in a name or a password are written as %2F %23 %3F %40 %3A %25",
    "знаки / # ? @ : % в имени или пароле пишутся как %2F %23 %3F %40 %3A %25",
)


def file_system(place: str) -> tuple[AbstractFileSystem, str]:
    """Return the file system of a URL and the path in it. Raises `MissingExtra`, `FleetError`."""
    if _ODD.search(place):
        raise FleetError(place, _SIGNS)
    fsspec = library("fsspec.core", feature="fleet", extra="fleet")
    protocol = place.partition("://")[0]
    try:
        with errors_of(place):
            system, path = fsspec.url_to_fs(place, **options(place))
    except FleetError as error:
        cause = error.__cause__
        if isinstance(cause, ImportError) and protocol in PROTOCOLS:
            raise MissingExtra(feature="s3://", extra="s3") from cause
        raise
    if _is_of_disk(system):  # links in it would be followed
        raise FleetError(place, _BEHIND)
    return system, str(path).rstrip("/")


def _is_of_disk(system: AbstractFileSystem) -> bool:
    """Return whether a file system is this computer's, or passes all on to it, as a cache does."""
    inner: object = system
    while inner is not None:
        system = inner
        inner = getattr(system, "fs", None) or getattr(system, "sync_fs", None)
    return "file" in getattr(system, "protocol", ())


def info_of(system: AbstractFileSystem, path: str) -> Mapping[str, Any]:
    """Return what a file system says of a file. Raises `FileNotFoundError` only where there is
    none: for fsspec a web server's refusal is one, too, and so is its silence.
    """
    try:
        info: Mapping[str, Any] = system.info(path)
    except FileNotFoundError as error:
        cause = error.__cause__
        if cause is not None and _is_failure(cause):
            raise cause from None
        raise
    except OSError as error:
        if is_bare(error):  # the answer to a HEAD has no reason: that to a GET has one
            system.cat_file(path, start=0, end=1)
        raise
    return info


def _is_failure(cause: BaseException) -> bool:
    if isinstance(cause, OSError):
        return not isinstance(cause, FileNotFoundError)
    return is_of_bucket(cause) or getattr(cause, "status", 404) not in (404, 410)


def recordings_in(place: str) -> Iterator[FoundFile]:
    """Yield the recordings of a place: of a folder, and those below it, all `.pcapng`, and as bad
    ones the folders that can't be read; or the one file that it is.

    Raises `FleetError` if there is no such place.
    """
    with errors_of(place):
        yield from _of_url(place) if is_url(place) else _of_disk(place)


def _of_disk(place: str) -> Iterator[FoundFile]:
    top = as_path(place)
    if not top.is_dir():
        if not os.path.lexists(top):
            raise _absent(place)
        yield _on_disk(top.resolve())
        return

    closed: list[FoundFile] = []

    def refuse(error: OSError) -> None:
        if error.filename == str(top):
            raise error
        closed.append(FoundFile(error.filename, 0, "", bad=reason_of(error)))

    for folder, below, names in os.walk(top, onerror=refuse):
        below[:] = (name for name in below if name != PARTS)
        for name in names:
            if _is_recording(name):
                yield _on_disk(Path(folder, name))
    yield from closed


def _absent(place: str) -> FleetError:
    return FleetError(place, _NOT_THERE).caused_by(system_error(errno.ENOENT), public_url(place))


def _on_disk(path: Path) -> FoundFile:
    try:
        status = path.lstat()
    except OSError:  # gone since; reported when it is read
        return FoundFile(str(path), 0, "")
    stamp = f"{status.st_size}-{status.st_mtime_ns}"
    return FoundFile(str(path), status.st_size, stamp, bad=_LINK if path.is_symlink() else None)


def _of_url(place: str) -> Iterator[FoundFile]:
    system, path = file_system(place)
    system.invalidate_cache()
    if system.isfile(path):
        yield _at_url(place, system.info(path))
        return
    found = system.find(path, detail=True)
    if not found and not system.exists(path):
        raise _absent(shown(place))
    for name, info in sorted(found.items()):
        if _is_recording(name):
            yield _at_url(_url_in(place, path, name), info)


def _url_in(place: str, path: str, name: str) -> str:
    """Return the URL of a file below `place`, whose path is `path`: with the host of the place, and
    before what it is chained to (`zip://in::s3://bucket/all.zip`).
    """
    own = place.find("://") + 3
    end = place.find("::", own)
    end = len(place) if end < 0 else end
    below = name.removeprefix(path).lstrip("/")
    return "/".join((place[:end].rstrip("/"), below)) + place[end:]


def _at_url(url: str, info: dict[str, Any]) -> FoundFile:
    changed = next((info[key] for key in ("ETag", "mtime", "LastModified") if info.get(key)), "")
    size = int(info.get("size") or 0)
    stamp = f"{size}-{changed}" if changed else ""
    return FoundFile(url, size, stamp)


def _is_recording(name: str) -> bool:
    return name.lower().removesuffix(packed_suffix(name)).endswith(".pcapng")


@contextmanager
def as_local(url: str) -> Iterator[Path]:
    """Give the file at `url` as one of this computer; a remote one is copied for the time, and so
    is a packed one, unpacked: it is the same recording as the plain file.
    """
    with ExitStack() as closing:

        def folder() -> Path:
            made = TemporaryDirectory(prefix="mikas-", ignore_cleanup_errors=True)
            return Path(closing.enter_context(made))

        if is_url(url):
            system, path = file_system(url)
            local = folder() / (PurePosixPath(path).name or "recording.pcapng")
            with errors_of(url):
                system.get_file(path, str(local))
        else:
            local = as_path(url)
        packed = False
        with suppress(OSError):  # reported where it is read
            packed = is_packed(local)
        if packed:
            local = copy_plain(local, folder() / "recording.pcapng")
        yield local
