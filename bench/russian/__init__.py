"""The Russian page of the benchmarks, made of the English one: docs/ru/development/benchmarks.md.

A text is translated sentence by sentence, a table cell by cell, by texts.toml; a number in them
stands there as `{}`. What has no translation stays English, and tests/test_bench_russian.py fails.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from textwrap import fill

DOCS = Path(__file__).parents[2] / "docs"
ENGLISH = DOCS / "development" / "benchmarks.md"
RUSSIAN = DOCS / "ru" / "development" / "benchmarks.md"
TEXTS = Path(__file__).with_name("texts.toml")

_NUMBER = re.compile(r"(?<![\w§.,`-])\d+(?:[.,]\d+)*(?!\w|[.,]\d)(?=[^`]*(?:`[^`]*`[^`]*)*$)")
"""A number outside of `code`, and not part of a name (FT232, §5, p95)."""
_SENTENCE = re.compile(r"(?<=[.!?]) (?=[A-Z`])")
_WIDTH = 120


class Translation:
    """The translation of a document; `missing`: what stayed English."""

    def __init__(self, texts: dict[str, str]) -> None:
        self._texts = texts
        self.missing: set[str] = set()

    def document(self, english: str) -> str:
        """Return the document in Russian."""
        return "\n\n".join(map(self._part, english.strip().split("\n\n"))) + "\n"

    def _part(self, part: str) -> str:
        if part.startswith("#"):
            marks, title = part.split(" ", 1)
            return f"{marks} {self.text(title)}"
        if part.startswith("|"):
            return "\n".join(self._row(line) for line in part.splitlines())
        if part.startswith("- "):
            return "\n".join(self._note(note) for note in re.split(r"\n(?=- )", part))
        words = " ".join(part.split())
        return _machine(words) if re.match(r"\*\d", words) else _filled(self.text(words))

    def _row(self, line: str) -> str:
        if line.startswith("|--"):
            return line
        cells = (self.text(cell.strip()) for cell in line.strip()[1:-1].split("|"))
        return "| " + " | ".join(cells) + " |"

    def _note(self, note: str) -> str:
        name, how = " ".join(note.removeprefix("- ").split()).split(": ", 1)
        return _filled(f"- {self.text(name)}: {self.text(how)}", "  ")

    def text(self, words: str) -> str:
        """Return a cell or a paragraph in Russian."""
        return " ".join(self._sentence(each) for each in _SENTENCE.split(words))

    def _sentence(self, words: str) -> str:
        numbers = _NUMBER.findall(words)
        key = _NUMBER.sub("{}", words)
        if not re.search("[A-Za-z]", re.sub("`[^`]*`", "", key)):
            russian = key
        elif key in self._texts:
            russian = self._texts[key]
        else:
            self.missing.add(key)
            return words
        return russian.format(*map(_number, numbers))


def translated() -> tuple[str, set[str]]:
    """Return the Russian page, and what could not be translated."""
    translation = Translation(tomllib.loads(TEXTS.read_text("utf-8")))
    return translation.document(ENGLISH.read_text("utf-8")), translation.missing


def write() -> None:
    """Write the Russian page; print what stayed English."""
    text, missing = translated()
    RUSSIAN.write_text(text, encoding="utf-8", newline="\n")
    for key in sorted(missing):
        print(f"not in {TEXTS.name}: {key}")


def _number(number: str) -> str:
    """1,234.5 as 1234,5; with a space from five digits on. A version stays as it is."""
    if re.fullmatch(r"\d{1,3}(,\d{3})+(\.\d+)?|\d+\.\d+|\d+", number) is None:
        return number
    whole, _, fraction = number.replace(",", "").partition(".")
    grouped = f"{int(whole):,}".replace(",", "\N{NO-BREAK SPACE}") if len(whole) > 4 else whole
    return f"{grouped},{fraction}" if fraction else grouped


def _machine(words: str) -> str:
    """What stands under a table: names and versions stay as they are."""
    words = re.sub(r"(\d+) cores", r"ядер: \1", words)
    return re.sub(r"load average before it (\d+)\.(\d)", r"средняя загрузка до этого \1,\2", words)


def _filled(words: str, indent: str = "") -> str:
    return fill(words, _WIDTH, subsequent_indent=indent, break_on_hyphens=False)
