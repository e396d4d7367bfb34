"""The text of a log: its encoding, its lines as cells, the numbers in these.

UTF-8 and UTF-16 are recognised (by their mark, or because the bytes are valid), everything else is
Windows-1251 unless the user says otherwise. A number is a number as one decimal sign writes it:
`1,234.5` is none, for it may be two things.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator
from math import inf, nan
from typing import Final

from mikas.cancellation import check_cancelled
from mikas.errors import ForeignLogError
from mikas.i18n import Text

ENCODINGS: Final = ("utf-8", "windows-1251", "utf-16", "windows-1252")
"""Those in which a log of text may be."""
DELIMITERS: Final = (";", "\t", "|", ",")
"""Those that are recognised; any other character can be given."""
DECIMALS: Final = (".", ",")
SPACE: Final = " "
"""As a delimiter it stands for a run of blanks."""

_LONGEST_CELL: Final = 1 << 16
_MOST_BREAKS: Final = 9  # lines of one cell: more come of an open quotation mark
_EACH: Final = 4096
_NUMBER: Final = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,4})?", re.ASCII)
_MISSING: Final = frozenset({"", "nan"})
_MOST_KEPT: Final = 1 << 16
_SAMPLE: Final = 200
_HINT: Final = re.compile(r'"?sep=([^"\r\n])"?[;,\t ]*\r?\n', re.IGNORECASE)
"""The first line of a file for Excel: it names the delimiter, and is no row."""


def decoded(data: bytes, name: str, encoding: str | None = None) -> tuple[str, str]:
    """Return the text and the encoding in which it was read. Raises `ForeignLogError`."""
    if encoding is None:
        encoding = _encoding_of(data)
    elif encoding not in ENCODINGS:
        known = ", ".join(ENCODINGS)
        raise ForeignLogError(
            name,
            Text(
                f"there is no encoding “{encoding}”; there are: {known}",
                f"кодировки «{encoding}» нет; есть: {known}",
            ),
        )
    try:
        text = data.decode(encoding).removeprefix("\ufeff")
    except UnicodeDecodeError as error:
        raise ForeignLogError(
            name,
            Text(
                f"no text in {encoding}: choose another encoding",
                f"это не текст в кодировке {encoding}: выберите другую",
            ),
            offset=error.start,
        ) from error
    if (at := text.find("\0")) >= 0:
        line = text.count("\n", 0, at) + 1
        raise ForeignLogError(
            name,
            Text(
                "not a text file: it has bytes of zero; save the log as CSV, or choose its "
                "encoding",
                "это не текстовый файл: в нём нулевые байты; сохраните лог как CSV или "
                "выберите кодировку",
            ),
            line=line,
        )
    return text, encoding


def _encoding_of(data: bytes) -> str:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return "windows-1251"
    return "utf-8"


def cells_of(text: str, delimiter: str, name: str) -> Iterator[tuple[int, list[str]]]:
    """Yield (number of its last line from 1, cells) of each row.

    Blank lines and a first line `sep=;` for Excel are left out. Cells are stripped. Raises
    `ForeignLogError` for a cell without an end.
    """
    hint = _HINT.match(text)
    lines = io.StringIO(text, newline="")
    if delimiter == SPACE:
        rows = csv.reader((" ".join(line.split()) for line in lines), delimiter=SPACE)
    else:
        rows = csv.reader(lines, delimiter=delimiter, skipinitialspace=delimiter != "\t")
    while True:
        try:
            cells = next(rows)
        except StopIteration:
            return
        except csv.Error as error:
            raise ForeignLogError(name, _UNREADABLE, line=rows.line_num) from error
        if rows.line_num % _EACH == 0:
            check_cancelled()
        if any(len(cell) > _LONGEST_CELL or cell.count("\n") > _MOST_BREAKS for cell in cells):
            raise ForeignLogError(name, _UNREADABLE, line=rows.line_num)
        stripped = [cell.strip() for cell in cells]
        if any(stripped) and not (hint and rows.line_num == 1):
            yield rows.line_num, stripped


def sample_of(text: str, delimiter: str, name: str) -> list[tuple[int, list[str]]]:
    """Return the first rows."""
    return [row for row, _ in zip(cells_of(text, delimiter, name), range(_SAMPLE), strict=False)]


def check_delimiter(delimiter: str, name: str) -> None:
    """Raise `ForeignLogError` unless it is one character that can stand between cells."""
    if len(delimiter) != 1 or delimiter in '"\r\n':
        raise ForeignLogError(
            name,
            Text(
                "the delimiter is one character, and no quotation mark",
                "разделитель — один символ, и не кавычка",
            ),
        )


def delimiter_of(text: str, name: str) -> str:
    """Return the delimiter: the one of `sep=;`, else the first that makes equal rows.

    The last lines of a sample count.
    """
    if hint := _HINT.match(text):
        return hint[1]
    head = text[: 1 << 16]
    if len(head) < len(text):
        head = head[: head.rfind("\n") + 1] or head
    best, score = ",", (0, 0)
    for delimiter in DELIMITERS:
        try:
            widths = [len(cells) for _, cells in sample_of(head, delimiter, name)]
        except ForeignLogError:
            continue  # another one may do
        tail = widths[len(widths) // 3 :]
        width = max(set(tail), key=tail.count, default=1)
        equal = tail.count(width) * 10 // max(1, len(tail))
        if width > 1 and equal > score[0]:
            best, score = delimiter, (equal, width)
    return best


class Numbers:
    """Reads the numbers of a file with one decimal sign; a cell seen before is not read again."""

    def __init__(self, decimal: str) -> None:
        self.decimal: str = decimal
        """The decimal sign."""
        self._known: dict[str, float | None] = {}

    def __call__(self, cell: str) -> float | None:
        """Return the number; NaN: the cell is empty; None: it holds something else."""
        try:
            return self._known[cell]
        except KeyError:
            if len(self._known) >= _MOST_KEPT:
                self._known.clear()
            value = self._known[cell] = self._read(cell)
            return value

    def _read(self, cell: str) -> float | None:
        plain = cell.strip().replace("\u2212", "-")
        if plain.casefold() in _MISSING:
            return nan
        if self.decimal != ".":
            if "." in plain:
                return None
            plain = plain.replace(self.decimal, ".")
        if not _NUMBER.fullmatch(plain):
            return None
        value = float(plain)
        return None if value in (inf, -inf) else value


def decimal_of(rows: list[tuple[int, list[str]]], delimiter: str) -> str:
    """Return the decimal sign: a comma where cells have one, and none has a point."""
    if delimiter == ",":
        return "."
    point, comma = Numbers("."), Numbers(",")
    cells = [cell for _, row in rows for cell in row]
    points = sum("." in cell and point(cell) is not None for cell in cells)
    commas = sum("," in cell and comma(cell) is not None for cell in cells)
    return "," if commas > points else "."


_UNREADABLE: Final = Text(
    "a cell has no end here: a quotation mark is open, or the delimiter is another one",
    "здесь ячейка не кончается: не закрыта кавычка или разделитель другой",
)
