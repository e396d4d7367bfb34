"""Jumping to an address (§3, row 41; D9)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

from mikas.commands.base import Command, MalformedRequest, Safety, SizeOf, check_range, low_high
from mikas.i18n import Text


@dataclass(frozen=True, slots=True)
class GoTo(Command[bytes]):
    """41 CGOTO: `41 AL AH`. D9: no response is expected; one that comes is shown.

    The most dangerous of all: the ECU runs whatever stands there. Wire for 8000: `41 00 80 3F 0D`.
    """

    address: int

    CODES: ClassVar[tuple[int, ...]] = (0x41,)
    SOURCE_NAME: ClassVar[str] = "CGOTO"
    TITLE: ClassVar[Text] = Text("go to an address", "переход по адресу")
    SAFETY: ClassVar[Safety] = Safety.DANGEROUS
    ANSWERED: ClassVar[bool] = False

    def __post_init__(self) -> None:
        check_range("code", 0xFFFF, self.address)

    def body(self) -> bytes:
        return bytes([self.code]) + low_high(self.address)

    def response_lengths(self) -> Sequence[int]:
        return ()

    def read(self, body: bytes) -> bytes:
        """Whatever came: no form is laid down for it."""
        return body

    _read = read

    def respond(self, value: bytes) -> bytes:
        return value

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        if len(body) != 3:
            raise MalformedRequest
        return cls(int.from_bytes(body[1:], "little"))
