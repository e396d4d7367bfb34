"""Parameters by code: count, read, write, list, stream (§3, rows 60–64, 71, 7F–83; D15).

A response consists of data without lengths, so each code has its size from the catalog.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import ClassVar, NamedTuple, Self, TypeVar

from mikas.commands.base import (
    ERROR,
    Command,
    MalformedRequest,
    ReadNumber,
    Safety,
    SizeOf,
    Write,
    check_byte,
    row,
)
from mikas.errors import NotSupported
from mikas.i18n import Text

T = TypeVar("T")
Data = tuple[bytes, ...]  # one datum a parameter, in the order asked


class Datum(NamedTuple):
    """A parameter on the wire: its code and number of bytes."""

    code: int
    """The parameter's code."""
    size: int
    """The bytes of its datum, which no response says."""


@row(0x60, "CNUMPAR", Text("number of parameters", "количество параметров"))
@dataclass(frozen=True, slots=True)
class CountParameters(ReadNumber):
    """60 CNUMPAR: `60` → `B`, the number of the unit's parameters."""


@dataclass(frozen=True, slots=True)
class _ForParameters(Command[T]):
    """A request of the codes of `parameters`."""

    parameters: tuple[Datum, ...]
    """The parameters in the order of the request."""

    def __post_init__(self) -> None:
        if not self.parameters:
            raise ValueError("at least one parameter")
        for parameter in self.parameters:
            check_byte("code", parameter.code)
            if parameter.size < 1:
                raise ValueError("a datum has at least one byte")

    def body(self) -> bytes:
        return bytes([self.code, *(p.code for p in self.parameters)])

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        return cls(_parse_codes(body[1:], size_of))


@dataclass(frozen=True, slots=True)
class _DataCommand(_ForParameters[Data]):
    """Answered by the data of `parameters` in order."""

    def response_lengths(self) -> Sequence[int]:
        return (sum(p.size for p in self.parameters),)

    def _read(self, body: bytes) -> Data:
        rest = BytesIO(body)
        return tuple(rest.read(parameter.size) for parameter in self.parameters)

    def respond(self, value: Data) -> bytes:
        return b"".join(value)


def _parse_codes(codes: bytes, size_of: SizeOf) -> tuple[Datum, ...]:
    if not codes:
        raise MalformedRequest
    data = []
    for code in codes:
        size = size_of(code)
        if size is None:
            raise MalformedRequest(f"no parameter {code:02X}")
        data.append(Datum(code, size))
    return tuple(data)


@row(0x61, "CREADP", Text("read parameters", "чтение параметров"))
class ReadParameters(_DataCommand):
    """61 CREADP: `61 P1 … PN` → `D1 … DN`, one or several. Wire for TWAT: `61 1A 85 0D`."""

    __slots__ = ()


class ReadUnknownSize(ReadParameters):
    """61 for a code of unknown size, listed once or more: the response's length gives the size.

    The data are one for each listing; a single one of the whole response if its length does not
    divide so; none for an empty response. Listed once, `01` may be a datum or a refusal (D10).
    """

    __slots__ = ()
    LONGEST: ClassVar[int] = 0xFF  # bytes of a datum
    """The most bytes of a datum."""

    @classmethod
    def of(cls, code: int, times: int) -> Self:
        """Return the request for `code`, listed `times` times."""
        return cls((Datum(code, 1),) * times)

    def response_lengths(self) -> Sequence[int]:
        return range(self.LONGEST * len(self.parameters) + 1)

    def _read(self, body: bytes) -> Data:
        times = len(self.parameters)
        if times > 1 and body == ERROR:
            raise NotSupported(command=self.name)
        size = len(body) // times if len(body) % times == 0 else len(body)
        return tuple(body[start : start + size] for start in range(0, len(body), size or 1))


@row(0x62, "CWRITP", Text("write a parameter", "запись параметра"))
@dataclass(frozen=True, slots=True)
class WriteParameter(Write):
    """62 CWRITP: `62 P D…` → `00` / `01`; the datum has the parameter's size."""

    parameter: int
    """The parameter's code."""
    data: bytes
    """The datum to write."""

    SAFETY: ClassVar[Safety] = Safety.LASTING

    def __post_init__(self) -> None:
        check_byte("code", self.parameter)
        if not self.data:
            raise ValueError("at least one data byte")

    def body(self) -> bytes:
        return bytes([self.code, self.parameter]) + self.data

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        if len(body) < 3:
            raise MalformedRequest
        return cls(body[1], body[2:])


# §3: two writes in a row, each answered 00. The cell 0E has no row in §4: no name is invented.
ERASE_FAULTS = (WriteParameter(0x0E, b"\x08"), WriteParameter(0x0E, b"\x00"))


@row(0x63, "CREADL", Text("read the list", "чтение по списку"))
class ReadList(_DataCommand):
    """63 CREADL: `63` → `D1 … DN` of the list that 64 set; `parameters` is that list."""

    __slots__ = ()

    def body(self) -> bytes:
        return b"\x63"

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        """Raise `MalformedRequest`: only the ECU's side has the list, from `WriteList`."""
        raise MalformedRequest("the list comes from 64")


@row(0x64, "CWRITL", Text("set the list", "запись списка"))
@dataclass(frozen=True, slots=True)
class WriteList(Write, _ForParameters[None]):
    """64 CWRITL: `64 P1 … PN` → `00` / `01`: sets the list that 63 reads."""

    SAFETY: ClassVar[Safety] = Safety.REVERSIBLE


@row(0x71, "CREADPF", Text("cyclic stream", "циклический поток"))
class StreamCyclic(_DataCommand):
    """71 CREADPF: `71 P1 … PN` → `D1 … DN` repeatedly, independent of the crankshaft."""

    __slots__ = ()
    STREAM: ClassVar[bool] = True


@row(
    (0x7F, 0x80, 0x81, 0x82, 0x83),
    "CREADPS",
    Text("stream at a stroke", "поток по такту двигателя"),
)
@dataclass(frozen=True, slots=True)
class StreamAtStroke(_DataCommand):
    """7F 80 81 82 83, CREADPS: `D1 … DN` once an engine cycle, at stroke 0, 1, 2, 3 or 4 (D15)."""

    stroke: int = 0
    """0 … 4: which moment of the engine's cycle (D15)."""

    STREAM: ClassVar[bool] = True

    def __post_init__(self) -> None:
        _DataCommand.__post_init__(self)
        if not 0 <= self.stroke < len(self.CODES):
            raise ValueError("a stroke is 0 to 4")

    @property
    def code(self) -> int:
        return self.CODES[self.stroke]

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        return cls(_parse_codes(body[1:], size_of), cls.CODES.index(body[0]))
