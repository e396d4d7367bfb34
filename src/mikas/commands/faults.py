"""Stored faults (§3, row 02). Erasing them is two parameter writes: `parameters.ERASE_FAULTS`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

from mikas.commands.base import ERROR, Command, MalformedRequest, SizeOf
from mikas.errors import NotSupported, WrongContent
from mikas.i18n import Text

SEPARATOR = 0xE0
_MOST = 0xFF


@dataclass(frozen=True, slots=True)
class ReadFaults(Command[tuple[int, ...]]):
    """02: the stored faults' numbers, as the ECU lists them.

    `02` → `N E1 E0 E2 E0 … EN E0`, every number followed by the separator E0; none: `00`. A fault
    numbered E0 is possible: only every second byte is a separator. Wire: `02 FE 0D`.
    """

    CODES: ClassVar[tuple[int, ...]] = (0x02,)
    SOURCE_NAME: ClassVar[str] = "read faults"
    TITLE: ClassVar[Text] = Text("stored faults", "запомненные неисправности")

    def body(self) -> bytes:
        return b"\x02"

    def response_lengths(self) -> Sequence[int]:
        return range(1, 2 * _MOST + 2, 2)

    def _read(self, body: bytes) -> tuple[int, ...]:
        if body == ERROR:  # D10: one fault would have its number behind it
            raise NotSupported(command=self.display_name, request=self.body(), received=body)
        count, numbers, separators = body[0], body[1::2], body[2::2]
        if count != len(numbers):
            raise WrongContent(
                problem=Text(
                    f"it announces {count} and holds {len(numbers)} faults",
                    f"объявлено ошибок {count}, а пришло {len(numbers)}",
                ),
                request=self.body(),
                received=body,
            )
        if any(byte != SEPARATOR for byte in separators):
            raise WrongContent(
                problem=Text("a fault is not followed by E0", "за номером ошибки нет E0"),
                request=self.body(),
                received=body,
            )
        return tuple(numbers)

    def respond(self, value: tuple[int, ...]) -> bytes:
        listed = value[:_MOST]
        return bytes([len(listed)]) + b"".join(bytes([n, SEPARATOR]) for n in listed)

    @classmethod
    def parse(cls, body: bytes, size_of: SizeOf) -> Self:
        if len(body) != 1:
            raise MalformedRequest
        return cls()
