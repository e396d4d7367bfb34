"""Lines of text by patterns: AEM, 14point7, and whatever else sends its values as text.

The first pattern that fits a line, with values inside their channels' ranges, decides. The first
line of a connection may lack its begin (“4.7” of “14.7”), which nothing shows: it is left out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Final

from mikas.instruments.decoders.patterns import LinePattern
from mikas.instruments.decoders.splitting import LineSplitter
from mikas.instruments.events import (
    NOT_UNDERSTOOD,
    OUT_OF_RANGE,
    TOO_LONG,
    InstrumentEvent,
    InstrumentValues,
    NoValues,
)

LONGEST_LINE: Final = 256


class TextLineDecoder:
    """Decodes lines by `patterns`. `fits`: whether a channel can have a value."""

    def __init__(
        self, patterns: tuple[LinePattern, ...], fits: Callable[[Mapping[str, float]], bool]
    ) -> None:
        self._patterns, self._fits = patterns, fits
        self._lines = LineSplitter(LONGEST_LINE, skips_first=True)

    def drop(self) -> None:
        """As `InstrumentDecoder.drop`."""
        self._lines.drop()

    def feed(self, data: bytes) -> list[InstrumentEvent]:
        """As `InstrumentDecoder.feed`."""
        return list(self._events(data))

    def _events(self, data: bytes) -> Iterator[InstrumentEvent]:
        for line in self._lines.feed(data):
            if not line.is_whole:
                yield NoValues(line.end, TOO_LONG, line.data)
                continue
            reason, text = NOT_UNDERSTOOD, line.data.decode("utf-8", "replace").strip()
            if not text:
                continue
            for pattern in self._patterns:
                values = pattern.values(text)
                if values is not None and self._fits(values):
                    yield InstrumentValues(line.end, values)
                    break
                reason = reason if values is None else OUT_OF_RANGE
            else:
                yield NoValues(line.end, reason, line.data)
