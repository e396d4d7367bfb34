"""Which files are being written, known to every program on this computer.

A writer holds a lock on its open file until it is closed. The system drops the lock of a program
that is killed, so none is left behind. The lock keeps nothing but another writer away: on Linux and
Windows it is on a byte far past the file's end, elsewhere on the file as a whole, which readers
do not ask for. Where there are no locks (a browser, some file systems), no file counts as held.
"""

from __future__ import annotations

import errno
import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO, Final

from mikas.cleaning import clean_line, secrets_of, without
from mikas.errors import UnfitFile
from mikas.files.regular import open_regular
from mikas.i18n import Text

_FAR: Final = 1 << 40  # no recording is so long
_TAKEN: Final = (errno.EAGAIN, errno.EACCES, errno.EWOULDBLOCK)
_MAX_COMMAND: Final = 60  # characters
_WRITTEN: Final = Text(
    "another program is writing to this file{who}; wait for its end, or end it there, first",
    "в этот файл сейчас пишет другая программа{who}; сначала дождитесь её конца или завершите её",
)


def hold(file: BinaryIO) -> None:
    """Mark an open file as being written, until it is closed.

    Raises `UnfitFile` if another program, or another part of this one, holds it.
    """
    if not _locked(file.fileno()):
        raise UnfitFile(errno.EBUSY, _refusal(file))


def writer_of(path: Path) -> Text | None:
    """Return why the file at `path` must stay as it is: it is held; None: it is not."""
    try:
        file = open_regular(path)
    except OSError:  # it can't be looked at
        return None
    with file:
        return None if _is_free(file.fileno()) else _refusal(file)


def check_free(path: Path) -> None:
    """Raise `UnfitFile` if the file at `path` is held."""
    if held := writer_of(path):
        raise UnfitFile(errno.EBUSY, held)


def _refusal(file: BinaryIO) -> Text:
    who = _writer(os.fstat(file.fileno()))
    return _WRITTEN.filled(who=f" ({who})" if who else "")


def _writer(status: os.stat_result) -> str:
    """Return the command of the other process that has the file open to write; empty: not known.

    Linux alone says it, of the processes of the same user.
    """
    for process in Path("/proc").glob("[0-9]*"):
        if process.name == str(os.getpid()):
            continue
        with suppress(OSError):
            for opened in (process / "fd").iterdir():
                with suppress(OSError, ValueError):
                    if os.path.samestat(opened.stat(), status) and _writes(process, opened.name):
                        return f"{_command(process)}, PID {process.name}"
    return ""


def _writes(process: Path, number: str) -> bool:
    words = (process / "fdinfo" / number).read_text("utf-8").split()
    return int(words[words.index("flags:") + 1], 8) & (os.O_WRONLY | os.O_RDWR) != 0


def _command(process: Path) -> str:
    """Return a process's command without the Python that runs it, and without the secrets of its
    addresses: a client from the network reads it, too.
    """
    words = (process / "cmdline").read_bytes().decode("utf-8", "replace").split("\0")
    while len(words) > 1 and (words[0] == "-m" or Path(words[0]).name.startswith("python")):
        del words[0]
    command = " ".join([Path(words[0]).name, *words[1:]]).strip()
    values = [word.partition("=")[2] if word.startswith("--") else word for word in words]
    secrets = frozenset().union(*(secrets_of(place=it, port=it) for it in values))
    return clean_line(without(command, secrets), _MAX_COMMAND)


if sys.platform == "win32":

    def _locked(descriptor: int) -> bool:
        import msvcrt

        return _at_far_byte(descriptor, msvcrt.LK_NBLCK)

    def _is_free(descriptor: int) -> bool:
        import msvcrt

        return _locked(descriptor) and _at_far_byte(descriptor, msvcrt.LK_UNLCK)

    def _at_far_byte(descriptor: int, mode: int) -> bool:
        import msvcrt

        place = os.lseek(descriptor, 0, os.SEEK_CUR)
        try:
            os.lseek(descriptor, _FAR, os.SEEK_SET)
            msvcrt.locking(descriptor, mode, 1)
        except OSError as error:
            return error.errno not in _TAKEN
        finally:
            os.lseek(descriptor, place, os.SEEK_SET)
        return True
elif sys.platform == "linux":
    # Locks of an open file: those of a process would end with any other reader of its own.

    def _locked(descriptor: int) -> bool:
        import fcntl

        try:
            fcntl.fcntl(descriptor, fcntl.F_OFD_SETLK, _far_byte())
        except OSError as error:
            return error.errno not in _TAKEN
        return True

    def _is_free(descriptor: int) -> bool:
        import fcntl
        import struct

        try:
            found = fcntl.fcntl(descriptor, fcntl.F_OFD_GETLK, _far_byte())
        except OSError:
            return True
        return bool(struct.unpack_from("h", found)[0] == fcntl.F_UNLCK)

    def _far_byte() -> bytes:
        """Return C's `struct flock`."""
        import fcntl
        import struct

        return struct.pack("hhqqi", fcntl.F_WRLCK, os.SEEK_SET, _FAR, 1, 0)
else:

    def _locked(descriptor: int) -> bool:
        try:
            import fcntl

            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except ImportError:  # a browser has none
            return True
        except OSError as error:
            return error.errno not in _TAKEN
        return True

    def _is_free(descriptor: int) -> bool:
        return _locked(descriptor)  # as long as it is open: a moment
