"""What decoders of lines share: lines of bounded length in, one event for each out."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from typing import ClassVar, Final

from mikas.i18n import Text
from mikas.instruments.decoders.splitting import LineSplitter
from mikas.instruments.events import (
    NOT_UNDERSTOOD,
    OUT_OF_RANGE,
    TOO_LONG,
    Fits,
    InstrumentEvent,
    InstrumentValues,
    NoValues,
)

_SHOWN: Final = 256  # bytes of a line that gave no value


class LineDecoder(ABC):
    """An `InstrumentDecoder` of lines. `fits`: whether the channels can have these values."""

    longest: ClassVar[int]
    """Bytes of a line."""
    skips_first: ClassVar[bool] = False
    """As that of `LineSplitter`."""

    def __init__(self, fits: Fits) -> None:
        self._fits = fits
        self._lines = LineSplitter(self.longest, skips_first=self.skips_first)

    @abstractmethod
    def _decoded(self, line: bytes) -> Mapping[str, float] | Text:
        """Return the values of a line, none of a line of another kind; a text: why it has none.

        Raises `ValueError`, `LookupError`, `TypeError`, `OverflowError` or `RecursionError` for one
        that can't be understood.
        """

    def drop(self) -> None:
        """As `InstrumentDecoder.drop`."""
        self._lines.drop()

    def feed(self, data: bytes) -> list[InstrumentEvent]:
        """As `InstrumentDecoder.feed`."""
        return list(self._events(data))

    def _events(self, data: bytes) -> Iterator[InstrumentEvent]:
        for line in self._lines.feed(data):
            found = self._checked(line.data) if line.is_whole else TOO_LONG
            if isinstance(found, Text):
                yield NoValues(line.end, found, line.data[:_SHOWN])
            elif found:
                yield InstrumentValues(line.end, found)

    def _checked(self, line: bytes) -> Mapping[str, float] | Text:
        try:
            found = self._decoded(line)
        except (ValueError, LookupError, TypeError, OverflowError, RecursionError):
            return NOT_UNDERSTOOD
        return found if isinstance(found, Text) or self._fits(found) else OUT_OF_RANGE
