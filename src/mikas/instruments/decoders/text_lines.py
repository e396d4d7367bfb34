"""Lines of text by patterns: AEM, 14point7, and whatever else sends its values as text.

The first pattern that fits a line, with values inside their channels' ranges, decides. The first
line of a connection may lack its begin (“4.7” of “14.7”), which nothing shows: it is left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from mikas.i18n import Text
from mikas.instruments.decoders.lines import LineDecoder
from mikas.instruments.decoders.patterns import LinePattern
from mikas.instruments.events import NOT_UNDERSTOOD, OUT_OF_RANGE, Fits

LONGEST_LINE: Final = 256


class TextLineDecoder(LineDecoder):
    """Decodes lines by `patterns`."""

    longest = LONGEST_LINE
    skips_first = True

    def __init__(self, patterns: tuple[LinePattern, ...], fits: Fits) -> None:
        super().__init__(fits)
        self._patterns = patterns

    def _decoded(self, line: bytes) -> Mapping[str, float] | Text:
        text = line.decode("utf-8", "replace").strip()
        if not text:
            return {}
        matched = [found for each in self._patterns if (found := each.values(text)) is not None]
        if not matched:
            return NOT_UNDERSTOOD
        return next(filter(self._fits, matched), OUT_OF_RANGE)
