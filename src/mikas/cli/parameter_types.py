"""Types of arguments and options: bytes, addresses, numbers, choices, files.

click's own types report errors in English only.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

import click

from mikas.cli.language import tr

if TYPE_CHECKING:
    from click import ParamType
else:

    class ParamType(click.ParamType):
        """click's own, which can't be subscripted before version 8.4."""

        def __class_getitem__(cls, kind: object) -> type[ParamType]:
            return cls


class HexBytes(ParamType[bytes]):
    """Bytes in hex: `61 1A`, `611A`, `61:1a`, `0x611A`."""

    name = "hex"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> bytes:
        if isinstance(value, bytes):
            return value
        text = str(value)
        plain = text.lower().removeprefix("0x").replace(" ", "").replace(":", "")
        try:
            data = bytes.fromhex(plain)
        except ValueError:
            data = b""
        if not data:
            self.fail(
                tr(
                    f"“{text}” is not bytes in hex; write them like 611A, two digits a byte.",
                    f"«{text}» — не байты в шестнадцатеричном виде; пишите так: 611A, две цифры "
                    "на байт.",
                ),
                param,
                ctx,
            )
        return data


class Address(ParamType[int]):
    """An address in hex; 0x before or h after it is allowed."""

    name = "address"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> int:
        if isinstance(value, int):
            return value
        text = str(value).strip()
        digits = text.lower().removeprefix("0x").removesuffix("h")
        if not re.fullmatch("[0-9a-f]{1,16}", digits):
            self.fail(
                tr(
                    f"“{text}” is not an address; write it in hex, like 8000 or 0x8000.",
                    f"«{text}» — не адрес; пишите его в шестнадцатеричном виде: 8000 или 0x8000.",
                ),
                param,
                ctx,
            )
        return int(digits, 16)


class Count(ParamType[int]):
    """A number of bytes: decimal, or hex with 0x."""

    name = "count"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> int:
        if isinstance(value, int):
            return value
        text = str(value).strip().lower()
        hexadecimal = re.fullmatch("0x[0-9a-f]{1,8}", text)
        decimal = re.fullmatch("[0-9]{1,9}", text)
        count = int(text, 16) if hexadecimal else int(text) if decimal else 0
        if count < 1:
            self.fail(
                tr(
                    f"“{value}” is not a number of bytes; write 16, or 0x10.",
                    f"«{value}» — не число байтов; пишите 16 или 0x10.",
                ),
                param,
                ctx,
            )
        return count


class Number(ParamType[float]):
    """A number within limits; a decimal comma is allowed."""

    name = "number"

    def __init__(self, *, above: float = float("-inf"), most: float = float("inf")) -> None:
        self._above, self._most = above, most

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        try:
            number = float(str(value).replace(",", "."))
        except ValueError:
            number = float("nan")
        if not isfinite(number):
            self._refuse(value, param, ctx)
        if not self._above < number <= self._most:
            self._refuse(value, param, ctx)
        return number

    def _refuse(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> NoReturn:
        most = tr(f", {self._most:g} at most", f", не больше {self._most:g}")
        limits = tr(f"more than {self._above:g}", f"больше {self._above:g}")
        limits += most if isfinite(self._most) else ""
        self.fail(
            tr(
                f"“{value}” is not allowed; it must be a number {limits}.",
                f"«{value}» не подходит; нужно число {limits}.",
            ),
            param,
            ctx,
        )


class Whole(ParamType[int]):
    """A whole number within limits."""

    name = "whole"

    def __init__(self, low: int, high: int | None = None) -> None:
        self._low, self._high = low, high

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> int:
        text = str(value).strip()
        number = int(text) if re.fullmatch("[+-]?[0-9]{1,12}", text) else self._low - 1
        if number < self._low or (self._high is not None and number > self._high):
            high = "" if self._high is None else tr(f" to {self._high}", f" до {self._high}")
            self.fail(
                tr(
                    f"“{value}” is not allowed; it must be a whole number from {self._low}{high}.",
                    f"«{value}» не подходит; нужно целое число от {self._low}{high}.",
                ),
                param,
                ctx,
            )
        return number


@dataclass(frozen=True, slots=True)
class Portion:
    """The size of one file: in bytes or in seconds; the other is None."""

    bytes: int | None = None
    seconds: float | None = None


class PortionType(ParamType[Portion]):
    """`100MB`, `30min`, `2h`."""

    name = "portion"
    _UNITS: ClassVar[dict[str, Portion]] = {
        "kb": Portion(bytes=1 << 10),
        "mb": Portion(bytes=1 << 20),
        "gb": Portion(bytes=1 << 30),
        "s": Portion(seconds=1),
        "min": Portion(seconds=60),
        "h": Portion(seconds=3600),
    }

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> Portion:
        if isinstance(value, Portion):
            return value
        said = re.fullmatch(r"([0-9]{1,9}) ?([a-z]+)", str(value).strip().lower())
        unit = self._UNITS.get(said[2]) if said else None
        number = int(said[1]) if said else 0
        if unit is None or number < 1:
            self.fail(
                tr(
                    f"“{value}” is not allowed; give a number with its unit: 100MB, 30min, 2h.",
                    f"«{value}» не подходит; пишите число с единицей: 100MB, 30min, 2h.",
                ),
                param,
                ctx,
            )
        if unit.bytes is not None:
            return Portion(bytes=number * unit.bytes)
        assert unit.seconds is not None
        return Portion(seconds=number * unit.seconds)


class OneOf(ParamType[str]):
    """One of some words, in upper or lower case."""

    name = "word"

    def __init__(self, words: Sequence[str]) -> None:
        self.words = tuple(words)

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> str:
        text = str(value).lower()
        if text not in self.words:
            listed = ", ".join(self.words)
            if len(self.words) == 1:
                said = tr(
                    f"“{value}” is not allowed; the only value is {listed}.",
                    f"«{value}» не подходит; можно только {listed}.",
                )
            else:
                said = tr(
                    f"“{value}” is not one of {listed}.",
                    f"«{value}» не подходит; можно: {listed}.",
                )
            self.fail(said, param, ctx)
        return text

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        return f"[{'|'.join(self.words)}]"


class File(ParamType[Path]):
    """A file's path. `there`: the file must exist."""

    name = "file"

    def __init__(self, *, there: bool = False) -> None:
        self._there = there

    def convert(
        self,
        value: Any,  # noqa: ANN401  (as click has it)
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> Path:
        path = Path(value)
        try:
            folder, found = path.is_dir(), path.exists()
        except (OSError, ValueError):  # an invalid name
            folder, found = False, False
        if folder:
            self.fail(
                tr(
                    f"“{value}” is a folder; a file is needed.",
                    f"«{value}» — папка, а нужен файл.",
                ),
                param,
                ctx,
            )
        if self._there and not found:
            self.fail(
                tr(f"there is no file “{value}”.", f"файла «{value}» нет."),
                param,
                ctx,
            )
        return path
