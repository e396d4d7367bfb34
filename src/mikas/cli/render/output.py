"""Data to stdout, everything else to stderr; tables with rich on a terminal, plain otherwise; a
status line and a progress bar on a terminal only.

`--json`: one object, or one a line for endless commands, each with `"schema": 1`. `terminal`
writes, and escapes what could steer a terminal; JSON has the escapes of JSON for it.
"""

from __future__ import annotations

import json
import logging
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Protocol, TextIO, TypeVar

from mikas.cleaning import terminal_json
from mikas.cli.language import tr
from mikas.cli.render import terminal
from mikas.cli.render.wrapping import filled

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

SCHEMA = 1
_PIECE = 1 << 16
T = TypeVar("T")


@dataclass(slots=True)
class Output:
    """Prints results: JSON or text on stdout, notes on stderr."""

    json: bool = False
    verbose: bool = False

    def data(self, value: Mapping[str, Any]) -> None:
        """Print one JSON object on a line of stdout, flushed for the reader of a pipe."""
        self.line(_json({"schema": SCHEMA, **value}))

    def long_data(self, value: Mapping[str, Any], name: str, items: Iterable[object]) -> None:
        """Print one JSON object on a line as `data` does, with `items` in the list `name` at its
        end: each is written as it comes.
        """
        terminal.write_out(_json({"schema": SCHEMA, **value})[:-1] + f", {_json(name)}: [")
        waiting, length = [], 0
        for number, item in enumerate(items):
            waiting.append(f"{', ' if number else ''}{_json(item)}")
            length += len(waiting[-1])
            if length > _PIECE:  # a write for each would cost more than the items
                terminal.write_out("".join(waiting))
                waiting, length = [], 0
        self.line(f"{''.join(waiting)}]}}")

    def line(self, text: str = "") -> None:
        """Print one line on stdout."""
        terminal.write_out(f"{text}\n")

    def paragraph(self, text: str, first: str = "", rest: str | None = None) -> None:
        """Print a paragraph on stdout: on a terminal wrapped at words, elsewhere on one line.

        `first` stands before its first line, `rest` before each other: as many blanks.
        """
        from shutil import get_terminal_size

        if not sys.stdout.isatty():
            self.line(first + text)
            return
        indent = " " * len(first) if rest is None else rest
        text = first + terminal.cell_text(text)
        self.line("\n".join(filled(text, get_terminal_size().columns, indent)))

    def result(self, value: Mapping[str, Any], text: str) -> None:
        """Print `value` as JSON, or `text` for people."""
        if self.json:
            self.data(value)
        else:
            self.line(text)

    def print_note(self, text: str) -> None:
        """Print a sentence or more on stderr, for people."""
        terminal.write_note(text)

    def detail(self, *words: str) -> None:
        """Print a note that only `-v` shows."""
        if self.verbose:
            self.print_note(" ".join(word for word in words if word))

    def listing(
        self, items: Iterable[T], columns: Mapping[str, Callable[[T], str]], right: str = ""
    ) -> None:
        """Print a table with a row for each of `items`; `columns`: the cell by its heading."""
        rows = [[cell(item) for cell in columns.values()] for item in items]
        self.table(list(columns), rows, right)

    def table(self, headers: Sequence[str], rows: Sequence[Sequence[str]], right: str = "") -> None:
        """Print a table on stdout. `right`: indices of the right-aligned columns, as digits."""
        if sys.stdout.isatty():
            console(terminal.out_drawing()).print(make_table(headers, rows, right))
        else:
            for row in [headers, *rows] if headers else rows:
                self.line("\t".join(map(terminal.cell_text, row)))


class StatusLine:
    """A line at the end of stderr, redrawn in place; on a terminal only. Any thread may call.

    `live`: whether stderr is a terminal.
    """

    def __init__(self, output: Output, text: Callable[[], str]) -> None:
        self._output = output
        self._text = text
        self.live: bool = sys.stderr.isatty()
        self._drawn: float | None = None
        self._before = ""
        self._writing = threading.RLock()

    def begin_with(self, before: str) -> None:
        """Draw the line at once with `before` in front of its text, from now on."""
        with self._writing:
            self._before = before
            self._write_text()

    def draw(self, time: float) -> None:
        """Draw the line, once a second of the link's clock, which may jump back."""
        if self.live and (self._drawn is None or not 0 <= time - self._drawn < 1):
            self._drawn = time
            self._write_text()

    def print_notice(self, sentence: str) -> None:
        """Print a notice above the line."""
        with self._writing:
            self.clear()
            self._output.print_note(sentence)
            if self.live:
                self._write_text()

    def clear(self) -> None:
        """Leave an empty line."""
        self._write("")

    def _write_text(self) -> None:
        self._write(self._before + self._text())

    def _write(self, text: str) -> None:
        from shutil import get_terminal_size

        if self.live:
            with self._writing:
                terminal.redraw(terminal.cell_text(text)[: get_terminal_size().columns - 1])


class Advance(Protocol):
    """Advances the bar by `count`; `what` replaces the text before it."""

    def __call__(self, count: int, what: str | None = None, /) -> None: ...


@contextmanager
def progress(what: str, total: int, already: int = 0, *, speed: bool = True) -> Iterator[Advance]:
    """Show a bar for `total` items, bytes if `speed` is to be shown."""
    if not sys.stderr.isatty():
        yield lambda _, __=None: None
        return
    from rich import progress as bars
    from rich.text import Text as RichText

    class Speed(bars.ProgressColumn):
        """Bytes per second; rich's own column is English only."""

        def render(self, task: bars.Task) -> RichText:
            speed = f"{task.finished_speed or task.speed or 0:.0f}"
            return RichText(tr(f"{speed} bytes/s", f"{speed} байт/с"))

    with bars.Progress(
        bars.TextColumn("{task.description}", markup=False),
        bars.BarColumn(),
        bars.TextColumn("{task.completed:.0f}/{task.total:.0f}"),
        *([Speed()] if speed else []),
        bars.TimeRemainingColumn(),
        console=console(terminal.error_drawing()),
    ) as bar:
        task = bar.add_task(terminal.cell_text(what), total=total, completed=already)

        def advance(count: int, text: str | None = None, /) -> None:
            bar.update(
                task, advance=count, description=terminal.cell_text(what if text is None else text)
            )

        yield advance


def make_table(headers: Sequence[str], rows: Sequence[Sequence[str]], right: str = "") -> Table:
    """Return a rich table; cells are text, never markup."""
    from rich import box
    from rich.table import Table
    from rich.text import Text as RichText

    table = Table(
        box=box.SIMPLE_HEAD, show_edge=False, padding=(0, 1, 0, 0), show_header=bool(headers)
    )
    for index, header in enumerate(headers):  # a long word is folded: never cut
        side: Literal["left", "right"] = "right" if str(index) in right else "left"
        words = RichText(terminal.cell_text(header))
        table.add_column(words, justify=side, overflow="fold")
    for row in rows:
        table.add_row(*(RichText(terminal.cell_text(cell)) for cell in row))
    return table


def console(drawing: TextIO) -> Console:
    """Return rich's console on a stream for drawing; it respects NO_COLOR and the width."""
    from rich.console import Console

    return Console(file=drawing, highlight=False)


def _json(value: object) -> str:
    # Where the stream is not UTF-8, escapes as \\u00b0 are safe.
    escaped = not terminal.is_utf8_out()
    return terminal_json(json.dumps(value, ensure_ascii=escaped, allow_nan=False, default=_plain))


def _plain(value: object) -> object:
    """Return the JSON form of bytes: upper-case hex without spaces."""
    if isinstance(value, bytes | bytearray):
        return value.hex().upper()
    raise TypeError(f"{type(value).__name__} has no JSON form")


class StderrHandler(logging.Handler):
    """Writes to the current `sys.stderr`, which rich and tests replace."""

    def __init__(self) -> None:
        super().__init__()
        self.setFormatter(
            logging.Formatter("%(asctime)s.%(msecs)03d %(name)s: %(message)s", "%H:%M:%S")
        )

    def emit(self, record: logging.LogRecord) -> None:
        """Write one record; a broken stderr ends no command."""
        try:
            terminal.write_above(self.format(record))
        except (OSError, ValueError):
            self.handleError(record)


@contextmanager
def log_to_stderr() -> Iterator[None]:
    """Show the log of `mikas` while in the `with`."""
    logger, handler = logging.getLogger("mikas"), StderrHandler()
    level = logger.level
    logger.setLevel(logging.DEBUG)
    logger.addHandler(handler)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
