"""A screen without a monitor (Xvfb), for pictures of programs that are no web page.

Pauses are in seconds: such a program gives no sign that it has drawn its window.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def screen(display: str, width: int, height: int) -> Iterator[None]:
    """Have this screen, in pixels; `display`: its name, as in `:77`."""
    ready, reports = os.pipe()
    command = ["Xvfb", display, "-screen", "0", f"{width}x{height}x24", "-displayfd", str(reports)]
    with (
        os.fdopen(ready, "rb") as ready_line,
        subprocess.Popen(command, stderr=subprocess.DEVNULL, pass_fds=[reports]) as xvfb,
    ):
        os.close(reports)
        try:
            if not ready_line.readline():
                raise SystemExit(f"Xvfb did not start: is {display} in use?")
            yield
        finally:
            xvfb.terminate()


class Window:
    """A program on such a screen. It has `home` as its home and as its working folder."""

    def __init__(self, command: Sequence[str], display: str, home: Path, **more: str) -> None:
        self._environment = os.environ | {"DISPLAY": display, "HOME": str(home), **more}
        self._environment.pop("XDG_CONFIG_HOME", None)
        self._command, self._home = command, home

    @contextmanager
    def opened(self, seconds: float) -> Iterator[None]:
        """Run the program; it has drawn its window after so many seconds."""
        with (
            (self._home / "log").open("w") as log,
            subprocess.Popen(
                self._command, cwd=self._home, env=self._environment, stdout=log, stderr=log
            ) as program,
        ):
            try:
                time.sleep(seconds)  # nothing that can be waited for: see above
                yield
            finally:
                program.terminate()

    def act(self, *words: str) -> str:
        """Let xdotool do this; return what it prints."""
        done = subprocess.run(
            ["xdotool", *words], env=self._environment, capture_output=True, text=True, check=True
        )
        return done.stdout

    def picture(self, out: Path) -> None:
        """Write the screen as a PNG of few colours."""
        shot = ["import", "-window", "root", "+dither", "-colors", "96", f"png8:{out}"]
        subprocess.run(shot, env=self._environment, check=True)
        print(out, file=sys.stderr)
