"""The blocks of a pcapng file: bytes from values, values from bytes. Pure; opens nothing.

The part of the IETF draft "PCAP Next Generation Capture File Format" that a recorded serial line
needs: section, interface, enhanced packet and custom blocks; simple packets are read, too.
A block is `type, length, body, length`; the second length distinguishes whole blocks from damaged
ones. Both byte orders are read, the little-endian one is written.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Final, Literal

from mikas.cleaning import clean_text

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

Order = Literal["<", ">"]
ORDERS: Final[tuple[Order, ...]] = ("<", ">")

SECTION: Final = 0x0A0D0D0A  # the same in both byte orders
INTERFACE: Final = 1
SIMPLE: Final = 3
ENHANCED: Final = 6
CUSTOM: Final = 0x0BAD
CUSTOM_PRIVATE: Final = 0x40000BAD  # a tool that edits the file must not copy it

LINKTYPE_USER0: Final = 147  # for private use: no registered type means "bytes of a serial line"
LINKTYPE_USER1: Final = 148  # likewise: the bytes of an instrument beside the unit
LINKTYPE_USER2: Final = 149  # likewise: the K-Line at another baud rate, in another protocol
INBOUND: Final = 1  # epb_flags, bits 0-1
OUTBOUND: Final = 2

_ORDER_MAGIC: Final = 0x1A2B3C4D
_UNKNOWN_LENGTH: Final = -1  # of a section
BYTE_ORDERS: Final = {struct.pack(order + "I", _ORDER_MAGIC): order for order in ORDERS}
"""By bytes 8 to 11 of a section's header."""
_MICROSECONDS: Final = 6
_END = 0
_LONGEST: Final = 0xFFFF  # characters of a text, as of the bytes of one option


class Malformed(ValueError):
    """A whole block with a contradictory body."""


@dataclass(frozen=True, slots=True)
class Section:
    """Section Header Block: begins a recording; its interfaces are counted from 0."""

    hardware: str = ""
    application: str = ""
    version: tuple[int, int] = (1, 0)


@dataclass(frozen=True, slots=True)
class Interface:
    """Interface Description Block: one port. `tsresol` and `tsoffset` define a tick.

    `comment`: of an instrument's port, the text of its definition.
    """

    link_type: int = LINKTYPE_USER0
    name: str = ""
    description: str = ""
    speed: int = 0
    tsresol: int = _MICROSECONDS
    tsoffset: int = 0
    comment: str = ""

    @property
    def ticks_per_second(self) -> int:
        """10^n, or 2^n when the top bit of if_tsresol is set."""
        power = self.tsresol & 0x7F
        return 1 << power if self.tsresol & 0x80 else int(10**power)

    def time(self, ticks: int) -> float:
        """Return seconds since the zero of the link's clock (1970 of a real one); rounded once."""
        return (self.tsoffset * self.ticks_per_second + ticks) / self.ticks_per_second


@dataclass(frozen=True, slots=True)
class EnhancedPacket:
    """Enhanced Packet Block. `cut`: number of bytes that the capturing program left out."""

    interface: int
    ticks: int
    data: bytes
    flags: int = 0
    comment: str = ""
    cut: int = 0


@dataclass(frozen=True, slots=True)
class SimplePacket:
    """Simple Packet Block: data of the first interface without time or direction."""

    data: bytes


@dataclass(frozen=True, slots=True)
class Custom:
    """Custom Block: `data` of the owner of the Private Enterprise Number `enterprise`."""

    enterprise: int
    data: bytes
    private: bool = False


Block = Section | Interface | EnhancedPacket | SimplePacket | Custom

# Options by code: the block's field, and the form of a number; texts have none.
_OPTIONS: Final[dict[type[Block], dict[int, tuple[str, str]]]] = {
    Section: {2: ("hardware", ""), 4: ("application", "")},
    Interface: {
        1: ("comment", ""),
        2: ("name", ""),
        3: ("description", ""),
        8: ("speed", "Q"),
        9: ("tsresol", "B"),
        14: ("tsoffset", "q"),
    },
    EnhancedPacket: {1: ("comment", ""), 2: ("flags", "I")},
}


def encode(block: Block, order: Order = "<") -> bytes:
    """Return the whole block, to be appended to a file."""
    match block:
        case Section(version=version):
            head = struct.pack(order + "IHHq", _ORDER_MAGIC, *version, _UNKNOWN_LENGTH)
            kind, body = SECTION, head + _options(block, order)
        case Interface(link_type):
            head = struct.pack(order + "HHI", link_type, 0, 0)
            kind, body = INTERFACE, head + _options(block, order)
        case EnhancedPacket(interface, ticks, data):
            captured = len(data)
            high, low = divmod(ticks, 1 << 32)
            head = struct.pack(order + "5I", interface, high, low, captured, captured + block.cut)
            kind, body = ENHANCED, head + _padded(data) + _options(block, order)
        case SimplePacket(data):
            kind, body = SIMPLE, struct.pack(order + "I", len(data)) + _padded(data)
        case Custom(enterprise, data, private):
            kind = CUSTOM_PRIVATE if private else CUSTOM
            body = struct.pack(order + "I", enterprise) + _padded(data)
    total = struct.pack(order + "I", len(body) + 12)
    return struct.pack(order + "I", kind) + total + body + total


def parse(kind: int, body: bytes, order: Order) -> Block | None:
    """Return the block with this body; None for an unknown kind. Raises `Malformed`."""
    reader = _READERS.get(kind)
    try:
        return reader(body, order) if reader else None
    except struct.error as error:
        raise Malformed(str(error)) from error


def _section(body: bytes, order: Order) -> Section:
    _, major, minor, _ = struct.unpack_from(order + "IHHq", body)
    return Section(**_fields(Section, body[16:], order), version=(major, minor))


def _interface(body: bytes, order: Order) -> Interface:
    link_type, _, _ = struct.unpack_from(order + "HHI", body)
    return Interface(link_type, **_fields(Interface, body[8:], order))


def _enhanced(body: bytes, order: Order) -> EnhancedPacket:
    interface, high, low, captured, original = struct.unpack_from(order + "5I", body)
    if 20 + captured > len(body):
        raise Malformed("the packet is longer than its block")
    return EnhancedPacket(
        interface=interface,
        ticks=high << 32 | low,
        data=body[20 : 20 + captured],
        cut=max(0, original - captured),
        **_fields(EnhancedPacket, body[20 + captured + -captured % 4 :], order),
    )


def _simple(body: bytes, order: Order) -> SimplePacket:
    (length,) = struct.unpack_from(order + "I", body)
    return SimplePacket(body[4 : 4 + length])


def _custom(body: bytes, order: Order, *, private: bool = False) -> Custom:
    (enterprise,) = struct.unpack_from(order + "I", body)
    return Custom(enterprise, body[4:], private)


def _padded(data: bytes) -> bytes:
    return data + bytes(-len(data) % 4)


def _options(block: Block, order: Order) -> bytes:
    """Return the option list. Empty texts and zeros are left out, except a resolution of 1 s."""
    options = b""
    for code, (name, form) in _OPTIONS[type(block)].items():
        if (field := getattr(block, name)) or name == "tsresol":
            value = struct.pack(order + form, field) if form else _text(field)
            options += struct.pack(order + "HH", code, len(value)) + _padded(value)
    return options and options + bytes(4)


def _fields(block: type[Block], data: bytes, order: Order) -> dict[str, Any]:
    """Return the fields that an option list gives; a text given repeatedly has several lines."""
    fields: dict[str, Any] = {}
    texts: dict[str, list[str]] = {}
    for code, value in _read_options(data, order):
        name, form = _OPTIONS[block].get(code, ("", ""))
        if form:
            fields[name] = _number(value, order + form)
        elif name:
            line = value.decode("utf-8", "replace").rstrip("\0")
            texts.setdefault(name, []).append(line)
    for name, lines in texts.items():
        fields[name] = clean_text("\n".join(lines), _LONGEST)
    return fields


def _read_options(data: bytes, order: Order) -> Iterator[tuple[int, bytes]]:
    position = 0
    while position < len(data):
        code, length = struct.unpack_from(order + "HH", data, position)
        position += 4
        if code == _END:
            return
        if position + length > len(data):
            raise Malformed("an option is longer than its block")
        yield code, data[position : position + length]
        position += length + -length % 4


def _text(text: str) -> bytes:
    """Return UTF-8, cut between two characters to the 65,535 bytes of an option."""
    return text.encode("utf-8", "replace")[:0xFFFF].decode("utf-8", "ignore").encode()


def _number(value: bytes, form: str) -> int:
    if len(value) != struct.calcsize(form):
        raise Malformed("an option has the wrong length")
    number: int = struct.unpack(form, value)[0]
    return number


_READERS: Final[dict[int, Callable[[bytes, Order], Block]]] = {
    SECTION: _section,
    INTERFACE: _interface,
    SIMPLE: _simple,
    ENHANCED: _enhanced,
    CUSTOM: _custom,
    CUSTOM_PRIVATE: partial(_custom, private=True),
}
KNOWN: Final = frozenset(_READERS)
