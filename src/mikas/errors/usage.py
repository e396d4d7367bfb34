"""Wrong use; nothing was sent."""

from __future__ import annotations

import errno
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import ClassVar, cast

from mikas.cleaning import public_url
from mikas.errors.base import MikasError, reason_at
from mikas.i18n import Text


class UsageError(MikasError, ValueError):
    """Wrong use of a command or function; nothing was sent."""

    what: ClassVar[Text] = Text("{problem}", "{problem}")


def usage_error(en: str, ru: str) -> UsageError:
    """Return the error of a wrong use, described in both languages."""
    return UsageError(problem=Text(en, ru))


@contextmanager
def naming_file(file: Path) -> Iterator[None]:
    """Let an `OSError` be a `UsageError` that names the file; it stays an `OSError`."""
    try:
        yield
    except MikasError:  # some are OSErrors as well
        raise
    except OSError as error:
        raise unusable_file(file, error) from error


def unusable_file(file: Path, error: OSError) -> UsageError:
    """Return the error of a file that the system refuses; it is also the system's."""
    return UsageError(problem=reason_at(file, error)).caused_by(error, file)


class UnknownParameter(UsageError):
    """No parameter has this name or code. `suggestions`: the nearest names, best first."""

    what: ClassVar[Text] = Text("There is no parameter “{name}”", "Нет параметра «{name}»")
    advice: Text = Text(
        "{nearest}A raw code is written 0x1A, or 0x3F:2 for two bytes.",
        "{nearest}Код без имени пишется 0x1A, двухбайтовый 0x3F:2.",
    )

    def __init__(self, name: str, suggestions: Sequence[str] = ()) -> None:
        self.name = name
        """The name as it was given."""
        self.suggestions: tuple[str, ...] = tuple(suggestions)
        """The nearest names, best first."""
        listed = ", ".join(self.suggestions)
        nearest = Text(f"Did you mean {listed}? ", f"Может быть, {listed}? ")
        super().__init__(name=name, nearest=nearest if listed else "")


class NeedsSamples(UsageError):
    """A derived channel can't be read once: `total`, one that it needs, adds up over time."""

    what: ClassVar[Text] = Text(
        "A single reading can't give {name}: {total} is added up from sample to sample",
        "Одно чтение не даёт {name}: {total} накапливается от опроса к опросу",
    )
    advice: Text = Text(
        "Sample it for a while: a session adds it up.",
        "Опрашивайте его какое-то время: опрос его накопит.",
    )


class NoList(UsageError):
    """The parameters of the unit's list are unknown: mikas has not set it, or it was lost."""

    what: ClassVar[Text] = Text(
        "It is not known which parameters the unit's list has",
        "Неизвестно, какие параметры в списке блока",
    )
    advice: Text = Text("set_list() comes first.", "Сначала нужен set_list().")


class AddressOutOfRange(UsageError):
    """The address, or the last one of a range, lies outside the memory space."""

    what: ClassVar[Text] = Text(
        "{space} has addresses 0 to {last:#06x}; {count} byte(s) from {address:#x} exceed them",
        "Адреса {space} — от 0 до {last:#06x}; байты с {address:#x} (всего {count}) выходят за них",
    )
    advice: Text = Text(
        "Nothing was sent. Correct the address or the count.",
        "Ничего не послано. Исправьте адрес или число байтов.",
    )


class ValueDoesNotFit(UsageError):
    """The value can't be represented in the raw bytes of the parameter or the cell."""

    what: ClassVar[Text] = Text(
        "{value} does not fit {name}: {allowed}", "{value} не подходит для {name}: {allowed}"
    )
    advice: Text = Text("Nothing was written.", "Ничего не записано.")


class BadPortUrl(UsageError):
    """Invalid port URL, or an invalid option in it."""

    what: ClassVar[Text] = Text(
        "Invalid port “{url}”: {problem}", "Неверный порт «{url}»: {problem}"
    )
    advice: Text = Text(
        "Ports look like /dev/ttyUSB0, COM3, socket://host:port, rfc2217://host:port, sim: or "
        "replay:FILE.",
        "Порты пишутся так: /dev/ttyUSB0, COM3, socket://host:port, rfc2217://host:port, sim:, "
        "replay:FILE.",
    )


class CatalogError(UsageError):
    """A catalog file is wrong. `file`, `line` (1-based; 0: the file as a whole), `problem`."""

    what: ClassVar[Text] = Text("{place}: {problem}", "{place}: {problem}")
    advice: Text = Text(
        "The file was not used; nothing else changed.",
        "Файл не использован; больше ничего не изменилось.",
    )

    def __init__(self, file: str, line: int, problem: Text) -> None:
        self.file: str = file
        """The file."""
        self.line: int = line
        """From 1; 0: the file as a whole."""
        self.problem: Text = problem
        """The problem."""
        super().__init__(place=f"{file}:{line}" if line else file, problem=problem)


class FormulaError(UsageError):
    """A formula is wrong. `span`: the first and the next character of the wrong part; None: all."""

    what: ClassVar[Text] = Text("{problem}", "{problem}")

    def __init__(self, problem: Text, span: tuple[int, int] | None = None) -> None:
        self.problem: Text = problem
        """The problem."""
        self.span: tuple[int, int] | None = span
        """The first and the next character of the wrong part; None: all."""
        super().__init__(problem=problem)


class CaptureError(UsageError):
    """A capture can't be read or written. `offset`: where in the file, if known."""

    what: ClassVar[Text] = Text("{file}: {problem}", "{file}: {problem}")

    def __init__(self, file: str, problem: Text, offset: int | None = None) -> None:
        self.file: str = file
        """The file."""
        self.problem: Text = problem
        """The problem."""
        self.offset: int | None = offset
        """Where in the file; None: unknown."""
        super().__init__(file=file, problem=problem)


class DiskFull(CaptureError, OSError):
    """There is no room for a capture, or for more of it."""

    number: ClassVar[int | None] = errno.ENOSPC

    advice: Text = Text("Make room, then repeat.", "Освободите место и повторите.")


class ExportError(UsageError):
    """An export can't be made: its name, an existing file, or the disk. No partial file stays."""

    what: ClassVar[Text] = Text("{file}: {problem}", "{file}: {problem}")
    advice: Text = Text(
        "Nothing was written; the recording is untouched.",
        "Ничего не записано; сама запись не тронута.",
    )

    def __init__(self, file: str, problem: Text) -> None:
        self.file: str = file
        """The file."""
        self.problem: Text = problem
        """The problem."""
        super().__init__(file=file, problem=problem)


class ForeignLogError(UsageError):
    """Another program's log can't be read. `line` or `offset`: where in the file, if known."""

    what: ClassVar[Text] = Text("{file}{where}: {problem}", "{file}{where}: {problem}")

    def __init__(
        self, file: str, problem: Text, line: int | None = None, offset: int | None = None
    ) -> None:
        self.file: str = file
        """The file's name."""
        self.problem: Text = problem
        """The problem, and what to do."""
        self.line: int | None = line
        """The line, from 1; None: unknown, or the file has none."""
        self.offset: int | None = offset
        """Where in the file, in bytes; None: unknown."""
        where = Text("", "")
        if line is not None:
            where = Text(f", line {line}", f", строка {line}")
        elif offset is not None:
            where = Text(f", byte {offset}", f", байт {offset}")
        super().__init__(file=file, where=where, problem=problem)


class FleetError(UsageError):
    """A place of recordings or a dataset can't be used. `place`: its path or URL, no password."""

    what: ClassVar[Text] = Text("{place}: {problem}", "{place}: {problem}")
    advice: Text = Text(
        "What is in a dataset already stays as it is.", "Всё, что уже есть в наборе, остаётся."
    )

    def __init__(self, place: str, problem: Text, advice: Text | None = None) -> None:
        super().__init__(place=place, problem=problem, advice=advice)
        self.place: str = public_url(place)
        """Its path or URL, without a password."""
        self.problem: Text = cast("Text", self.fields["problem"])
        """The problem."""


class JournalError(UsageError):
    """The journal of changes can't be written, so no change is made."""

    what: ClassVar[Text] = Text(
        "The journal {file} can't be written: {problem}",
        "Не удаётся записать журнал {file}: {problem}",
    )
    advice: Text = Text(
        "Changes without a journal entry are not made. Free disk space, correct the folder's "
        "permissions, or name another folder in MIKAS_STATE.",
        "Изменения без записи в журнал не делаются. Освободите место на диске, исправьте права "
        "на папку или укажите другую папку в MIKAS_STATE.",
    )


class MissingExtra(UsageError, ImportError):
    """An optional library is not installed; names the extra that brings it."""

    what: ClassVar[Text] = Text(
        "{feature} needs a library that is not installed",
        "Для «{feature}» нужна библиотека, которая не установлена",
    )
    advice: Text = (
        Text(
            "This program in one folder was built without it. Install mikas with Python: "
            'pipx install "mikas[{extra}]".',
            "Эта программа в одной папке собрана без неё. Установите mikas с Python: "
            'pipx install "mikas[{extra}]".',
        )
        if getattr(sys, "frozen", False)  # by PyInstaller: nothing can be added to it
        else Text(
            'Install it with: pip install "mikas[{extra}]".',
            'Установите: pip install "mikas[{extra}]".',
        )
    )


def library(
    name: str, *, feature: str | Text, extra: str = "", advice: Text | None = None
) -> ModuleType:
    """Import an optional library. Raises `MissingExtra`, which says how to install it."""
    try:
        return import_module(name)
    except ImportError as error:
        raise MissingExtra(feature=feature, extra=extra, advice=advice) from error
