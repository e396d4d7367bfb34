"""Markers while recording: Enter sets one; what was typed before it is its name.

A thread waits for the lines. It reads the descriptor itself: a thread that hangs in `sys.stdin`
would keep the process from ending.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable
from typing import Self

from mikas.cli.words import say
from mikas.recording.recorder import Recorder


class Marking:
    """Listens while in the `with`; only where stdin is a terminal that is ours to read from."""

    def __init__(self, recorder: Recorder, tell: Callable[[str], None]) -> None:
        self._recorder = recorder
        self._tell = tell
        self._count = 0
        self._over = False

    def __enter__(self) -> Self:
        if _is_ours():
            threading.Thread(target=self._listen, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over = True

    def mark(self, label: str) -> None:
        """One marker, now."""
        if self._recorder.failure is None and self._recorder.marker(label=label) is not None:
            self._count += 1
            name = f" “{label}”" if label else ""
            named = f" «{label}»" if label else ""
            self._tell(say(f"Marker {self._count}{name}.", f"Метка {self._count}{named}."))

    def _listen(self) -> None:
        descriptor, encoding = sys.stdin.fileno(), sys.stdin.encoding or "utf-8"
        while True:
            try:
                line = os.read(descriptor, 4096)
            except OSError:  # put into the background, or the terminal is gone
                return
            if not line or self._over:
                return
            self.mark(line.decode(encoding, "replace").strip())


def _is_ours() -> bool:
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
