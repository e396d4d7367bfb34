"""What a decoder makes of bytes: values, or the reason why there are none."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from mikas.i18n import Text


@dataclass(frozen=True, slots=True)
class InstrumentValues:
    """The values of one message, by channel."""

    end: int
    """The bytes since the decoder's begin, with the message's last one."""
    values: Mapping[str, float]
    """By the channel's name, in its unit."""


@dataclass(frozen=True, slots=True)
class NoValues:
    """Bytes that give no value."""

    end: int
    """The bytes since the decoder's begin, with these."""
    reason: Text
    """Why."""
    data: bytes
    """The bytes, the first of many."""


InstrumentEvent = InstrumentValues | NoValues

Fits = Callable[[Mapping[str, float]], bool]
"""Whether the channels can have these values: a decoder is given it."""


class InstrumentDecoder(Protocol):
    """Bytes of one instrument in, events out.

    It never raises, holds some kilobytes at most, and gives the same events however the bytes are
    cut into pieces.
    """

    def feed(self, data: bytes) -> list[InstrumentEvent]:
        """Take the next bytes; return what they complete."""

    def drop(self) -> None:
        """Forget an unfinished message: bytes are missing here, as the connection was lost."""


# Reasons

NOT_UNDERSTOOD = Text("not understood", "не разобрано")
TOO_LONG = Text("a line without an end", "строка без конца")
WRONG_CHECKSUM = Text("wrong checksum", "неверная контрольная сумма")
OUT_OF_RANGE = Text(
    "a value that the instrument can't have", "значение, какого у прибора не бывает"
)
NO_FIX = Text("no position yet", "координат ещё нет")
