"""The layout of help pages: whole words at any width of the terminal.

click breaks a word at its hyphens, so that an option is torn in two (`--inter-` at the end of a
line), and gives descriptions half of a narrow line.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

import click

from mikas.cli.render.wrapping import filled

_WIDEST_NAME = 30
_GAP = 2
_CONTINUED = " \\"  # as a shell continues a line
_SHELL_WORD = re.compile(r"(?:'[^']*'|\"[^\"]*\"|\S)+")


class HelpFormatter(click.HelpFormatter):
    """A formatter that breaks lines at blanks only."""

    def write_usage(self, prog: str, args: str = "", prefix: str | None = None) -> None:
        begin = f"{prefix or ''}{prog} "
        indent = " " * (len(begin) if self.width >= len(begin) + 20 else 4)
        self.write(_filled(begin + args, self.width, indent))

    def write_text(self, text: str) -> None:
        indent = " " * self.current_indent
        paragraphs = (_filled(indent + each, self.width, indent) for each in text.split("\n\n"))
        self.write("\n".join(paragraphs))

    def write_dl(
        self,
        rows: Iterable[tuple[str, str]],
        col_max: int = _WIDEST_NAME,
        col_spacing: int = _GAP,
    ) -> None:
        rows = list(rows)
        most = min(col_max, self.width * 2 // 5)
        column = self.current_indent + col_spacing
        column += max((len(name) for name, _ in rows if len(name) <= most), default=most)
        for name, text in rows:
            begin = " " * self.current_indent + name
            if len(begin) + col_spacing > column:
                self.write(f"{begin}\n")
                begin = ""
            self.write(_filled(begin.ljust(column) + text, self.width, " " * column))

    def write_example(self, line: str) -> None:
        """Write a command line, continued as in a shell where it is too long."""
        first, rest = " " * self.current_indent, " " * (self.current_indent + 4)
        written = ""
        for word in _SHELL_WORD.findall(line):
            if not written:
                written = first + word
            elif len(f"{written} {word}{_CONTINUED}") <= self.width:
                written += f" {word}"
            else:
                self.write(f"{written}{_CONTINUED}\n")
                written = rest + word
        self.write(f"{written}\n")


def _filled(text: str, width: int, indent: str) -> str:
    return "".join(f"{line}\n" for line in filled(text, width, indent)) or "\n"


class HelpContext(click.Context):
    """A context whose help has this layout."""

    formatter_class = HelpFormatter

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        kwargs.setdefault("help_option_names", ["-h", "--help"])
        super().__init__(*args, **kwargs)
