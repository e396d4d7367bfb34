"""Memory commands (§3, rows 11–16, 21–26, 31, 32; D6–D8): one byte, or a block in one exchange.

An address has one byte for RAM and SFR, two for XRAM and CODE. A response repeats the request's
address before the data; a response with another address is never accepted (D13).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from typing import ClassVar, Self, TypeVar

from mikas.commands.base import (
    Command,
    MalformedRequest,
    Safety,
    SizeOf,
    Space,
    Write,
    check_byte,
    check_range,
    row,
)
from mikas.errors import WrongAddress, WrongContent
from mikas.i18n import Text

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class AtAddress(Command[T]):
    """A command at `address` of its space, followed in the request by a byte for each other field.

    Its response repeats the address before the data.
    """

    address: int
    """The first address."""

    SPACE: ClassVar[Space]
    """The memory space."""

    def __post_init__(self) -> None:
        check_range(self.SPACE, self.address)

    def body(self) -> bytes:
        return bytes([self.code]) + self._address() + bytes(astuple(self)[1:])

    def _address(self) -> bytes:
        return self.address.to_bytes(self.SPACE.address_bytes, "little")

    def _data_of(self, body: bytes) -> bytes:
        size = self.SPACE.address_bytes
        address, data = body[:size], body[size:]
        if address != self._address():
            raise WrongAddress(
                got=address[::-1].hex().upper(), asked=self._address()[::-1].hex().upper()
            )
        return data

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        end = 1 + cls.SPACE.address_bytes
        if len(body) != end + len(fields(cls)) - 1:
            raise MalformedRequest
        return cls(int.from_bytes(body[1:end], "little"), *body[end:])


@dataclass(frozen=True, slots=True)
class ByteCommand(AtAddress[int]):
    """A byte at `address`; both reading and writing answer `[address][byte]`."""

    def response_lengths(self) -> Sequence[int]:
        return (self.SPACE.address_bytes + 1,)

    def _read(self, body: bytes) -> int:
        return self._data_of(body)[0]

    def respond(self, value: int) -> bytes:
        return self._address() + bytes([value])


@dataclass(frozen=True, slots=True)
class WriteByte(ByteCommand):
    """Writes `value`; the response repeats address and byte, which `read` returns."""

    value: int
    """The byte to write."""

    SAFETY: ClassVar[Safety] = Safety.REVERSIBLE

    def __post_init__(self) -> None:
        check_range(self.SPACE, self.address)
        check_byte(self.SPACE, self.value)


@row(0x11, "CREADI", Text("read a RAM byte", "чтение байта RAM"))
class ReadRamByte(ByteCommand):
    """11 CREADI: `11 A` → `A B`. Wire for address 40: `11 40 00 AF 0D`."""

    __slots__ = ()
    SPACE: ClassVar[Space] = Space.RAM


@row(0x12, "CWRTI", Text("write a RAM byte", "запись байта RAM"))
class WriteRamByte(WriteByte):
    """12 CWRTI: `12 A B` → `A B`. D6: the request is missing in the source; inferred."""

    __slots__ = ()
    SPACE: ClassVar[Space] = Space.RAM


@row(0x13, "CREADX", Text("read an XRAM byte", "чтение байта XRAM"))
class ReadXramByte(ByteCommand):
    """13 CREADX: `13 AL AH` → `AL AH B`."""

    __slots__ = ()
    SPACE: ClassVar[Space] = Space.XRAM


@row(0x14, "CWRITX", Text("write an XRAM byte", "запись байта XRAM"))
class WriteXramByte(WriteByte):
    """14 CWRITX: `14 AL AH B` → `AL AH B`."""

    __slots__ = ()
    SPACE: ClassVar[Space] = Space.XRAM


@row(0x15, "CREADC", Text("read a CODE byte", "чтение байта CODE"))
class ReadCodeByte(ByteCommand):
    """15 CREADC: `15 AL AH` → `AL AH B`."""

    __slots__ = ()
    SPACE: ClassVar[Space] = Space.CODE


@row(0x16, "CWRITC", Text("write a CODE byte", "запись байта CODE"))
class WriteCodeByte(WriteByte):
    """16 CWRITC: `16 AL AH B` → `AL AH B`."""

    __slots__ = ()
    SAFETY: ClassVar[Safety] = Safety.DANGEROUS
    SPACE: ClassVar[Space] = Space.CODE


@row(0x31, "CREADSFR", Text("read an SFR", "чтение SFR"))
class ReadSfr(ByteCommand):
    """31 CREADSFR: `31 A` → `A B`, a special function register."""

    __slots__ = ()
    SPACE: ClassVar[Space] = Space.SFR


@row(0x32, "SWRITSFR", Text("write an SFR", "запись SFR"))
class WriteSfr(WriteByte):
    """32 SWRITSFR (spelled so in the source): `32 A B` → `A B`."""

    __slots__ = ()
    SPACE: ClassVar[Space] = Space.SFR


LARGEST_BLOCK = 0xFF  # the count is one byte
OTHER_COUNT = Text(
    "it announces {announced} bytes instead of {asked}",
    "объявлено байтов {announced} вместо {asked}",
)


def _check_block(space: Space, address: int, count: int) -> None:
    check_range(space, address, count)
    if count > LARGEST_BLOCK:
        raise ValueError(f"a block has at most {LARGEST_BLOCK} bytes")


@dataclass(frozen=True, slots=True)
class ReadBlock(AtAddress[bytes]):
    """`count` bytes from `address` on. `COUNT_FORMS`: whether the count is repeated (D7)."""

    count: int
    """How many bytes, 1 … 255."""

    COUNT_FORMS: ClassVar[tuple[bool, ...]]  # the usual form first
    """Whether the response repeats the count (D7), the usual form first."""

    def __post_init__(self) -> None:
        _check_block(self.SPACE, self.address, self.count)

    def response_lengths(self) -> Sequence[int]:
        size = self.SPACE.address_bytes
        return tuple(size + counted + self.count for counted in self.COUNT_FORMS)

    def _read(self, body: bytes) -> bytes:
        data = self._data_of(body)
        if len(data) > self.count:
            if data[0] != self.count:
                problem = OTHER_COUNT.filled(announced=data[0], asked=self.count)
                raise WrongContent(problem=problem)
            data = data[1:]
        return data

    def respond(self, value: bytes, *, counted: bool | None = None) -> bytes:
        """`counted`: whether to repeat the count; the source's form by default (D7)."""
        repeated = self.COUNT_FORMS[0] if counted is None else counted
        return self._address() + (bytes([self.count]) if repeated else b"") + value


@dataclass(frozen=True, slots=True)
class WriteBlock(Write, AtAddress[None]):
    """Writes `data` from `address` on. The source's rows 24, 26 lack the data bytes (D8)."""

    data: bytes
    """The bytes to write, 1 … 255."""

    SAFETY: ClassVar[Safety] = Safety.REVERSIBLE

    def __post_init__(self) -> None:
        _check_block(self.SPACE, self.address, len(self.data))

    def body(self) -> bytes:
        return bytes([self.code]) + self._address() + bytes([len(self.data)]) + self.data

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        count_at = 1 + cls.SPACE.address_bytes
        if len(body) <= count_at or len(body) != count_at + 1 + body[count_at]:
            raise MalformedRequest
        return cls(int.from_bytes(body[1:count_at], "little"), body[count_at + 1 :])


@row(0x21, "CREADDI", Text("read RAM bytes", "чтение байтов RAM"))
class ReadRamBlock(ReadBlock):
    """21 CREADDI: `21 A N` → `A N B1 … BN`."""

    __slots__ = ()
    SPACE: ClassVar[Space] = Space.RAM
    COUNT_FORMS: ClassVar[tuple[bool, ...]] = (True,)


@row(0x22, "CWRITDI", Text("write RAM bytes", "запись байтов RAM"))
class WriteRamBlock(WriteBlock):
    """22 CWRITDI: `22 A N B1 … BN` → `00` / `01`."""

    __slots__ = ()
    SPACE: ClassVar[Space] = Space.RAM


@row(0x23, "CREADDX", Text("read XRAM bytes", "чтение байтов XRAM"))
class ReadXramBlock(ReadBlock):
    """23 CREADDX: `23 AL AH N` → `AL AH B1 … BN`, or with the count as in 21 (D7)."""

    __slots__ = ()
    SPACE: ClassVar[Space] = Space.XRAM
    COUNT_FORMS: ClassVar[tuple[bool, ...]] = (False, True)


@row(0x24, "CWRITDX", Text("write XRAM bytes", "запись байтов XRAM"))
class WriteXramBlock(WriteBlock):
    """24 CWRITDX: `24 AL AH N B1 … BN` → `00` / `01` (D8)."""

    __slots__ = ()
    SPACE: ClassVar[Space] = Space.XRAM


@row(0x25, "CREADDC", Text("read CODE bytes", "чтение байтов CODE"))
class ReadCodeBlock(ReadBlock):
    """25 CREADDC: `25 AL AH N` → as 23 (D7)."""

    __slots__ = ()
    SPACE: ClassVar[Space] = Space.CODE
    COUNT_FORMS: ClassVar[tuple[bool, ...]] = (False, True)


@row(0x26, "CWRITDC", Text("write CODE bytes", "запись байтов CODE"))
class WriteCodeBlock(WriteBlock):
    """26 CWRITDC: `26 AL AH N B1 … BN` → `00` / `01` (D8)."""

    __slots__ = ()
    SAFETY: ClassVar[Safety] = Safety.DANGEROUS
    SPACE: ClassVar[Space] = Space.CODE
