"""Files of the program's own, written whole: whatever stops it, the old content or the new one.

`save` and `save_json` replace a file, `append_line` adds to one. On return the content is on the
disk, also if the power fails then. A program that is killed may leave `NAME.new`, which no reader
takes for NAME and the next `save` removes.

`KeptFile`: what the user has made. Such a file that can't be used (edited by hand, of a damaged
disk) counts as empty, but no save replaces it: it is renamed to `NAME.broken` first.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any, BinaryIO, Generic, TypeVar

from mikas.errors import naming_file, reason_at
from mikas.files import ABSENT, beside, open_regular, read_json
from mikas.i18n import Text

Content = TypeVar("Content")
_UNFIT = (ValueError, TypeError)


def save(path: Path, text: str, *, follow: bool = False, private: bool = False) -> None:
    """Replace the content of `path` by `text`, in UTF-8, all or nothing. Raises `OSError`.

    A link or a pipe is replaced by a file; nothing is written through it. `follow`: the user named
    the path, so a pipe or a device is written to. `private`: only its owner can read the file, from
    its first byte on (POSIX).
    """
    if follow and path.exists() and not path.is_file():
        path.write_text(text, "utf-8")
        return
    new = beside(path, ".new")
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

    with naming_file(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        save(path, json.dumps(value, ensure_ascii=False, indent=1))


@dataclass(frozen=True, slots=True)
class KeptFile(Generic[Content]):
    """A JSON file of at most `most` bytes. `parse` raises `ValueError` or `TypeError`."""

    path: Path
    most: int
    parse: Callable[[Any], Content]

    def load(self) -> Content | None:
        """Return the content; None: there is none, or none that can be used."""
        with suppress(OSError, *_UNFIT):
            return self._read()
        return None

    def save(self, value: object) -> None:
        """Replace the content by `value`, as `save_json`. Raises `UsageError`."""
        if self.problem is not None:
            with naming_file(self.path):
                self.path.rename(self._aside)
        save_json(self.path, value)

    @property
    def problem(self) -> Text | None:
        """Why the content is not used; None: it is, or there is none."""
        try:
            self._read()
        except ABSENT:
            return None
        except OSError as error:
            reason = reason_at(self.path, error)
        except _UNFIT:
            reason = _UNUSABLE.filled(file=self.path)
        else:
            return None
        advice = _KEPT.filled(aside=self._aside.name)
        return Text(f"{reason.en}. {advice.en}", f"{reason.ru}. {advice.ru}")

    def _read(self) -> Content:
        return self.parse(read_json(self.path, self.most))

    @property
    def _aside(self) -> Path:
        """The first name that is free."""
        names = (f"{self.path.name}.broken{f'-{n}' if n > 1 else ''}" for n in count(1))
        return next(
            path for name in names if not os.path.lexists(path := self.path.with_name(name))
        )


_UNUSABLE = Text(
    "{file}: the content is damaged, nothing of it is used",
    "{file}: содержимое повреждено и не используется",
)
_KEPT = Text(
    "It is not lost: the next change keeps it as {aside}. Mend it before, or restore a copy.",
    "Файл не пропадёт: при следующем изменении он сохранится как {aside}. "
    "Исправьте его до этого или верните копию.",
)


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
