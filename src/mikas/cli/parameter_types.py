"""Types of arguments and options: bytes, addresses, numbers, choices, files.

click's own types report errors in English only.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

import click

from mikas.cli.language import tr

if TYPE_CHECKING:
    from click import ParamType
else:

    class ParamType(click.ParamType):
        """click's own, which can't be subscripted before version 8.4."""

        def __class_getitem__(cls, kind: object) -> type[ParamType]:
            return cls


T = TypeVar("T")


class _Invalid(Exception):
    """The text is not a value of the type; the reason in English and Russian."""

    def __init__(self, en: str, ru: str) -> None:
        super().__init__(tr(en, ru))


class _ParsedType(ParamType[T]):
    """A type whose values are parsed from what the user types; defaults are values already."""

    def convert(
        self,
        value: Any,  # noqa: ANN401  (as click has it)
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> T:
        try:
            parsed: T = self.parse(value) if isinstance(value, str) else value
        except _Invalid as error:
            self.fail(str(error), param, ctx)
        return parsed

    def parse(self, text: str) -> T:
        """Return the value of `text`. Raises `_Invalid`."""
        raise NotImplementedError  # each type has its own; click calls `convert`


class HexBytes(_ParsedType[bytes]):
    """Bytes in hex: `61 1A`, `611A`, `61:1a`, `0x611A`."""

    name = "hex"

    def parse(self, text: str) -> bytes:
        digits = text.lower().removeprefix("0x").replace(" ", "").replace(":", "")
        try:
            data = bytes.fromhex(digits)
        except ValueError:
            data = b""
        if not data:
            raise _Invalid(
                f"“{text}” is not bytes in hex; write them like 611A, two digits a byte.",
                f"«{text}» — не байты в шестнадцатеричном виде; пишите так: 611A, две цифры на "
                "байт.",
            )
        return data


class Address(_ParsedType[int]):
    """An address in hex; 0x before or h after it is allowed."""

    name = "address"

    def parse(self, text: str) -> int:
        text = text.strip()
        digits = text.lower().removeprefix("0x").removesuffix("h")
        if not re.fullmatch("[0-9a-f]{1,16}", digits):
            raise _Invalid(
                f"“{text}” is not an address; write it in hex, like 8000 or 0x8000.",
                f"«{text}» — не адрес; пишите его в шестнадцатеричном виде: 8000 или 0x8000.",
            )
        return int(digits, 16)


class Count(_ParsedType[int]):
    """A number of bytes: decimal, or hex with 0x."""

    name = "count"

    def parse(self, text: str) -> int:
        digits = text.strip().lower()
        hexadecimal = re.fullmatch("0x[0-9a-f]{1,8}", digits)
        decimal = re.fullmatch("[0-9]{1,9}", digits)
        count = int(digits, 16) if hexadecimal else int(digits) if decimal else 0
        if count < 1:
            raise _Invalid(
                f"“{text}” is not a number of bytes; write 16, or 0x10.",
                f"«{text}» — не число байтов; пишите 16 или 0x10.",
            )
        return count


class Number(_ParsedType[float]):
    """A number more than `above`, at most `most`; a decimal comma is allowed."""

    name = "number"

    def __init__(self, *, above: float, most: float = inf) -> None:
        self._above, self._most = above, most

    def parse(self, text: str) -> float:
        try:
            number = float(text.replace(",", "."))
        except ValueError:
            number = nan
        if isfinite(number) and self._above < number <= self._most:
            return number
        most, above = f"{self._most:g}", f"{self._above:g}"
        en, ru = (f", {most} at most", f", не больше {most}") if isfinite(self._most) else ("", "")
        raise _Invalid(
            f"“{text}” is not allowed; it must be a number more than {above}{en}.",
            f"«{text}» не подходит; нужно число больше {above}{ru}.",
        )


class Whole(_ParsedType[int]):
    """A whole number within limits."""

    name = "whole"

    def __init__(self, low: int, high: int | None = None) -> None:
        self._low, self._high = low, high

    def parse(self, text: str) -> int:
        digits = text.strip()
        number = int(digits) if re.fullmatch("[+-]?[0-9]{1,12}", digits) else self._low - 1
        if number < self._low or (self._high is not None and number > self._high):
            en, ru = ("", "") if self._high is None else (f" to {self._high}", f" до {self._high}")
            raise _Invalid(
                f"“{text}” is not allowed; it must be a whole number from {self._low}{en}.",
                f"«{text}» не подходит; нужно целое число от {self._low}{ru}.",
            )
        return number


@dataclass(frozen=True, slots=True)
class Portion:
    """The size of one file: in bytes or in seconds; the other is None."""

    bytes: int | None = None
    seconds: float | None = None


class PortionType(_ParsedType[Portion]):
    """`100MB`, `30min`, `2h`."""

    name = "portion"
    _BYTES: Final = {"kb": 1 << 10, "mb": 1 << 20, "gb": 1 << 30}
    _SECONDS: Final = {"s": 1, "min": 60, "h": 3600}

    def parse(self, text: str) -> Portion:
        parts = re.fullmatch(r"([0-9]{1,9}) ?([a-z]+)", text.strip().lower())
        number, unit = (int(parts[1]), parts[2]) if parts else (0, "")
        if number and unit in self._BYTES:
            return Portion(bytes=number * self._BYTES[unit])
        if number and unit in self._SECONDS:
            return Portion(seconds=number * self._SECONDS[unit])
        raise _Invalid(
            f"“{text}” is not allowed; give a number with its unit: 100MB, 30min, 2h.",
            f"«{text}» не подходит; пишите число с единицей: 100MB, 30min, 2h.",
        )


class OneOf(_ParsedType[str]):
    """One of some words, in upper or lower case."""

    name = "word"

    def __init__(self, words: Sequence[str]) -> None:
        self.words = tuple(words)

    def parse(self, text: str) -> str:
        if text.lower() in self.words:
            return text.lower()
        listed = ", ".join(self.words)
        if len(self.words) == 1:
            raise _Invalid(
                f"“{text}” is not allowed; the only value is {listed}.",
                f"«{text}» не подходит; можно только {listed}.",
            )
        raise _Invalid(
            f"“{text}” is not one of {listed}.", f"«{text}» не подходит; можно: {listed}."
        )

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        return f"[{'|'.join(self.words)}]"


class File(_ParsedType[Path]):
    """A file's path. `exists`: the file must exist."""

    name = "file"

    def __init__(self, *, exists: bool = False) -> None:
        self._exists = exists

    def parse(self, text: str) -> Path:
        path = Path(text)
        try:
            is_folder, exists = path.is_dir(), path.exists()
        except (OSError, ValueError):  # an invalid name
            is_folder, exists = False, False
        if is_folder:
            raise _Invalid(
                f"“{text}” is a folder; a file is needed.", f"«{text}» — папка, а нужен файл."
            )
        if self._exists and not exists:
            raise _Invalid(f"there is no file “{text}”.", f"файла «{text}» нет.")
        return path
