"""Texts in lines of a width: whole words, so that options, files and commands can be read."""

from __future__ import annotations

import re
from collections.abc import Iterator
from textwrap import wrap

NARROWEST = 20
_COMMAND = re.compile("`[^`]{1,40}`")  # it stays on one line
_GLUE = "\ue000"  # a blank at which no line is broken; of the private characters


def filled(text: str, width: int, indent: str = "") -> list[str]:
    """Return `text` in lines of `width`; those after the first begin with `indent`.

    A word that is wider stays whole. No line begins with a dash.
    """
    body = text.lstrip()
    begin = text[: len(text) - len(body)]
    glued = _COMMAND.sub(
        lambda found: found[0].replace(" ", _GLUE), body.replace(" —", f"{_GLUE}—")
    )
    lines = wrap(
        begin + glued,
        max(NARROWEST, width),
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace(_GLUE, " ") for line in lines]


def fitted(text: str, width: int) -> Iterator[str]:
    """Yield the lines of `text`, a wider one in several below its own indent."""
    for line in text.split("\n"):
        if len(line) <= width:
            yield line
        else:
            yield from filled(line, width, line[: len(line) - len(line.lstrip())])
