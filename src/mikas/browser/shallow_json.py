"""JSON that nests too deep is refused before Python's scanner reads it.

The scanner calls itself for each level. On a computer Python ends that with `RecursionError`; in a
browser the stack of JavaScript ends first, after some thousand levels, and with it the program.
"""

from __future__ import annotations

import json
import re
from typing import Any, Final

DEEPEST: Final = 900
"""Below what Python allows its own functions, so that nobody meets the difference."""
_STRING: Final = re.compile(r'"[^"\\]*(?:\\.[^"\\]*)*(?:"|\Z)', re.DOTALL)
_BRACKET: Final = re.compile(r"[][{}]")


def nests_too_deep(text: str) -> bool:
    """Return whether a text may nest deeper than `DEEPEST`; never false for one that does."""
    if text.count("[") + text.count("{") <= DEEPEST:
        return False
    depth = 0
    for bracket in _BRACKET.findall(_STRING.sub("", text)):
        depth += 1 if bracket in "[{" else -1
        if depth > DEEPEST:
            return True
    return False


def install() -> None:
    """Let each decoder look before it reads."""
    decoder: Any = json.JSONDecoder
    decode = decoder.decode

    def checked(self: json.JSONDecoder, s: str, *where: Any) -> Any:  # noqa: ANN401  (any value)
        if nests_too_deep(s):
            raise RecursionError("the JSON nests too deep")
        return decode(self, s, *where)

    decoder.decode = checked
