"""The one place that writes to stdout and stderr: all that could steer a terminal is escaped.

A file's name, a passport or a catalog may hold ESC, OSC 52 (the clipboard), a carriage return, or
marks that turn the text around. `escaping` puts an `EscapingStream` in front of both streams, so
that tracebacks, click and foreign code pass through it as well. Nothing depends on whether the
stream is a terminal: what a pipe carries ends on one (`| less`, a log).

Raw sequences are this program's: `redraw`, and those of `rich`, whose cells are `cell_text`.
"""

from __future__ import annotations

import io
import os
import re
import shutil
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, TextIO, cast

from mikas.cleaning import clean_line, terminal_text
from mikas.cli.render.wrapping import fitted

CLEAR_LINE: Final = "\r\x1b[K"
BELL: Final = "\a"

# Colours, cursor, lines, the alternate screen: what rich and segno write. No OSC, no queries.
_DRAWING: Final = re.compile(r"(\x1b\[[\d;]*[ABHKm]|\x1b\[\?(?:25|1049)[hl]|\r)")


class OutputError(OSError):
    """The output can't be written: a full disk behind a redirection."""


class EscapingStream:
    """A text stream in front of `raw`, with `hide`, then `make_safe` on all that is written.

    By default nothing is hidden, and every control character but line feed and tab is escaped.
    Raises `OutputError`, and `BrokenPipeError` if the reader of a pipe has closed it.
    """

    def __init__(
        self,
        raw: TextIO,
        make_safe: Callable[[str], str] = terminal_text,
        hide: Callable[[str], str] = str,
    ) -> None:
        self.raw: TextIO = raw
        self.hide: Callable[[str], str] = hide
        self._make_safe = make_safe

    def write(self, text: str) -> int:
        """Write `text`, escaped; return the length of `text`."""
        if not isinstance(text, str):  # so click finds out that this is no binary stream
            raise TypeError("text is needed, not bytes")
        _pass_on(self.raw.write, self._make_safe(self.hide(text)))
        return len(text)

    def flush(self) -> None:
        """Pass on what was written so far."""
        _pass_on(self.raw.flush)

    def writelines(self, lines: Iterable[str]) -> None:
        """Write each of `lines`."""
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401  (as the stream's)
        return getattr(self.raw, name)


def _pass_on(operation: Callable[..., object], *text: str) -> None:
    try:
        operation(*text)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OutputError(error.errno, error.strerror) from error


def drawing_stream(stream: TextIO) -> TextIO:
    """Return the stream for a library that draws: of control sequences only those pass."""
    if isinstance(stream, EscapingStream):
        return cast("TextIO", EscapingStream(stream.raw, _drawing, stream.hide))
    return cast("TextIO", EscapingStream(stream, _drawing))


def error_drawing() -> TextIO:
    """Return stderr for a library that draws."""
    return drawing_stream(sys.stderr)


def out_drawing() -> TextIO:
    """Return stdout for a library that draws."""
    return drawing_stream(sys.stdout)


def _drawing(text: str) -> str:
    if "\x1b" not in text and "\r" not in text:
        return terminal_text(text)
    parts = _DRAWING.split(text)  # at odd places the sequences
    parts[::2] = map(terminal_text, parts[::2])
    return "".join(parts)


@contextmanager
def escaping(hide: Callable[[str], str] = str) -> Iterator[None]:
    """Escape all that is written to `sys.stdout` and `sys.stderr` while in the `with`.

    `hide`: what leaves secrets out of stderr, where foreign code says what it will.
    """
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = _escaped(sys.stdout), _escaped(sys.stderr, hide)
    ours = sys.stdout, sys.stderr
    try:
        yield
    finally:  # a stream that another has replaced meanwhile stays
        if sys.stdout is ours[0]:
            sys.stdout = before[0]
        if sys.stderr is ours[1]:
            sys.stderr = before[1]


def _escaped(stream: TextIO, hide: Callable[[str], str] = str) -> TextIO:
    if isinstance(stream, EscapingStream):
        return stream
    return cast("TextIO", EscapingStream(stream, hide=hide))


def write_out(text: str) -> None:
    """Write `text` to stdout, flushed for the reader of a pipe."""
    _write(sys.stdout, text)


def write_machine(text: str, encoding: str | None = None) -> None:
    """Write what a shell reads to stdout: with line feeds alone, in `encoding` or the stream's."""
    if (reconfigure := getattr(sys.stdout, "reconfigure", None)) is not None:
        reconfigure(newline="\n", errors="replace", encoding=encoding)
    write_out(text)


def write_error(text: str) -> None:
    """Write `text` to stderr."""
    _write(sys.stderr, text)


def _write(stream: TextIO, text: str) -> None:
    # Without `escaping`, or while rich has put its own stream in front, nothing else escapes.
    stream.write(text if isinstance(stream, EscapingStream) else terminal_text(text))
    stream.flush()


def write_note(text: str) -> None:
    """Write a sentence or more to stderr, for a person: on a terminal in lines of whole words."""
    if sys.stderr.isatty():
        if isinstance(sys.stderr, EscapingStream):
            text = sys.stderr.hide(text)  # before a line break divides a secret
        text = "\n".join(fitted(terminal_text(text), shutil.get_terminal_size().columns))
    write_error(f"{text}\n")


def write_above(text: str) -> None:
    """Write a line to stderr, in the place of a status line, which is drawn again below it."""
    if sys.stderr.isatty():
        redraw("")
    write_note(text)


def redraw(text: str, end: str = "") -> None:
    """Replace the last line of stderr by `text`."""
    stream = error_drawing()
    stream.write(f"{CLEAR_LINE}{cell_text(text)}{end}")
    stream.flush()


def ring() -> None:
    """Ring the bell of the terminal behind stderr; nothing is written into a file or a pipe."""
    stream = sys.stderr
    if stream.isatty():
        raw = stream.raw if isinstance(stream, EscapingStream) else stream
        _pass_on(raw.write, BELL)
        _pass_on(raw.flush)


def cell_text(text: str) -> str:
    """Return `text` as the words of one cell or line."""
    return clean_line(terminal_text(text))


def is_utf8_out() -> bool:
    """Return whether stdout is UTF-8."""
    return (sys.stdout.encoding or "").lower().replace("-", "") == "utf8"


def flush_out() -> None:
    """Pass on what was written to stdout so far."""
    sys.stdout.flush()


def make_writable() -> None:
    """Replace absent streams; replace characters that a stream can't encode.

    They are absent if they were closed, and on Windows without a console.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            nowhere = Path(os.devnull).open(mode, encoding="utf-8")  # noqa: SIM115  (open for good)
            setattr(sys, name, nowhere)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def discard_output() -> None:
    """Discard the rest of the output: the reader of the pipe is gone, or the disk is full."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (BrokenPipeError, OutputError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
