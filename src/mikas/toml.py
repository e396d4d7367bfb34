"""TOML files of the user: the catalog, a scenario, the config file.

The standard parser takes quadratic time for keys with many dots, and calls itself for each level of
nesting. So a file's size, and by one pass over its text the size of its parts, are bounded before
it is parsed. The bounds are far above what a person writes; the shipped catalog has 55 KB.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from mikas.files import read_regular
from mikas.i18n import Text

MOST_BYTES: Final = 1 << 20
DEEPEST: Final = 32  # brackets in brackets
MOST_PARTS: Final = 16  # of a key with dots
LONGEST_WORD: Final = 200  # characters of a part of a key, and of a number; as in _TOKEN
MOST_KEYS: Final = 20_000  # and tables
MOST_VALUES: Final = 200_000  # in lists

_TOKEN: Final = re.compile(
    r'''
      (?P<space> \#[^\n]*
        | """ (?: \\. | [^\\] )*? (?: """ | \Z )  |  \'\'\' .*? (?: \'\'\' | \Z ) )
    | (?P<quoted> " (?: \\. | [^"\\\n] )* "?  |  ' [^'\n]* '? )
    | (?P<long> (?<! [^\s\[\]{}=,."'\#] ) [^\s\[\]{}=,."'\#]{201,} )
    | [\n\[\]{}=,.]
    ''',
    re.VERBOSE | re.DOTALL,
)  # every alternative takes all that it has looked at, so the pass is linear


class TomlError(ValueError):
    """A file that is no TOML, or too large a one. `line`: from 1; 0: unknown."""

    def __init__(self, line: int, problem: Text) -> None:
        super().__init__(problem.en)
        self.line: int = line
        self.problem: Text = problem


def read_bytes(path: Path) -> bytes:
    """Return the content of a user's file, also by a link. Raises `OSError`."""
    return read_regular(path, MOST_BYTES, follow=True)


def text_of(data: bytes) -> str:
    """Return the text of a file, with bare newlines. Raises `TomlError`."""
    try:
        return data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise TomlError(data.count(b"\n", 0, error.start) + 1, _ENCODING) from error


def parse(
    text: str, parse_float: Callable[[str], Any] = float, *, bounded: bool = True
) -> dict[str, Any]:
    """Return the tables of a text. Raises `TomlError`. `bounded` false: the text is our own."""
    if bounded:
        _check(text)
    try:
        return tomllib.loads(text, parse_float=parse_float)
    except (ValueError, RecursionError) as error:
        place = re.search(r"at line (\d+)", str(error))
        line = int(place[1]) if place else text.count("\n") + 1 if "at end" in str(error) else 0
        problem = Text(f"this is not TOML: {error}", "здесь ошибка записи TOML")
        raise TomlError(line, problem) from error


def _check(text: str) -> None:
    """Raise `TomlError` if a part of the text is larger than the bounds."""
    line, depth, keys, values = 1, 0, 0, 0
    parts, longest = 1, 0  # of the key or value being read
    begins, is_header = True, False  # at the begin of a line; inside of [a.b]
    for match in _TOKEN.finditer(text):
        token, kind = match[0], match.lastgroup
        if kind == "space":
            line += token.count("\n")
            continue
        if kind == "long" or (longest > LONGEST_WORD and (token in "=." or is_header)):
            raise TomlError(line, _LONG)
        if kind == "quoted":
            longest = max(longest, len(token))  # too long for a key; a text may be longer
            line += token.count("\n")
        elif token == ".":
            parts += 1
            if parts > MOST_PARTS:
                raise TomlError(line, _DOTS)
        else:
            parts, longest = 1, 0
        if token in "[{":
            is_header = begins and token == "["
            depth += 1
            if depth > DEEPEST:
                raise TomlError(line, _DEEP)
        elif token in "]}":
            depth, is_header = max(0, depth - 1), False
        keys += token == "=" or (token == "[" and is_header)
        values += token in "[{,"
        if keys > MOST_KEYS or values > MOST_VALUES:
            raise TomlError(line, _MANY)
        begins = token == "\n" and not depth
        line += token == "\n"


_ENCODING: Final = Text(
    "the file is not UTF-8; save it in this encoding",
    "файл не в кодировке UTF-8; сохраните его в ней",
)
_DEEP: Final = Text(
    f"brackets are nested more than {DEEPEST} levels deep; close them, or use tables: [a.b]",
    f"вложенность скобок больше {DEEPEST} уровней; закройте их или пишите таблицами: [a.b]",
)
_DOTS: Final = Text(
    f"a name has more than {MOST_PARTS} parts between dots; shorten it",
    f"в имени больше {MOST_PARTS} частей через точку; сократите его",
)
_LONG: Final = Text(
    f"a name or a number is longer than {LONGEST_WORD} characters; shorten it",
    f"имя или число длиннее {LONGEST_WORD} знаков; сократите его",
)
_MANY: Final = Text(
    f"the file has more than {MOST_KEYS} names or {MOST_VALUES} values; split it",
    f"в файле больше {MOST_KEYS} имён или {MOST_VALUES} значений; разделите его",
)
