"""The unit itself: availability, passports, stored faults, jumps (§3, rows 01, 02, 41, 51–58; D9).

Erasing the faults takes two parameter writes: `parameters.ERASE_FAULTS`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

from mikas.commands.base import (
    ERROR,
    MalformedRequest,
    OnlyCode,
    ReadNumber,
    Safety,
    SizeOf,
    Space,
    row,
)
from mikas.commands.memory import AtAddress
from mikas.errors import NotSupported, WrongContent
from mikas.i18n import Text

SEPARATOR = 0xE0
OTHER_NUMBER_OF_FAULTS = Text(
    "faults: it announces {announced} and holds {held}",
    "объявлено ошибок {announced}, а пришло {held}",
)
NO_SEPARATOR = Text("a fault is not followed by E0", "за номером ошибки нет E0")
_MOST = 0xFF


@row(0x02, "read faults", Text("stored faults", "запомненные ошибки"))
@dataclass(frozen=True, slots=True)
class ReadFaults(OnlyCode[tuple[int, ...]]):
    """02: the stored faults' numbers, as the ECU lists them.

    `02` → `N E1 E0 E2 E0 … EN E0`, every number followed by the separator E0; none: `00`. A fault
    numbered E0 is possible: only every second byte is a separator. Wire: `02 FE 0D`.
    """

    def response_lengths(self) -> Sequence[int]:
        return range(1, 2 * _MOST + 2, 2)

    def _read(self, body: bytes) -> tuple[int, ...]:
        if body == ERROR:  # D10: the number of a single fault would follow
            raise NotSupported(command=self.name)
        count, numbers, separators = body[0], body[1::2], body[2::2]
        if count != len(numbers):
            problem = OTHER_NUMBER_OF_FAULTS.filled(announced=count, held=len(numbers))
            raise WrongContent(problem=problem)
        if any(byte != SEPARATOR for byte in separators):
            raise WrongContent(problem=NO_SEPARATOR)
        return tuple(numbers)

    def respond(self, value: tuple[int, ...]) -> bytes:
        listed = value[:_MOST]
        return bytes([len(listed)]) + b"".join(bytes([n, SEPARATOR]) for n in listed)


@row(0x41, "CGOTO", Text("go to an address", "переход по адресу"))
@dataclass(frozen=True, slots=True)
class GoTo(AtAddress[bytes]):
    """41 CGOTO: `41 AL AH`. No response is expected (D9). Wire for 8000: `41 00 80 3F 0D`.

    The most dangerous command: the ECU executes any bytes at the address.
    """

    SAFETY: ClassVar[Safety] = Safety.DANGEROUS
    ANSWERED: ClassVar[bool] = False
    SPACE: ClassVar[Space] = Space.CODE

    def read(self, body: bytes) -> bytes:
        """Return the response, whose form is not specified."""
        return body

    _read = read

    def respond(self, value: bytes) -> bytes:
        return value


PASSPORT_LENGTH = 16
PASSPORT_ENCODING = "cp866"
_PICTURES = {code: 0x2400 + code for code in range(0x20)} | {0x7F: 0x2421}
"""The pictures of control characters: ESC is shown as ␛. No passport steers a terminal by them."""
_CONTROLS = {picture: code for code, picture in _PICTURES.items()}


def passport_text(data: bytes) -> str:
    """Return the characters of a passport's bytes; code page 866 has one for each."""
    return data.decode(PASSPORT_ENCODING).translate(_PICTURES)


@row(0x01, "availability", Text("availability, model", "доступность, модель"))
@dataclass(frozen=True, slots=True)
class Availability(ReadNumber):
    """01: `01` → the version code, `09` Mikas 5.4, `0A` Mikas 7.1, or an unknown, usable model.

    Wire: `01 FF 0D` → `0A F6 0D`.
    """


@dataclass(frozen=True, slots=True)
class _ReadPassport(OnlyCode[str]):
    """One 16-byte piece of a passport: code page 866, zero-padded. `part` counts from 1.

    A control character is its picture (␛) in the text, so each text is that of one body only.
    """

    part: int
    """Which piece, from 1."""

    LENGTHS: ClassVar[tuple[int, ...]] = (PASSPORT_LENGTH,)

    def __post_init__(self) -> None:
        if not 1 <= self.part <= len(self.CODES):
            raise ValueError(f"part must be 1 to {len(self.CODES)}")

    @property
    def code(self) -> int:
        return self.CODES[self.part - 1]

    def _read(self, body: bytes) -> str:
        return passport_text(body.rstrip(b"\x00"))  # only the padding goes

    def respond(self, value: str) -> bytes:
        body = value.translate(_CONTROLS).encode(PASSPORT_ENCODING, "replace")
        return body[:PASSPORT_LENGTH].ljust(PASSPORT_LENGTH, b"\x00")

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        if len(body) != 1:
            raise MalformedRequest
        return cls(cls.CODES.index(body[0]) + 1)


@row((0x51, 0x52, 0x53), "CPASP", Text("program passport", "паспорт программы"))
class ReadProgramPassport(_ReadPassport):
    """51 52 53, CPASP: the program's passport, in three parts. Wire: `51 AF 0D`."""

    __slots__ = ()


@row((0x54, 0x55, 0x56, 0x57, 0x58), "CPASD", Text("data passport", "паспорт данных"))
class ReadDataPassport(_ReadPassport):
    """54 … 58, CPASD: the data's passport, in five parts. Wire: `54 AC 0D`."""

    __slots__ = ()


def version_text(code: int | None) -> str | None:
    """Return `0A`, the form of a version code (01) in every JSON; None for an unknown one."""
    return None if code is None else f"{code:02X}"


def version_of(value: object) -> int | None:
    """Read `version_text`, or the number that earlier files have; None for anything else."""
    if isinstance(value, str) and re.fullmatch("[0-9A-F]{2}", value):
        return int(value, 16)
    if isinstance(value, bool) or not isinstance(value, int):
        return None
    return value if 0 <= value <= 0xFF else None
