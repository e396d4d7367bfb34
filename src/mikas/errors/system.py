"""What the system refuses a program, in words: room on a disk, memory, processes, open files.

Such an error comes from anywhere, in the form that a library gives it. Nothing of mikas is wrong
then, and a person can act on it.
"""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Iterator
from itertools import islice
from typing import Final

from mikas.i18n import Text

REFUSALS: Final = {
    errno.ENOSPC: Text(
        "No space left on device; make room, then repeat",
        "диск заполнен; освободите место и повторите",
    ),
    errno.EDQUOT: Text(
        "Disk quota exceeded; make room, then repeat",
        "отведённое вам место на диске заполнено; освободите место и повторите",
    ),
    errno.EFBIG: Text(
        "no file may become that large here; take another disk, or raise the limit (ulimit -f)",
        "файл такого размера здесь не разрешён; возьмите другой диск или поднимите предел "
        "(ulimit -f)",
    ),
    errno.EROFS: Text(
        "Read-only file system; take another place",
        "диск доступен только для чтения; возьмите другое место",
    ),
    errno.ENOMEM: Text(
        "there is too little memory; close other programs, then repeat",
        "не хватает памяти; закройте другие программы и повторите",
    ),
    errno.EAGAIN: Text(
        "the system allows no further process or thread; close other programs, then repeat",
        "система не разрешает больше процессов или потоков; закройте другие программы и повторите",
    ),
    errno.EMFILE: Text(
        "this program may not open more files; raise the limit (ulimit -n), then repeat",
        "программе нельзя открыть больше файлов; поднимите предел (ulimit -n) и повторите",
    ),
    errno.ENFILE: Text(
        "the system has too many open files; close other programs, then repeat",
        "в системе открыто слишком много файлов; закройте другие программы и повторите",
    ),
}
"""By the number of the error."""

NEEDS_INTERFACE: Final = Text(
    "an IPv6 address that begins with fe80 needs the name of this computer's interface: "
    "[fe80::1%eth0], or %wlan0",
    "адресу IPv6, который начинается с fe80, нужно имя интерфейса этого компьютера: "
    "[fe80::1%eth0] или %wlan0",
)
"""The reason of EINVAL while connecting: no other address meets it."""

OF_PLACE: Final = frozenset((errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS))
"""Refusals that another file in the same place meets as well."""

_WORDS: Final = (
    (re.compile("can't start new (thread|process)|can't allocate lock"), errno.EAGAIN),
    (re.compile("Out of Memory|failed to map segment|bad allocation|bad_alloc"), errno.ENOMEM),
    *((re.compile(re.escape(os.strerror(number))), number) for number in REFUSALS),
)
_NUMBER: Final = re.compile(r'"errno":"(\d+)"')
_MOST: Final = 10  # errors, each the cause of the next


def refused_number(error: BaseException) -> int | None:
    """Return the number of the refusal that an error is, or that has caused it; None: there is
    none.
    """
    for each in islice(_chain(error), _MOST):
        if (number := _number(each)) in REFUSALS:
            return number
    return None


def refusal_of(error: BaseException) -> Text | None:
    """Return in words what the system has refused; None: the error is another one."""
    number = refused_number(error)
    return None if number is None else REFUSALS[number]


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = error.__cause__ or (None if error.__suppress_context__ else error.__context__)


def _number(error: BaseException) -> int | None:
    if isinstance(error, MemoryError):
        return errno.ENOMEM
    if isinstance(error, OSError) and error.errno is not None:
        return error.errno
    text = str(error)
    if isinstance(error, RuntimeError | ImportError | OSError) or _is_of_library(error):
        if found := _NUMBER.search(text):
            return int(found[1])
        return next((number for words, number in _WORDS if words.search(text)), None)
    return None


def _is_of_library(error: BaseException) -> bool:
    return type(error).__module__.partition(".")[0] in ("duckdb", "_duckdb", "asammdf")
