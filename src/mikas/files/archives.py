"""ZIP archives of others, read within bounds: few members, each of a bounded size when unpacked.

`UnfitFile` says why an archive is refused; the caller names the file (`naming_file`).
"""

from __future__ import annotations

import os
import zlib
from errno import EFBIG, EINVAL, ENOENT
from struct import Struct
from typing import BinaryIO, Final
from zipfile import BadZipFile, ZipFile

from mikas.errors import UnfitFile
from mikas.i18n import Text

MOST_BYTES: Final = 64 << 20
"""Bytes of a whole archive; a longer one is not looked into."""
MOST_MEMBERS: Final = 64
"""Members of an archive."""
SAVED: Final = Text(
    "it must be the ZIP that “mikas survey -o FILE.zip” has saved",
    "нужен ZIP, который сохранила «mikas survey -o ФАЙЛ.zip»",
)
"""What an archive must be that has a survey and its unit's profile."""

_DIRECTORY: Final = 1 << 16  # bytes of the list of members; more is refused before it is read
_END: Final = Struct("<4s4H2LH")  # the record at the end, which has that number
_LONGEST_COMMENT: Final = (1 << 16) - 1  # bytes behind that record
_LOCATOR: Final = 20  # bytes before it, of an archive with numbers of 64 bits

_NOT_ZIP: Final = Text(
    "this is no ZIP archive, or it is cut; copy it again from where it was made",
    "это не архив ZIP, или он обрезан; скопируйте его ещё раз оттуда, где он сделан",
)
_TOO_MANY: Final = Text(
    "the archive has too many members ({most} are read here at most); pack only what is needed",
    "в архиве слишком много файлов (читается не больше {most}); упакуйте только нужное",
)
_TOO_LARGE: Final = Text(
    "the archive has more than {most} MB, the most that is read here",
    "архив больше {most} МБ, больше здесь не читается",
)
_MEMBER_TOO_LARGE: Final = Text(
    "{name} in the archive unpacks to more than {most} KB, the most that is read here",
    "{name} в архиве распаковывается больше чем в {most} КБ, больше здесь не читается",
)
_NO_MEMBER: Final = Text("the archive has no {name}", "в архиве нет {name}")
_TWICE: Final = Text(
    "the archive has {name} twice; keep one of them", "в архиве {name} дважды; оставьте один"
)
_LOCKED: Final = Text(
    "{name} in the archive has a password; pack it without one",
    "{name} в архиве под паролем; упакуйте без пароля",
)
_DAMAGED: Final = Text(
    "{name} in the archive is damaged; copy the archive again from where it was made",
    "{name} в архиве повреждён; скопируйте архив ещё раз оттуда, где он сделан",
)
_PACKED: Final = Text(
    "{name} in the archive is packed in a manner that is not read here; pack it as usual (deflate)",
    "{name} в архиве сжат способом, который здесь не читается; упакуйте обычным (deflate)",
)


class Archive:
    """The members of an open ZIP archive. Raises `UnfitFile` for anything else, and for a bomb.

    `must_be`: what to say of an archive that lacks a member, such as where that kind comes from.
    """

    def __init__(self, file: BinaryIO, must_be: Text | None = None) -> None:
        self._must_be = must_be
        _check_directory(file)
        try:
            self._zip = ZipFile(file)
        except (BadZipFile, ValueError, OverflowError, NotImplementedError) as error:
            raise UnfitFile(EINVAL, _NOT_ZIP) from error
        if len(self._zip.infolist()) > MOST_MEMBERS:
            raise UnfitFile(EFBIG, _TOO_MANY.filled(most=MOST_MEMBERS))

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the members, as the archive has them: they may be anything."""
        return tuple(self._zip.namelist())

    def read(self, name: str, most: int) -> bytes:
        """Return the content of a member. Raises `UnfitFile` for none, or over `most` bytes."""
        entries = [entry for entry in self._zip.infolist() if entry.filename == name]
        if not entries:
            missing, must_be = _NO_MEMBER.filled(name=name), self._must_be
            if must_be is not None:
                missing = Text(f"{missing.en}: {must_be.en}", f"{missing.ru}: {must_be.ru}")
            raise UnfitFile(ENOENT, missing)
        if len(entries) > 1:
            raise UnfitFile(EINVAL, _TWICE.filled(name=name))
        if entries[0].flag_bits & 1:
            raise UnfitFile(EINVAL, _LOCKED.filled(name=name))
        if entries[0].compress_type not in _METHODS:
            raise UnfitFile(EINVAL, _PACKED.filled(name=name))
        try:
            # The size that the archive states may be a lie.
            with self._zip.open(entries[0]) as member:
                data = member.read(most + 1)
                is_too_large = len(data) > most
        except (BadZipFile, zlib.error, EOFError, ValueError, NotImplementedError) as error:
            raise UnfitFile(EINVAL, _DAMAGED.filled(name=name)) from error
        if is_too_large:
            raise UnfitFile(EFBIG, _MEMBER_TOO_LARGE.filled(name=name, most=most // 1024))
        return data


_METHODS: Final = (0, 8)  # stored, deflate


def _check_directory(file: BinaryIO) -> None:
    """Raise `UnfitFile` for a list of members that is too long to be read, or for none."""
    size = file.seek(0, os.SEEK_END)
    if size > MOST_BYTES:
        raise UnfitFile(EFBIG, _TOO_LARGE.filled(most=MOST_BYTES >> 20))
    file.seek(max(0, size - _END.size - _LONGEST_COMMENT - _LOCATOR))
    tail = file.read()
    at = len(tail) - _END.size
    if at < 0 or not tail.startswith(b"PK\5\6", at) or not tail.endswith(b"\0\0"):
        at = tail.rfind(b"PK\5\6")
    if at < 0 or at + _END.size > len(tail):
        raise UnfitFile(EINVAL, _NOT_ZIP)
    directory = _END.unpack_from(tail, at)[5]
    is_large = tail.startswith(b"PK\6\7", max(0, at - _LOCATOR))  # another record has the numbers
    if is_large or directory > _DIRECTORY:
        raise UnfitFile(EFBIG, _TOO_MANY.filled(most=MOST_MEMBERS))
