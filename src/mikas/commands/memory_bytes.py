"""One byte of RAM, XRAM, CODE or SFR, read or written (§3, rows 11–16, 31, 32; D6).

A response repeats the request's address, one byte for RAM and SFR, two for the others, and ends
with the byte; one that repeats another address is never accepted (D13).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

from mikas.commands.base import (
    Command,
    MalformedRequest,
    Safety,
    SizeOf,
    check_byte,
    check_range,
)
from mikas.errors import WrongAddress
from mikas.i18n import Text


@dataclass(frozen=True, slots=True)
class _ByteCommand(Command[int]):
    """A byte at `address`; both reading and writing answer `[address][byte]`."""

    address: int

    SPACE: ClassVar[str]
    ADDRESS_BYTES: ClassVar[int]

    def __post_init__(self) -> None:
        check_range(self.SPACE, (1 << 8 * self.ADDRESS_BYTES) - 1, self.address)

    def body(self) -> bytes:
        return bytes([self.code]) + self._address()

    def _address(self) -> bytes:
        return self.address.to_bytes(self.ADDRESS_BYTES, "little")

    def response_lengths(self) -> Sequence[int]:
        return (self.ADDRESS_BYTES + 1,)

    def _read(self, body: bytes) -> int:
        if body[:-1] != self._address():
            raise WrongAddress(
                got=body[:-1][::-1].hex().upper(),
                asked=self._address()[::-1].hex().upper(),
                request=self.body(),
                received=body,
            )
        return body[-1]

    def respond(self, value: int) -> bytes:
        return self._address() + bytes([value])

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        if len(body) != 1 + cls.ADDRESS_BYTES:
            raise MalformedRequest
        return cls(int.from_bytes(body[1:], "little"))


@dataclass(frozen=True, slots=True)
class _ByteWrite(_ByteCommand):
    """Writes `value`; the response repeats address and byte, and `read` returns that byte."""

    value: int

    SAFETY: ClassVar[Safety] = Safety.REVERSIBLE

    def __post_init__(self) -> None:
        check_range(self.SPACE, (1 << 8 * self.ADDRESS_BYTES) - 1, self.address)
        check_byte(self.SPACE, self.value)

    def body(self) -> bytes:
        return bytes([self.code]) + self._address() + bytes([self.value])

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        if len(body) != 2 + cls.ADDRESS_BYTES:
            raise MalformedRequest
        return cls(int.from_bytes(body[1:-1], "little"), body[-1])


class ReadRamByte(_ByteCommand):
    """11 CREADI: `11 A` → `A B`. Wire for address 40: `11 40 00 AF 0D`."""

    __slots__ = ()
    CODES: ClassVar[tuple[int, ...]] = (0x11,)
    SOURCE_NAME: ClassVar[str] = "CREADI"
    TITLE: ClassVar[Text] = Text("read a RAM byte", "чтение байта RAM")
    SPACE: ClassVar[str] = "ram"
    ADDRESS_BYTES: ClassVar[int] = 1


class WriteRamByte(_ByteWrite):
    """12 CWRTI: `12 A B` → `A B`. D6: the request is missing in the source; inferred."""

    __slots__ = ()
    CODES: ClassVar[tuple[int, ...]] = (0x12,)
    SOURCE_NAME: ClassVar[str] = "CWRTI"
    TITLE: ClassVar[Text] = Text("write a RAM byte", "запись байта RAM")
    SPACE: ClassVar[str] = "ram"
    ADDRESS_BYTES: ClassVar[int] = 1


class ReadXramByte(_ByteCommand):
    """13 CREADX: `13 AL AH` → `AL AH B`."""

    __slots__ = ()
    CODES: ClassVar[tuple[int, ...]] = (0x13,)
    SOURCE_NAME: ClassVar[str] = "CREADX"
    TITLE: ClassVar[Text] = Text("read an XRAM byte", "чтение байта XRAM")
    SPACE: ClassVar[str] = "xram"
    ADDRESS_BYTES: ClassVar[int] = 2


class WriteXramByte(_ByteWrite):
    """14 CWRITX: `14 AL AH B` → `AL AH B`."""

    __slots__ = ()
    CODES: ClassVar[tuple[int, ...]] = (0x14,)
    SOURCE_NAME: ClassVar[str] = "CWRITX"
    TITLE: ClassVar[Text] = Text("write an XRAM byte", "запись байта XRAM")
    SPACE: ClassVar[str] = "xram"
    ADDRESS_BYTES: ClassVar[int] = 2


class ReadCodeByte(_ByteCommand):
    """15 CREADC: `15 AL AH` → `AL AH B`."""

    __slots__ = ()
    CODES: ClassVar[tuple[int, ...]] = (0x15,)
    SOURCE_NAME: ClassVar[str] = "CREADC"
    TITLE: ClassVar[Text] = Text("read a CODE byte", "чтение байта CODE")
    SPACE: ClassVar[str] = "code"
    ADDRESS_BYTES: ClassVar[int] = 2


class WriteCodeByte(_ByteWrite):
    """16 CWRITC: `16 AL AH B` → `AL AH B`."""

    __slots__ = ()
    CODES: ClassVar[tuple[int, ...]] = (0x16,)
    SOURCE_NAME: ClassVar[str] = "CWRITC"
    TITLE: ClassVar[Text] = Text("write a CODE byte", "запись байта CODE")
    SAFETY: ClassVar[Safety] = Safety.DANGEROUS
    SPACE: ClassVar[str] = "code"
    ADDRESS_BYTES: ClassVar[int] = 2


class ReadSfr(_ByteCommand):
    """31 CREADSFR: `31 A` → `A B`, a special function register."""

    __slots__ = ()
    CODES: ClassVar[tuple[int, ...]] = (0x31,)
    SOURCE_NAME: ClassVar[str] = "CREADSFR"
    TITLE: ClassVar[Text] = Text("read an SFR", "чтение SFR")
    SPACE: ClassVar[str] = "sfr"
    ADDRESS_BYTES: ClassVar[int] = 1


class WriteSfr(_ByteWrite):
    """32 SWRITSFR (spelled so in the source): `32 A B` → `A B`."""

    __slots__ = ()
    CODES: ClassVar[tuple[int, ...]] = (0x32,)
    SOURCE_NAME: ClassVar[str] = "SWRITSFR"
    TITLE: ClassVar[Text] = Text("write an SFR", "запись SFR")
    SPACE: ClassVar[str] = "sfr"
    ADDRESS_BYTES: ClassVar[int] = 1
