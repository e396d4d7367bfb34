"""The pattern of a line: text with places for numbers, as `λ={LAMBDA} AFR={AFR}*`.

- `{NAME}`: a number, the value of the channel NAME; `{}`: a number that is not used.
- `*`: any text, up to the first place at which the rest of the pattern's text stands.
- A space: one or more spaces or tabs. A backslash before a character: that character.

It becomes a regular expression that never tries again what it has taken, so that no line takes
longer than its length: a recording may bring somebody else's pattern.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from mikas.errors import usage_error

LONGEST: Final = 200
"""Characters of a pattern."""

_TOKEN: Final = re.compile(
    r"\{(?P<name>[A-Za-z][A-Za-z0-9_]*)?\}|(?P<any>\*)|(?P<space>[ \t]+)|\\(?P<plain>.)"
    r"|(?P<text>[^{}*\\ \t]+)"
)
_NUMBER: Final = r"[+-]?+(?:\d{{1,12}}+(?:{point}\d{{0,12}}+)?+|{point}\d{{1,12}}+)"
_BEFORE_NUMBER: Final = r"[^0-9+.-]*+"


class LinePattern:
    """A pattern, ready to be matched. `decimal`: the sign between a number's parts.

    `names`: its channels, in capitals. Raises `UsageError` for another text.
    """

    def __init__(self, text: str, decimal: str = ".") -> None:
        self.text = text
        if len(text) > LONGEST:
            raise usage_error(
                f"is longer than {LONGEST} characters; shorten it",
                f"длиннее {LONGEST} знаков; сократите",
            )
        self._decimal = decimal
        self.names: tuple[str, ...] = ()
        self._match = re.compile(self._expression(text)).fullmatch
        if not self.names:
            raise usage_error(
                "has no {NAME}: write the channel's name where the number stands, as {AFR}",
                "без {ИМЯ}: напишите имя канала там, где стоит число, например {AFR}",
            )

    def _expression(self, text: str) -> str:
        number = _NUMBER.format(point=re.escape(self._decimal))
        names: list[str] = []
        pieces: list[str] = []
        wild, at = False, 0
        while at < len(text):
            token = _TOKEN.match(text, at)
            if token is None:
                raise usage_error(
                    f"has a lone “{text[at]}”; write \\{text[at]} for the character itself",
                    f"лишний знак «{text[at]}»; сам знак пишется \\{text[at]}",
                )
            at = token.end()
            kind = token.lastgroup
            if kind == "any":
                if wild:
                    raise usage_error("has two * in a row", "две * подряд")
                wild = True
                continue
            if kind in ("space", "plain", "text"):
                literal = r"[ \t]++" if kind == "space" else re.escape(token[kind])
                pieces.append(f"(?>.*?{literal})" if wild else literal)
            else:
                pieces.append(_BEFORE_NUMBER if wild else "")
                if name := token["name"]:
                    names.append(name.upper())
                pieces.append(f"({number})" if name else number)
            wild = False
        if wild:
            pieces.append(".*+")
        self.names = tuple(names)
        if len(set(names)) < len(names):
            raise usage_error("names a channel twice", "канал назван дважды")
        return "".join(pieces)

    def values(self, line: str) -> Mapping[str, float] | None:
        """Return the numbers of a line by channel; None: it is another kind of line."""
        found = self._match(line)
        if found is None:
            return None
        numbers = (float(number.replace(self._decimal, ".")) for number in found.groups())
        return dict(zip(self.names, numbers, strict=True))
