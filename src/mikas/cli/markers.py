"""Markers while recording: Enter sets one; the text typed before it is its name.

A thread waits for input until the end or Ctrl-C: later input is the shell's, also while the
recording is being closed. It reads the descriptor, because a thread blocked in `sys.stdin` would
keep the process from ending.

Where the typed text can be drawn (`on_typing`), the terminal's own echo is off meanwhile: it would
write into the status line, which is redrawn every second and would erase the text.
"""

from __future__ import annotations

import codecs
import os
import select
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any, Final, Self

from mikas.cleaning import clean_line
from mikas.cli.language import tr
from mikas.recording.annotations.fields import LONGEST_LINE
from mikas.recording.recorder import Recorder

_END = b"\0"  # no signal has this number
_ENTER: Final = "\r\n"
_BACKSPACE, _KILL_WORD, _KILL_LINE, _ESCAPE = "\b\x7f", "\x17", "\x15", "\x1b"


class TypedLine:
    """A line as it is typed at a terminal without a line editor: backspace, Ctrl-W, Ctrl-U.

    Sequences of the arrow and function keys are left out, and so are other control characters.
    """

    def __init__(self, encoding: str = "utf-8") -> None:
        self.text: str = ""
        self._decoder = codecs.getincrementaldecoder(encoding)("replace")
        self._escape = ""

    def feed(self, data: bytes) -> Iterator[str]:
        """Take typed bytes, and yield the lines that they complete."""
        for character in self._decoder.decode(data):
            if self._escape:
                self._skip(character)
            elif character in _ENTER:
                line, self.text = self.text, ""
                yield clean_line(line.strip(), LONGEST_LINE)
            elif character in _BACKSPACE:
                self.text = self.text[:-1]
            elif character == _KILL_WORD:
                self.text = "".join(self.text.rstrip().rpartition(" ")[:2])
            elif character == _KILL_LINE:
                self.text = ""
            elif character == _ESCAPE:
                self._escape = character
            elif character.isprintable() and len(self.text) < LONGEST_LINE:
                self.text += character

    def _skip(self, character: str) -> None:
        """Skip ESC, `[` or `O`, parameters and the final character; Alt with another key."""
        self._escape += character
        is_whole = len(self._escape) > 2 and "@" <= character <= "~"
        if is_whole or self._escape[1] not in "[O" or not character.isprintable():
            self._escape = ""


@dataclass(slots=True, eq=False)
class Marking:
    """Listens while in the `with`, if stdin is a terminal of this process group.

    `on_typing` is called, in another thread, with the text typed so far whenever it changes; None:
    the terminal shows it. (Windows: the terminal always does.)
    """

    recorder: Recorder
    note: Callable[[str], None]
    on_typing: Callable[[str], None] | None = None
    _count: int = 0
    _ended: bool = False
    _thread: threading.Thread | None = None
    _waking: tuple[int, int] | None = None  # a pipe: signals, and the end
    _woken_before: int = -1
    _continued_before: Any = None

    def __enter__(self) -> Self:
        if _owns_terminal():
            self.listen(sys.stdin.fileno(), sys.stdin.encoding or "utf-8")
        return self

    def __exit__(self, *_: object) -> None:
        self._ended = True
        if self._waking is None or self._thread is None:
            return  # on Windows the thread ends with the process
        with suppress(BlockingIOError):  # full of signals, which wake the thread too
            os.write(self._waking[1], _END)
        self._thread.join()
        signal.set_wakeup_fd(self._woken_before)
        signal.signal(signal.SIGCONT, self._continued_before)
        for end in self._waking:
            os.close(end)

    def listen(self, descriptor: int, encoding: str = "utf-8") -> None:
        """Start to read lines from `descriptor`; in the main thread, once."""
        if os.name == "posix":
            self._waking = os.pipe()
            for end in self._waking:
                os.set_blocking(end, False)
            self._woken_before = signal.set_wakeup_fd(self._waking[1], warn_on_full_buffer=False)
            # A signal without a handler wakes no descriptor.
            self._continued_before = signal.signal(signal.SIGCONT, lambda *_: None)
        self._thread = threading.Thread(
            target=self._listen, args=(descriptor, encoding), daemon=True
        )
        self._thread.start()

    def mark(self, label: str) -> None:
        """Set one marker now."""
        if self.recorder.failure is None and self.recorder.marker(label=label) is not None:
            self._count += 1
            name = f" “{label}”" if label else ""
            named = f" «{label}»" if label else ""
            self.note(tr(f"Marker {self._count}{name}.", f"Отметка {self._count}{named}."))

    def _listen(self, descriptor: int, encoding: str) -> None:
        on_typing = self.on_typing
        typed = TypedLine(encoding)
        with _no_echo(descriptor, off=on_typing is not None) as switch_off:
            while self._wait_for_input(descriptor, switch_off):
                try:
                    data = os.read(descriptor, 4096)
                except OSError:  # put into the background, or the terminal is gone
                    return
                if not data or (self._ended and self._waking is None):
                    return
                for label in typed.feed(data):
                    self.mark(label)
                if on_typing is not None:
                    on_typing(typed.text)

    def _wait_for_input(self, descriptor: int, on_continue: Callable[[], None]) -> bool:
        """Wait for input; False at the end or after Ctrl-C. `on_continue`: after Ctrl-Z and fg."""
        if self._waking is None:
            return True
        while True:
            ready, _, _ = select.select([descriptor, self._waking[0]], [], [])
            if self._waking[0] not in ready:
                return True
            woken = os.read(self._waking[0], 4096)
            if signal.SIGINT in woken or _END in woken:
                return False
            if signal.SIGCONT in woken:
                on_continue()


@contextmanager
def _no_echo(descriptor: int, *, off: bool) -> Iterator[Callable[[], None]]:
    """Switch echo and line editing of the terminal off meanwhile; Ctrl-C and Ctrl-Z stay.

    Yields a function that does so again: a shell switches them on when the program is stopped.
    """
    if not off or os.name != "posix":
        yield lambda: None
        return
    import termios

    def switch_off() -> None:
        with suppress(termios.error):  # the terminal is gone
            during = termios.tcgetattr(descriptor)
            during[3] &= ~(termios.ECHO | termios.ICANON)
            termios.tcsetattr(descriptor, termios.TCSANOW, during)

    before = None
    with suppress(termios.error):
        before = termios.tcgetattr(descriptor)
    switch_off()
    try:
        yield switch_off
    finally:
        if before is not None:
            with suppress(termios.error):
                termios.tcsetattr(descriptor, termios.TCSANOW, before)


def _owns_terminal() -> bool:
    if not sys.stdin.isatty():
        return False
    if os.name != "posix":
        return True
    try:
        # In the background, reading from the terminal would stop the whole process.
        if os.tcgetpgrp(sys.stdin.fileno()) != os.getpgrp():
            return False
        signal.signal(signal.SIGTTIN, signal.SIG_IGN)
    except (OSError, ValueError):  # no such terminal; not the main thread
        return False
    return True
