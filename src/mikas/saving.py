"""Files of the program's own, written whole: whatever stops it, the old content or the new one.

`save` and `save_json` replace a file, `append_line` adds to one. On return the content is on the
disk, also if the power fails then. A program that is killed may leave `NAME.new`, which no reader
takes for NAME and the next `save` removes.
"""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

from mikas.errors import UsageError, reason_at
from mikas.files import open_regular


def save(path: Path, text: str, *, follow: bool = False, private: bool = False) -> None:
    """Replace the content of `path` by `text`, in UTF-8, all or nothing. Raises `OSError`.

    A link or a pipe is replaced by a file; nothing is written through it. `follow`: the user named
    the path, so a pipe or a device is written to. `private`: only its owner can read the file, from
    its first byte on (POSIX).
    """
    if follow and path.exists() and not path.is_file():
        path.write_text(text, "utf-8")
        return
    new = path.with_name(f"{path.name}.new")
    new.unlink(missing_ok=True)  # of a killed program
    try:
        if private:
            new.touch(0o600, exist_ok=False)
        with new.open("w" if private else "x", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        new.replace(path)
    except BaseException:
        with suppress(OSError):
            new.unlink(missing_ok=True)
        raise
    _settle(path.parent)


def save_json(path: Path, value: object) -> None:
    """Replace a file of the user's data by `value` as JSON, and make its folder.

    One thread at a time may save the same file. Raises `UsageError` with the file and the reason.
    """
    import json

    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        save(path, json.dumps(value, ensure_ascii=False, indent=1))
    except OSError as error:
        raise UsageError(problem=reason_at(path, error)) from error


def append_line(path: Path, line: str) -> None:
    """Append `line`, in UTF-8, all or nothing, and on a line of its own. Raises `OSError`.

    Halves of surrogate pairs become escapes, which JSON has too. A last line without its end, of a
    killed program, gets it first.
    """
    data = f"{line}\n".encode("utf-8", "backslashreplace")
    with open_regular(path, "a+b", buffering=0) as file:
        begin = file.seek(0, os.SEEK_END)
        if begin:
            file.seek(begin - 1)
            data = data if file.read(1) == b"\n" else b"\n" + data
        try:
            write_all(file, data)
            os.fsync(file.fileno())
        except OSError:
            with suppress(OSError):
                if file.seek(0, os.SEEK_END) <= begin + len(data):  # no other program's lines
                    file.truncate(begin)
            raise
    if not begin:
        _settle(path.parent)


def write_all(file: BinaryIO, data: bytes) -> None:
    """Write `data` to an unbuffered file, which may take less at a time."""
    rest = memoryview(data)
    while rest:
        rest = rest[file.write(rest) :]


def _settle(folder: Path) -> None:
    """Have the folder's entries on the disk, where the system lets a folder be opened (POSIX)."""
    with suppress(OSError):
        opened = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)
