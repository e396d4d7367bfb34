"""Memory commands (§3, rows 11–16, 21–26, 31, 32; D6–D8): one byte, or a block in one exchange.

An address has one byte for RAM and SFR, two for XRAM and CODE. A response repeats the request's
address before the data; a response with another address is never accepted (D13).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self, TypeVar

from mikas.commands.base import (
    Command,
    MalformedRequest,
    Safety,
    SizeOf,
    Write,
    check_byte,
    check_range,
)
from mikas.errors import WrongAddress, WrongContent
from mikas.i18n import Text

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class _AtAddress(Command[T]):
    """A command at `address`, which its response repeats before the data."""

    address: int

    SPACE: ClassVar[str]
    ADDRESS_BYTES: ClassVar[int]

    def _address(self) -> bytes:
        return self.address.to_bytes(self.ADDRESS_BYTES, "little")

    def _data_of(self, body: bytes) -> bytes:
        address, data = body[: self.ADDRESS_BYTES], body[self.ADDRESS_BYTES :]
        if address != self._address():
            raise WrongAddress(
                got=address[::-1].hex().upper(), asked=self._address()[::-1].hex().upper()
            )
        return data


@dataclass(frozen=True, slots=True)
class _ByteCommand(_AtAddress[int]):
    """A byte at `address`; both reading and writing answer `[address][byte]`."""

    def __post_init__(self) -> None:
        check_range(self.SPACE, (1 << 8 * self.ADDRESS_BYTES) - 1, self.address)

    def body(self) -> bytes:
        return bytes([self.code]) + self._address()

    def response_lengths(self) -> Sequence[int]:
        return (self.ADDRESS_BYTES + 1,)

    def _read(self, body: bytes) -> int:
        return self._data_of(body)[0]

    def respond(self, value: int) -> bytes:
        return self._address() + bytes([value])

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        if len(body) != 1 + cls.ADDRESS_BYTES:
            raise MalformedRequest
        return cls(int.from_bytes(body[1:], "little"))


@dataclass(frozen=True, slots=True)
class _ByteWrite(_ByteCommand):
    """Writes `value`; the response repeats address and byte, which `read` returns."""

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


LARGEST_BLOCK = 0xFF  # the count is one byte


def _check_block(space: str, address_bytes: int, address: int, count: int) -> None:
    check_range(space, (1 << 8 * address_bytes) - 1, address, count)
    if count > LARGEST_BLOCK:
        raise ValueError(f"a block has at most {LARGEST_BLOCK} bytes")


@dataclass(frozen=True, slots=True)
class _ReadBlock(_AtAddress[bytes]):
    """`count` bytes from `address` on. `COUNT_FORMS`: whether the count is repeated (D7)."""

    count: int

    COUNT_FORMS: ClassVar[tuple[bool, ...]]  # the usual form first

    def __post_init__(self) -> None:
        _check_block(self.SPACE, self.ADDRESS_BYTES, self.address, self.count)

    def body(self) -> bytes:
        return bytes([self.code]) + self._address() + bytes([self.count])

    def response_lengths(self) -> Sequence[int]:
        return tuple(self.ADDRESS_BYTES + counted + self.count for counted in self.COUNT_FORMS)

    def _read(self, body: bytes) -> bytes:
        data = self._data_of(body)
        if len(data) > self.count:
            if data[0] != self.count:
                problem = Text(
                    f"it announces {data[0]} bytes instead of {self.count}",
                    f"объявлено байтов {data[0]} вместо {self.count}",
                )
                raise WrongContent(problem=problem)
            data = data[1:]
        return data

    def respond(self, value: bytes, *, counted: bool | None = None) -> bytes:
        """`counted`: whether to repeat the count; the source's form by default (D7)."""
        repeated = self.COUNT_FORMS[0] if counted is None else counted
        return self._address() + (bytes([self.count]) if repeated else b"") + value

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        if len(body) != 2 + cls.ADDRESS_BYTES:
            raise MalformedRequest
        return cls(int.from_bytes(body[1:-1], "little"), body[-1])


@dataclass(frozen=True, slots=True)
class _WriteBlock(Write):
    """Writes `data` from `address` on. The source's rows 24, 26 lack the data bytes (D8)."""

    address: int
    data: bytes

    SPACE: ClassVar[str]
    ADDRESS_BYTES: ClassVar[int]
    SAFETY: ClassVar[Safety] = Safety.REVERSIBLE

    def __post_init__(self) -> None:
        _check_block(self.SPACE, self.ADDRESS_BYTES, self.address, len(self.data))

    def body(self) -> bytes:
        address = self.address.to_bytes(self.ADDRESS_BYTES, "little")
        return bytes([self.code]) + address + bytes([len(self.data)]) + self.data

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        count_at = 1 + cls.ADDRESS_BYTES
        if len(body) <= count_at or len(body) != count_at + 1 + body[count_at]:
            raise MalformedRequest
        return cls(int.from_bytes(body[1:count_at], "little"), body[count_at + 1 :])


class ReadRamBlock(_ReadBlock):
    """21 CREADDI: `21 A N` → `A N B1 … BN`."""

    __slots__ = ()
    CODES: ClassVar[tuple[int, ...]] = (0x21,)
    SOURCE_NAME: ClassVar[str] = "CREADDI"
    TITLE: ClassVar[Text] = Text("read RAM bytes", "чтение байтов RAM")
    SPACE: ClassVar[str] = "ram"
    ADDRESS_BYTES: ClassVar[int] = 1
    COUNT_FORMS: ClassVar[tuple[bool, ...]] = (True,)


class WriteRamBlock(_WriteBlock):
    """22 CWRITDI: `22 A N B1 … BN` → `00` / `01`."""

    __slots__ = ()
    CODES: ClassVar[tuple[int, ...]] = (0x22,)
    SOURCE_NAME: ClassVar[str] = "CWRITDI"
    TITLE: ClassVar[Text] = Text("write RAM bytes", "запись байтов RAM")
    SPACE: ClassVar[str] = "ram"
    ADDRESS_BYTES: ClassVar[int] = 1


class ReadXramBlock(_ReadBlock):
    """23 CREADDX: `23 AL AH N` → `AL AH B1 … BN`, or with the count as in 21 (D7)."""

    __slots__ = ()
    CODES: ClassVar[tuple[int, ...]] = (0x23,)
    SOURCE_NAME: ClassVar[str] = "CREADDX"
    TITLE: ClassVar[Text] = Text("read XRAM bytes", "чтение байтов XRAM")
    SPACE: ClassVar[str] = "xram"
    ADDRESS_BYTES: ClassVar[int] = 2
    COUNT_FORMS: ClassVar[tuple[bool, ...]] = (False, True)


class WriteXramBlock(_WriteBlock):
    """24 CWRITDX: `24 AL AH N B1 … BN` → `00` / `01` (D8)."""

    __slots__ = ()
    CODES: ClassVar[tuple[int, ...]] = (0x24,)
    SOURCE_NAME: ClassVar[str] = "CWRITDX"
    TITLE: ClassVar[Text] = Text("write XRAM bytes", "запись байтов XRAM")
    SPACE: ClassVar[str] = "xram"
    ADDRESS_BYTES: ClassVar[int] = 2


class ReadCodeBlock(_ReadBlock):
    """25 CREADDC: `25 AL AH N` → as 23 (D7)."""

    __slots__ = ()
    CODES: ClassVar[tuple[int, ...]] = (0x25,)
    SOURCE_NAME: ClassVar[str] = "CREADDC"
    TITLE: ClassVar[Text] = Text("read CODE bytes", "чтение байтов CODE")
    SPACE: ClassVar[str] = "code"
    ADDRESS_BYTES: ClassVar[int] = 2
    COUNT_FORMS: ClassVar[tuple[bool, ...]] = (False, True)


class WriteCodeBlock(_WriteBlock):
    """26 CWRITDC: `26 AL AH N B1 … BN` → `00` / `01` (D8)."""

    __slots__ = ()
    CODES: ClassVar[tuple[int, ...]] = (0x26,)
    SOURCE_NAME: ClassVar[str] = "CWRITDC"
    TITLE: ClassVar[Text] = Text("write CODE bytes", "запись байтов CODE")
    SAFETY: ClassVar[Safety] = Safety.DANGEROUS
    SPACE: ClassVar[str] = "code"
    ADDRESS_BYTES: ClassVar[int] = 2
