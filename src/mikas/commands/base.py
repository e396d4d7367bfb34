"""What every command is: its request, its response's length, how to read it, how dangerous it is
(§3).

A command object is one request, complete and valid: an address or a value that does not fit is
refused when it is made, so what exists can be sent. Bodies only; §2 adds the rest. Pure: no I/O, no
clock.

Both ends use the same class. The tester calls `body()` and `read()`, the virtual ECU `parse()` and
`respond()`. Three bad responses are told apart: the ECU refused (`EcuRefused`), the frame is sound
but not this request's (`WrongLength`, `WrongAddress`), or it makes no sense in itself
(`WrongContent`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import ClassVar, Generic, Self, TypeVar

from mikas.errors import (
    AddressOutOfRange,
    NotSupported,
    ValueDoesNotFit,
    WriteRefused,
    WrongContent,
    WrongLength,
)
from mikas.i18n import Text

T = TypeVar("T")
SizeOf = Callable[[int], int | None]  # a parameter's code → bytes of its datum, None: unknown

OK = b"\x00"
ERROR = b"\x01"


class Safety(IntEnum):
    """What a command can do to the ECU, from harmless to worst."""

    READ = 0
    REVERSIBLE = 1  # a power cycle undoes it
    LASTING = 2
    DANGEROUS = 3  # CODE writes, GOTO: may leave the unit unable to run


class MalformedRequest(ValueError):
    """A body is not a well-formed request of this command; only the ECU's side meets it."""


class Command(ABC, Generic[T]):
    """One request. `CODES`: its first bytes; `SOURCE_NAME`: the source's name for it."""

    __slots__ = ()

    CODES: ClassVar[tuple[int, ...]]
    SOURCE_NAME: ClassVar[str]
    TITLE: ClassVar[Text]
    SAFETY: ClassVar[Safety] = Safety.READ
    STREAM: ClassVar[bool] = False  # answered again and again, until ended by D12
    ANSWERED: ClassVar[bool] = True  # False: no response is expected (D9)

    @property
    def code(self) -> int:
        """The first byte of the request."""
        return self.CODES[0]

    @property
    def repeatable(self) -> bool:
        """Whether sending it twice does what sending it once does."""
        return self.SAFETY is Safety.READ and not self.STREAM

    @property
    def name(self) -> str:
        """The source's name and the code, `CREADP (61)`."""
        return f"{self.SOURCE_NAME} ({self.code:02X})"

    @property
    def display_name(self) -> Text:
        """`name` for people; where the source has no mnemonic, its name is English words."""
        in_russian = self.SOURCE_NAME if self.SOURCE_NAME.isupper() else f"«{self.TITLE.ru}»"
        return Text(self.name, f"{in_russian} ({self.code:02X})")

    @abstractmethod
    def body(self) -> bytes:
        """The request's body."""

    @abstractmethod
    def response_lengths(self) -> Sequence[int]:
        """Every length that the response's body can have, the usual one first."""

    def read(self, body: bytes) -> T:
        """What the response `body` says.

        Raises `WrongLength`, `WrongAddress` or `WrongContent` for a response that is not this
        request's, `WriteRefused` or `NotSupported` when the ECU said no; anything else is a bug.
        """
        if len(body) not in self.response_lengths():
            if body == ERROR:  # D10: one usual reply to a command that a unit does not know
                raise NotSupported(command=self.display_name, request=self.body(), received=body)
            raise WrongLength(
                length=len(body),
                expected=lengths_in_words(self.response_lengths()),
                request=self.body(),
                received=body,
            )
        return self._read(body)

    @abstractmethod
    def _read(self, body: bytes) -> T:
        """`read`, for a body whose length fits."""

    @abstractmethod
    def respond(self, value: T) -> bytes:
        """The response's body that says `value`: the ECU's side of `read`."""

    @classmethod
    @abstractmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        """The request that `body` is: the ECU's side of `body()`. Raises `MalformedRequest`."""


class ReadNumber(Command[int]):
    """A command of nothing but its code, answered by one byte."""

    __slots__ = ()

    def body(self) -> bytes:
        return bytes([self.code])

    def response_lengths(self) -> Sequence[int]:
        return (1,)

    def _read(self, body: bytes) -> int:
        return body[0]

    def respond(self, value: int) -> bytes:
        return bytes([value])

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        if len(body) != 1:
            raise MalformedRequest
        return cls()


class Write(Command[None]):
    """A command answered by a completion code: `00` ok, `01` error."""

    __slots__ = ()

    def response_lengths(self) -> Sequence[int]:
        return (1,)

    def _read(self, body: bytes) -> None:
        if body == ERROR:
            raise WriteRefused(request=self.body(), received=body)
        if body != OK:
            raise WrongContent(
                problem=Text(
                    f"{body.hex().upper()} is no completion code (00 or 01)",
                    f"{body.hex().upper()} — не код завершения (00 или 01)",
                ),
                request=self.body(),
                received=body,
            )

    def respond(self, value: None = None) -> bytes:  # noqa: ARG002  (same shape as every command)
        return OK


def lengths_in_words(lengths: Sequence[int]) -> str:
    """`4`, `5 or 6`, `1, 3, 5 …`."""
    if len(lengths) > 3:
        return ", ".join(map(str, lengths[:3])) + " …"
    return " / ".join(map(str, lengths))


def check_range(space: str, last: int, address: int, count: int = 1) -> None:
    """Raises `AddressOutOfRange` unless `count` bytes at `address` lie within 0 … `last`."""
    if address < 0 or count < 1 or address + count - 1 > last:
        raise AddressOutOfRange(space=space, last=last, address=address, count=count)


def check_byte(name: str, value: int) -> None:
    """Raises `ValueDoesNotFit` unless `value` is a byte."""
    if not 0 <= value <= 0xFF:
        raise ValueDoesNotFit(
            value=value, name=name, allowed=Text("a byte is 0 to 255", "байт — от 0 до 255")
        )


def low_high(address: int) -> bytes:
    """An address as it travels: low byte first (§2)."""
    return address.to_bytes(2, "little")
