"""Who the ECU is: availability and passports (§3, rows 01, 51–58)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

from mikas.commands.base import Command, MalformedRequest, ReadNumber, SizeOf
from mikas.i18n import Text

PASSPORT_LENGTH = 16
PASSPORT_ENCODING = "cp866"


@dataclass(frozen=True, slots=True)
class Availability(ReadNumber):
    """01: is anybody there? `01` → the version code, `09` Mikas 5.4, `0A` Mikas 7.1.

    Any other code is an unknown model, still usable. Wire: `01 FF 0D` → `0A F6 0D`.
    """

    CODES: ClassVar[tuple[int, ...]] = (0x01,)
    SOURCE_NAME: ClassVar[str] = "availability"
    TITLE: ClassVar[Text] = Text("availability, model", "доступность, модель")


@dataclass(frozen=True, slots=True)
class _ReadPassport(Command[str]):
    """One 16-byte piece of a passport: code page 866, zero-padded. `part` counts from 1."""

    part: int

    def __post_init__(self) -> None:
        if not 1 <= self.part <= len(self.CODES):
            raise ValueError(f"part must be 1 to {len(self.CODES)}")

    @property
    def code(self) -> int:
        return self.CODES[self.part - 1]

    def body(self) -> bytes:
        return bytes([self.code])

    def response_lengths(self) -> Sequence[int]:
        return (PASSPORT_LENGTH,)

    def _read(self, body: bytes) -> str:
        # Every byte is a character in code page 866, so this can't fail; only the padding goes.
        return body.rstrip(b"\x00").decode(PASSPORT_ENCODING)

    def respond(self, value: str) -> bytes:
        return value.encode(PASSPORT_ENCODING, "replace")[:PASSPORT_LENGTH].ljust(
            PASSPORT_LENGTH, b"\x00"
        )

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        if len(body) != 1:
            raise MalformedRequest
        return cls(cls.CODES.index(body[0]) + 1)


class ReadProgramPassport(_ReadPassport):
    """51 52 53, CPASP: the program's passport, in three parts. Wire: `51 AF 0D`."""

    __slots__ = ()
    CODES: ClassVar[tuple[int, ...]] = (0x51, 0x52, 0x53)
    SOURCE_NAME: ClassVar[str] = "CPASP"
    TITLE: ClassVar[Text] = Text("program passport", "паспорт программы")


class ReadDataPassport(_ReadPassport):
    """54 … 58, CPASD: the data's passport, in five parts. Wire: `54 AC 0D`."""

    __slots__ = ()
    CODES: ClassVar[tuple[int, ...]] = (0x54, 0x55, 0x56, 0x57, 0x58)
    SOURCE_NAME: ClassVar[str] = "CPASD"
    TITLE: ClassVar[Text] = Text("data passport", "паспорт данных")
