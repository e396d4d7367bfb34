"""The base of all commands: request, response lengths, decoding of the response, safety (§3).

A command object is one valid request: its constructor refuses an invalid address or value. It
handles bodies; `mikas.framing` adds the rest (§2). The tester calls `body()` and `read()`, the
virtual ECU `parse()` and `respond()`. There are three kinds of bad response: the ECU refused
(`EcuRefused`), the frame is valid but of another request (`WrongLength`, `WrongAddress`), or its
content is invalid (`WrongContent`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from enum import IntEnum, StrEnum
from typing import Any, ClassVar, Generic, Self, TypeVar

from mikas import errors
from mikas.i18n import Text

T = TypeVar("T")
SizeOf = Callable[[int], int | None]  # a parameter's code → bytes of its datum, None: unknown

OK = b"\x00"
ERROR = b"\x01"
NO_COMPLETION_CODE = Text(
    "{code} is no completion code (00 or 01)", "{code} — не код завершения (00 или 01)"
)


class Safety(IntEnum):
    """The possible effect of a command on the ECU, from harmless to worst."""

    READ = 0
    """Changes nothing."""
    REVERSIBLE = 1
    """Taken to end with a power cycle; the source does not say."""
    LASTING = 2
    """May outlive a power cycle; the source does not say."""
    DANGEROUS = 3
    """Writes to CODE, and GOTO: the unit may be left unable to run."""


class Space(StrEnum):
    """A memory space."""

    RAM = "ram"
    """Internal RAM, addresses of one byte."""
    XRAM = "xram"
    """External RAM, addresses of two bytes."""
    CODE = "code"
    """Program memory, addresses of two bytes."""
    SFR = "sfr"
    """Special function registers, addresses of one byte."""

    @property
    def address_bytes(self) -> int:
        """The number of bytes of an address."""
        return 2 if self in (Space.XRAM, Space.CODE) else 1

    @property
    def last(self) -> int:
        """The highest address, equal in every unit."""
        return (1 << 8 * self.address_bytes) - 1


class MalformedRequest(ValueError):
    """The body is no request of this command; raised on the ECU's side only."""


class Command(ABC, Generic[T]):
    """One request. `CODES`: its first bytes; `SOURCE_NAME`: the source's name for it (`row`)."""

    __slots__ = ()

    CODES: ClassVar[tuple[int, ...]]
    """Its first byte; several for one command in several forms."""
    SOURCE_NAME: ClassVar[str]
    """The source's name for it."""
    TITLE: ClassVar[Text]
    """Its title for people."""
    SAFETY: ClassVar[Safety] = Safety.READ
    """Its possible effect."""
    STREAM: ClassVar[bool] = False  # answered again and again, until ended by D12
    """Whether it is answered again and again, until D12 ends it."""
    ANSWERED: ClassVar[bool] = True  # False: no response is expected (D9)
    """Whether a response is expected (D9)."""
    LENGTHS: ClassVar[tuple[int, ...]] = ()  # of the response's body, if all requests have the same
    """The lengths of the response's body, if all requests have the same."""

    @property
    def code(self) -> int:
        """The first byte of the request."""
        return self.CODES[0]

    @property
    def repeatable(self) -> bool:
        """Whether sending the request twice has the same effect as once."""
        return self.SAFETY is Safety.READ and not self.STREAM

    @property
    def name(self) -> Text:
        """The source's name and the code, `CREADP (61)`."""
        return self.name_by(self.code)

    @classmethod
    def name_by(cls, code: int) -> Text:
        """Return the `name` of the requests with this one of `CODES`.

        In Russian the title, if the source has no mnemonic.
        """
        in_russian = cls.SOURCE_NAME if cls.SOURCE_NAME.isupper() else f"«{cls.TITLE.ru}»"
        return Text(f"{cls.SOURCE_NAME} ({code:02X})", f"{in_russian} ({code:02X})")

    @abstractmethod
    def body(self) -> bytes:
        """Return the request's body."""

    def response_lengths(self) -> Sequence[int]:
        """Return the possible lengths of the response's body, the usual one first."""
        return self.LENGTHS

    def read(self, body: bytes) -> T:
        """Decode the response `body`.

        Raises `WrongLength`, `WrongAddress` or `WrongContent` for a response that does not fit,
        `WriteRefused` or `NotSupported` for a refusal.
        """
        try:
            if len(body) in self.response_lengths():
                return self._read(body)
            if body == ERROR:  # D10: a usual reply to an unknown command
                raise errors.NotSupported(command=self.name)
            expected = lengths_in_words(self.response_lengths())
            raise errors.WrongLength(length=len(body), expected=expected)
        except errors.MikasError as error:
            error.request, error.received = self.body(), body
            raise

    @abstractmethod
    def _read(self, body: bytes) -> T:
        """Decode a body of a valid length; `read` adds the bytes to an error."""

    @abstractmethod
    def respond(self, value: T) -> bytes:
        """Return the response's body for `value`: the inverse of `read`."""

    @classmethod
    @abstractmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        """Parse a request's body, the inverse of `body()`. Raises `MalformedRequest`."""


C = TypeVar("C", bound=Command[Any])
rows: list[type[Command[Any]]] = []  # of §3's table, as entered by `row`


def row(
    codes: int | tuple[int, ...], source_name: str, title: Text
) -> Callable[[type[C]], type[C]]:
    """Enter a command into §3's table: its first bytes, the source's name, its title."""

    def enter(command: type[C]) -> type[C]:
        command.CODES = (codes,) if isinstance(codes, int) else codes
        command.SOURCE_NAME = source_name
        command.TITLE = title
        rows.append(command)
        return command

    return enter


class OnlyCode(Command[T]):
    """A request of one byte, the code."""

    __slots__ = ()

    def body(self) -> bytes:
        return bytes([self.code])

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        if len(body) != 1:
            raise MalformedRequest
        return cls()


class ReadNumber(OnlyCode[int]):
    """A command without arguments, answered by one byte."""

    __slots__ = ()
    LENGTHS: ClassVar[tuple[int, ...]] = (1,)

    def _read(self, body: bytes) -> int:
        return body[0]

    def respond(self, value: int) -> bytes:
        return bytes([value])


class Write(Command[None]):
    """A command answered by a completion code: `00` ok, `01` error."""

    __slots__ = ()
    LENGTHS: ClassVar[tuple[int, ...]] = (1,)

    def _read(self, body: bytes) -> None:
        if body == ERROR:
            raise errors.WriteRefused
        if body != OK:
            raise errors.WrongContent(problem=NO_COMPLETION_CODE.filled(code=body.hex().upper()))

    def respond(self, value: None = None) -> bytes:  # noqa: ARG002  (same shape as every command)
        return OK


def lengths_in_words(lengths: Sequence[int]) -> str:
    """Return `4`, `5 / 6`, `1, 3, 5 …`."""
    if len(lengths) > 3:
        return ", ".join(map(str, lengths[:3])) + " …"
    return " / ".join(map(str, lengths))


def check_range(space: str, address: int, count: int = 1) -> None:
    """Raise `AddressOutOfRange` unless `count` bytes at `address` lie within this `Space`.

    `UsageError`: one of them is no whole number.
    """
    for number in (address, count):
        _check_whole(number)
    last = Space(space).last
    if address < 0 or count < 1 or address + count - 1 > last:
        raise errors.AddressOutOfRange(space=space, last=last, address=address, count=count)


def check_byte(name: str, value: int) -> None:
    """Raise `ValueDoesNotFit` unless `value` is a byte, `UsageError` if it is no whole number."""
    _check_whole(value)
    if not 0 <= value <= 0xFF:
        raise errors.ValueDoesNotFit(
            value=value, name=name, allowed=Text("a byte is 0 to 255", "байт — от 0 до 255")
        )


def check_bytes(data: bytes) -> None:
    """Raise `UsageError` unless `data` is bytes."""
    if not isinstance(data, bytes | bytearray | memoryview):
        raise errors.usage_error(
            f"bytes are needed, as bytes.fromhex('61 1A') makes them, not {data!r}",
            f"нужны байты, как их даёт bytes.fromhex('61 1A'), а не {data!r}",
        )


def _check_whole(number: int) -> None:
    if not hasattr(number, "__index__"):
        raise errors.usage_error(
            f"a whole number is needed, such as 128 or 0x80, not {number!r}",
            f"нужно целое число, например 128 или 0x80, а не {number!r}",
        )
