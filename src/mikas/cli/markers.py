"""Markers while recording: Enter sets one; the text typed before it is its name.

A thread waits for lines until the end or Ctrl-C: later input is the shell's, also while the
recording is being closed. It reads the descriptor, because a thread blocked in `sys.stdin` would
keep the process from ending.
"""

from __future__ import annotations

import os
import select
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Self

from mikas.cleaning import clean_line
from mikas.cli.language import tr
from mikas.recording.annotations.fields import LONGEST_LINE
from mikas.recording.recorder import Recorder

_END = b"\0"  # no signal has this number


class Marking:
    """Listens while in the `with`, if stdin is a terminal of this process group."""

    def __init__(self, recorder: Recorder, note: Callable[[str], None]) -> None:
        self._recorder = recorder
        self._note = note
        self._count = 0
        self._ended = False
        self._thread: threading.Thread | None = None
        self._waking: tuple[int, int] | None = None  # a pipe: signals, and the end
        self._woken_before = -1

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
        for end in self._waking:
            os.close(end)

    def listen(self, descriptor: int, encoding: str = "utf-8") -> None:
        """Start to read lines from `descriptor`; in the main thread, once."""
        if os.name == "posix":
            self._waking = os.pipe()
            for end in self._waking:
                os.set_blocking(end, False)
            self._woken_before = signal.set_wakeup_fd(self._waking[1], warn_on_full_buffer=False)
        self._thread = threading.Thread(
            target=self._listen, args=(descriptor, encoding), daemon=True
        )
        self._thread.start()

    def mark(self, label: str) -> None:
        """Set one marker now."""
        if self._recorder.failure is None and self._recorder.marker(label=label) is not None:
            self._count += 1
            name = f" “{label}”" if label else ""
            named = f" «{label}»" if label else ""
            self._note(tr(f"Marker {self._count}{name}.", f"Метка {self._count}{named}."))

    def _listen(self, descriptor: int, encoding: str) -> None:
        while self._wait_for_line(descriptor):
            try:
                line = os.read(descriptor, 4096)
            except OSError:  # put into the background, or the terminal is gone
                return
            if not line or (self._ended and self._waking is None):
                return
            self.mark(clean_line(line.decode(encoding, "replace").strip(), LONGEST_LINE))

    def _wait_for_line(self, descriptor: int) -> bool:
        """Wait for a line; False at the end or after Ctrl-C."""
        if self._waking is None:
            return True
        while True:
            ready, _, _ = select.select([descriptor, self._waking[0]], [], [])
            if self._waking[0] not in ready:
                return True
            woken = os.read(self._waking[0], 4096)
            if signal.SIGINT in woken or _END in woken:
                return False


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
