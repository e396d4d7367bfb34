"""Types of arguments and options: bytes, addresses, numbers, choices, files.

A type is a function that returns the value of a text, or raises with the reason; a default is a
text too. click's own types report errors in English only.
"""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import islice
from math import inf, isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from mikas.cli.completion.values import Offering, files
from mikas.cli.config import MAX_PAUSE, MAX_TIMEOUT, MIN_TIMEOUT
from mikas.cli.language import tr
from mikas.errors import system_error, usage_error
from mikas.i18n import Text
from mikas.options import with_nearest

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

    _WordType = click.ParamType[str, str]
else:
    _WordType = click.ParamType  # generic since click 8.4

_MOST_FILES: Final = 1000  # among which a misspelt name is looked for


def _ended(problem: Text) -> click.BadParameter:
    """Return the error with `problem` as a whole sentence."""
    end = "" if problem.en.endswith("?") else "."
    return _invalid(problem.en + end, problem.ru + end)


def _invalid(en: str, ru: str) -> click.BadParameter:
    return click.BadParameter(tr(en, ru))


def hex_bytes(text: str) -> bytes:
    """Return bytes given in hex: `61 1A`, `611A`, `61:1a`, `0x611A`."""
    digits = text.lower().removeprefix("0x").replace(" ", "").replace(":", "")
    try:
        data = bytes.fromhex(digits)
    except ValueError:
        data = b""
    if not data:
        raise _invalid(
            f"“{text}” is not bytes in hex; write them like 611A, two digits a byte.",
            f"«{text}» — не байты в шестнадцатеричном виде; пишите так: 611A, две цифры на байт.",
        )
    return data


def hex_address(text: str) -> int:
    """Return an address given in hex; 0x before or h after it is allowed."""
    text = text.strip()
    digits = text.lower().removeprefix("0x").removesuffix("h")
    if not re.fullmatch("[0-9a-f]{1,16}", digits):
        raise _invalid(
            f"“{text}” is not an address; write it in hex, like 8000 or 0x8000.",
            f"«{text}» — не адрес; пишите его в шестнадцатеричном виде: 8000 или 0x8000.",
        )
    return int(digits, 16)


def size_in_bytes(text: str) -> int:
    """Return a number of bytes: decimal, or hex with 0x."""
    digits = text.strip().lower()
    hexadecimal = re.fullmatch("0x[0-9a-f]{1,8}", digits)
    decimal = re.fullmatch("[0-9]{1,9}", digits)
    count = int(digits, 16) if hexadecimal else int(digits) if decimal else 0
    if count < 1:
        raise _invalid(
            f"“{text}” is not a number of bytes; write 16, or 0x10.",
            f"«{text}» — не число байтов; пишите 16 или 0x10.",
        )
    return count


def _decimal(text: str) -> float:
    """Return the number of `text`, which may have a decimal comma; nan if it is none."""
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return nan


def block_size(text: str) -> int:
    """Return the number of bytes in a block: 1 to 255, for N of the commands is one byte (§3)."""
    count = size_in_bytes(text)
    if count > 0xFF:
        raise _invalid(
            f"“{text}” is too long; a block has 1 to 255 bytes.",
            f"«{text}» — слишком много; в блоке от 1 до 255 байт.",
        )
    return count


def positive(text: str) -> float:
    """Return a number more than 0; a decimal comma is allowed."""
    value = _decimal(text)
    if 0 < value < inf:
        return value
    raise _invalid(
        f"“{text}” is not allowed; it must be a number more than 0.",
        f"«{text}» не подходит; нужно число больше 0.",
    )


def number(text: str) -> float:
    """Return a number; a decimal comma is allowed."""
    value = _decimal(text)
    if isfinite(value):
        return value
    raise _invalid(
        f"“{text}” is not allowed; it must be a number.", f"«{text}» не подходит; нужно число."
    )


def timeout(text: str) -> float:
    """Return the seconds of a time-out (D14)."""
    value = _decimal(text)
    if MIN_TIMEOUT <= value <= MAX_TIMEOUT:
        return value
    raise _invalid(
        f"“{text}” is not allowed; it must be seconds, {MIN_TIMEOUT} to {MAX_TIMEOUT}.",
        f"«{text}» не подходит; нужно число секунд от {MIN_TIMEOUT} до {MAX_TIMEOUT}.",
    )


def pause(text: str) -> float | str:
    """Return the seconds between a response and the next request, or `auto` (D14)."""
    if text.strip().lower() == "auto":
        return "auto"
    value = _decimal(text)
    if 0 <= value <= MAX_PAUSE:
        return value
    raise _invalid(
        f"“{text}” is not allowed; it must be auto, or seconds, 0 to {MAX_PAUSE:g}.",
        f"«{text}» не подходит; нужно auto или число секунд от 0 до {MAX_PAUSE:g}.",
    )


def whole(low: int, high: int | None = None) -> Callable[[str], int]:
    """Return the type of a whole number within limits."""

    def parse(text: str) -> int:
        digits = text.strip()
        value = int(digits) if re.fullmatch("[+-]?[0-9]{1,12}", digits) else low - 1
        if value < low or (high is not None and value > high):
            en, ru = ("", "") if high is None else (f" to {high}", f" до {high}")
            raise _invalid(
                f"“{text}” is not allowed; it must be a whole number from {low}{en}.",
                f"«{text}» не подходит; нужно целое число от {low}{ru}.",
            )
        return value

    return parse


@dataclass(frozen=True, slots=True)
class Portion:
    """The size of one file: in bytes or in seconds; the other is None."""

    bytes: int | None = None
    seconds: float | None = None


_BYTES: Final = {"kb": 1 << 10, "mb": 1 << 20, "gb": 1 << 30}
_SECONDS: Final = {"s": 1, "min": 60, "h": 3600}


def portion(text: str) -> Portion:
    """Return the size of `100MB`, `30min`, `2h`."""
    parts = re.fullmatch(r"([0-9]{1,9}) ?([a-z]+)", text.strip().lower())
    count, unit = (int(parts[1]), parts[2]) if parts else (0, "")
    if count and unit in _BYTES:
        return Portion(bytes=count * _BYTES[unit])
    if count and unit in _SECONDS:
        return Portion(seconds=count * _SECONDS[unit])
    raise _invalid(
        f"“{text}” is not allowed; give a number with its unit: 100MB, 30min, 2h.",
        f"«{text}» не подходит; пишите число с единицей: 100MB, 30min, 2h.",
    )


class OneOf(_WordType):
    """One of some words, in upper or lower case."""

    name = "word"

    def __init__(self, words: Iterable[str]) -> None:
        self.words: tuple[str, ...] = tuple(words)

    def convert(self, value: str, param: object, ctx: object) -> str:  # noqa: ARG002  (click's)
        if value.lower() in self.words:
            return value.lower()
        listed = ", ".join(self.words)
        if len(self.words) == 1:
            raise _invalid(
                f"“{value}” is not allowed; the only value is {listed}.",
                f"«{value}» не подходит; можно только {listed}.",
            )
        problem = Text(
            f"“{value}” is not one of {listed}", f"«{value}» не подходит; можно: {listed}"
        )
        raise _ended(with_nearest(problem, value, self.words))

    def shell_complete(self, ctx: object, param: object, incomplete: str) -> list[CompletionItem]:  # noqa: ARG002
        from click.shell_completion import CompletionItem

        return [CompletionItem(it) for it in self.words if it.startswith(incomplete.lower())]


def any_file(text: str) -> Path:
    """Return a file's path; the file may be absent."""
    path = Path(text)
    if os.path.isdir(path):  # noqa: PTH112  (`Path.is_dir` raises for some names)
        raise _invalid(
            f"“{text}” is a folder; a file is needed.", f"«{text}» — папка, а нужен файл."
        )
    return path


def existing_file(text: str) -> Path:
    """Return the path of a file that exists."""
    path = any_file(text)
    if not os.path.exists(path):  # noqa: PTH110  (as above)
        problem = Text(f"there is no file “{text}”", f"файла «{text}» нет")
        raise _ended(with_nearest(problem, path.name, _files_beside(path)))
    return path


def _files_beside(path: Path) -> list[str]:
    """Return the names in the folder of `path`, none of one that can't be read."""
    try:
        return [it.name for it in islice(os.scandir(path.parent), _MOST_FILES) if it.is_file()]
    except (OSError, ValueError):
        return []


METAVARS: Final[dict[object, str]] = {
    any_file: "FILE", existing_file: "FILE", hex_address: "ADDR", timeout: "SECONDS",
    pause: "SECONDS|auto",
}  # fmt: skip
"""How an option of such a type is shown."""
OFFERED: Final[dict[object, Offering]] = {any_file: files(), existing_file: files()}
"""What a shell is offered for a value of such a type."""


def check_writable(out: Path, *, overwrite: bool) -> None:
    """Raise `UsageError` if `out` exists or can't be written: after the work would be late."""
    if os.path.lexists(out) and not overwrite:
        there = usage_error(
            f"{out}: it exists already; choose another name, or --overwrite",
            f"{out}: такой файл уже есть; выберите другое имя или добавьте --overwrite",
        )
        raise there.caused_by(system_error(errno.EEXIST), out)
    if not os.access(out if out.exists() else out.parent, os.W_OK):
        refused = usage_error(f"{out}: it can't be written", f"{out}: файл не записать")
        raise refused.caused_by(system_error(errno.EACCES), out)
