"""On which line each key of a TOML text stands.

The standard parser says where a text breaks the syntax, but not where a sound key is whose value
makes no sense. This scanner finds that. It relies on the text being valid TOML (the parser has
accepted it), and so needs no grammar beyond brackets, strings, dots and equals signs.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from typing import TypeAlias

KeyPath: TypeAlias = tuple[str, ...]

_TOKEN = re.compile(
    r'''
      (?P<skip> [ \t]+ | \#[^\n]* )
    | (?P<string>
          """ (?: \\. | [^\\] )*? "{3,5}  |  \'\'\' .*? '{3,5}
        | " (?: \\. | [^"\\] )* "  |  ' [^']* ' )
    | (?P<mark> [\n\[\]{}=,.] )
    | (?P<word> [^\s\[\]{}=,."'#]+ )
    ''',
    re.VERBOSE | re.DOTALL,
)


def lines_of(text: str) -> dict[KeyPath, int]:
    """The 1-based line where each table and key first appears, by its full path.

    `text` is valid TOML with bare newlines. Tables that a dotted key implies are listed too; keys
    of tables inside an array go by the array's path.
    """
    scanner = _Scanner()
    for token, is_name, line in _tokens(text):
        if scanner.in_key:
            scanner.key_token(token, is_name, line)
        else:
            scanner.value_token(token)
    return scanner.lines


class _Scanner:
    """Either within a key (or a header, or between statements), or within a value."""

    def __init__(self) -> None:
        self.lines: dict[KeyPath, int] = {}
        self.in_key = True
        self._key: list[str] = []
        self._key_line = 0
        self._table: KeyPath = ()  # the header above
        self._value: KeyPath = ()  # the path of the value being read
        self._open: list[tuple[str, KeyPath]] = []  # its brackets, and the path they belong to

    def key_token(self, token: str, is_name: bool, line: int) -> None:
        if is_name:
            self._key_line = self._key_line if self._key else line
            self._key.append(_unquoted(token))
        elif token == "]" and self._key:  # the end of a header; the second of ]] adds nothing
            self._table = self._record(())
        elif token == "=":
            self._value = self._record(self._open[-1][1] if self._open else self._table)
            self.in_key = False
        elif token == "}":  # an empty table
            self._value, self.in_key = self._open.pop()[1], False

    def value_token(self, token: str) -> None:
        if token in {"[", "{"}:
            self._open.append((token, self._value))
            self.in_key = token == "{"
        elif token in {"]", "}"}:
            self._value = self._open.pop()[1]
        elif token == ",":
            self.in_key = self._open[-1][0] == "{"
        elif token == "\n":
            self.in_key = not self._open

    def _record(self, inside: KeyPath) -> KeyPath:
        path = (*inside, *self._key)
        for length in range(1, len(path) + 1):
            self.lines.setdefault(path[:length], self._key_line)
        self._key = []
        return path


def _tokens(text: str) -> Iterator[tuple[str, bool, int]]:
    """Each token, whether it can be a name (a word or a string), and its line."""
    line = 1
    for match in _TOKEN.finditer(text):
        if match.lastgroup != "skip":
            yield match.group(), match.lastgroup != "mark", line
        line += match.group().count("\n")


def _unquoted(key: str) -> str:
    if key[0] in "\"'":
        return str(tomllib.loads(f"key = {key}")["key"])
    return key
