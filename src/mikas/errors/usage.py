"""What the user asked wrongly; nothing was sent."""

from __future__ import annotations

from collections.abc import Sequence

from mikas.errors.base import MikasError
from mikas.i18n import Text


class UsageError(MikasError, ValueError):
    """The user asked for something that makes no sense; nothing was sent."""

    what = Text("{problem}", "{problem}")


class UnknownParameter(UsageError):
    """No parameter has this name or code. `suggestions`: the nearest names, best first."""

    what = Text("There is no parameter “{name}”", "Нет параметра «{name}»")
    advice = Text(
        "`mikas params` lists them all; a raw code is written 0x1A, or 0x3F:2 for two bytes.",
        "Все параметры показывает `mikas params`; код без имени пишется 0x1A, двухбайтовый 0x3F:2.",
    )
    advice_on_screen = Text(
        "The names are those of the list of parameters; a raw code is written 0x1A, or 0x3F:2 for "
        "two bytes.",
        "Имена — из списка параметров; код без имени пишется 0x1A, двухбайтовый 0x3F:2.",
    )

    def __init__(self, name: str, suggestions: Sequence[str] = ()) -> None:
        self.name = name
        self.suggestions = tuple(suggestions)
        nearest = ", ".join(self.suggestions)
        if not nearest:
            super().__init__(name=name)
            return

        def guessed(advice: Text) -> Text:
            return Text(
                f"Did you mean {nearest}? {advice.en}", f"Может быть, {nearest}? {advice.ru}"
            )

        super().__init__(
            name=name, advice=guessed(self.advice), on_screen=guessed(self.advice_on_screen)
        )


class AddressOutOfRange(UsageError):
    """The address, or the last one of a range, lies outside the memory space."""

    what = Text(
        "{space} has addresses 0 to {last:#06x}; the bytes from {address:#x} on ({count} in all) "
        "are not all inside",
        "Адреса {space} — от 0 до {last:#06x}; байты с {address:#x} (всего {count}) не все внутри",
    )
    advice = Text(
        "Nothing was sent. Correct the address or the count.",
        "Ничего не послано. Исправьте адрес или число байтов.",
    )


class ValueDoesNotFit(UsageError):
    """The value can't be represented in the raw bytes that the parameter or the cell has."""

    what = Text(
        "{value} does not fit {name}: {allowed}", "{value} не подходит для {name}: {allowed}"
    )
    advice = Text("Nothing was written.", "Ничего не записано.")


class BadPortUrl(UsageError):
    """The port's URL or one of its options makes no sense."""

    what = Text("“{url}” is not a port: {problem}", "«{url}» — не порт: {problem}")
    advice = Text(
        "Ports look like /dev/ttyUSB0, COM3, socket://host:port, rfc2217://host:port, sim: or "
        "replay:FILE.",
        "Порты пишутся так: /dev/ttyUSB0, COM3, socket://host:port, rfc2217://host:port, sim:, "
        "replay:FILE.",
    )


class CatalogError(UsageError):
    """A catalog file is wrong. `file`, `line` (1-based; 0: the file as a whole), `problem`."""

    what = Text("{place}: {problem}", "{place}: {problem}")
    advice = Text(
        "The file was not used; nothing else changed.",
        "Файл не использован; больше ничего не изменилось.",
    )

    def __init__(self, file: str, line: int, problem: Text) -> None:
        self.file, self.line, self.problem = file, line, problem
        super().__init__(place=f"{file}:{line}" if line else file, problem=problem)


class CaptureError(UsageError):
    """A capture can't be read or written. `offset`: where in the file, if known."""

    what = Text("{file}: {problem}", "{file}: {problem}")

    def __init__(self, file: str, problem: Text, offset: int | None = None) -> None:
        self.file, self.problem, self.offset = file, problem, offset
        super().__init__(file=file, problem=problem)


class ExportError(UsageError):
    """An export can't be made: its name, what is in its way, or the disk. Nothing was left
    behind.
    """

    what = Text("{file}: {problem}", "{file}: {problem}")
    advice = Text(
        "Nothing was written; the recording is untouched.",
        "Ничего не записано; сама запись не тронута.",
    )

    def __init__(self, file: str, problem: Text) -> None:
        self.file, self.problem = file, problem
        super().__init__(file=file, problem=problem)


class JournalError(UsageError):
    """The journal of changes can't be written, so no change is made."""

    what = Text(
        "The journal {file} can't be written: {problem}", "Журнал {file} не записывается: {problem}"
    )
    advice = Text(
        "A change that leaves no trace is not made. Free some space or correct the folder's "
        "rights.",
        "Изменения без записи в журнал не делаются. Освободите место или исправьте права папки.",
    )


class MissingExtra(UsageError, ImportError):
    """An optional library is not installed; names the extra that brings it."""

    what = Text(
        "{feature} needs a library that is not installed",
        "Для «{feature}» не установлена библиотека",
    )
    advice = Text(
        'Install it with: pip install "mikas[{extra}]".',
        'Установите: pip install "mikas[{extra}]".',
    )
