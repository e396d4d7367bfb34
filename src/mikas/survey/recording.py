"""The raw bytes of a survey: a capture of each run, without a date, joined into one at the end."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from mikas.link.base import Direction
from mikas.link.urls import parse
from mikas.recording import CaptureWriter

_NAME: Final = "capture-{number}.pcapng"
_NUMBERED: Final = re.compile(r"capture-([0-9]{1,9})\.pcapng")
NO_UNITS: Final = frozenset(("sim", "replay", "pty"))
"""What `port_kind` calls the port of no real unit."""
_PTY: Final = re.compile(r"/dev/(pts/|ttys)[0-9]+")  # of Linux; of macOS


class SurveyCapture:
    """Records one run into `folder`; implements `mikas.link.base.Sink`.

    Times count from the begin of the survey: a file without a date and without the port's address
    says nothing of its owner. `paused`: nothing is recorded now.
    """

    def __init__(self, folder: Path, *, url: str, baud: int, began: float, before: float) -> None:
        number = max(_runs(folder), default=0) + 1
        self.paused: bool = False
        self._began = began - before
        self._writer = CaptureWriter(
            folder / _NAME.format(number=number), url=port_kind(url), baud=baud
        )

    def record(self, direction: Direction, data: bytes, time: float) -> None:
        """Record one chunk, unless paused."""
        if not self.paused:
            self._writer.record(direction, data, time - self._began)

    @contextmanager
    def pausing(self) -> Iterator[None]:
        """Record nothing while the block runs."""
        self.paused = True
        try:
            yield
        finally:
            self.paused = False

    def close(self) -> None:
        """Close the file; a run without a byte leaves none."""
        self._writer.discard_if_empty()


def joined_captures(folder: Path) -> bytes:
    """Return the captures of all runs in a row: a pcapng file of several sections."""
    return b"".join(file.read_bytes() for _, file in sorted(_runs(folder).items()))


def port_kind(url: str) -> str:
    """Return what the port is, without its address; `pty`: `mikas sim`, not an adapter."""
    port = parse(url)
    if port.scheme == "serial" and _PTY.fullmatch(os.path.realpath(port.address)):
        return "pty"
    return port.scheme


def _runs(folder: Path) -> dict[int, Path]:
    """Return the captures in `folder` by their numbers, however many runs there were."""
    found = ((_NUMBERED.fullmatch(file.name), file) for file in folder.iterdir())
    return {int(match[1]): file for match, file in found if match}
