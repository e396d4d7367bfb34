"""The raw bytes of a survey: a capture of each run, without a date, joined into one at the end."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from mikas.link.base import Direction
from mikas.link.urls import parse
from mikas.recording import CaptureWriter

_NAME: Final = "capture-{number}.pcapng"
_MOST_RUNS: Final = 1000


class SurveyCapture:
    """Records one run into `folder`; implements `mikas.link.base.Sink`.

    Times count from the begin of the survey: a file without a date and without the port's address
    says nothing of its owner. `paused`: nothing is recorded now.
    """

    def __init__(self, folder: Path, *, url: str, baud: int, began: float, before: float) -> None:
        number = next(n for n in range(1, _MOST_RUNS) if not _file(folder, n).exists())
        self.paused: bool = False
        self._began = began - before
        self._writer = CaptureWriter(_file(folder, number), url=_kind(url), baud=baud)

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
    runs = (_file(folder, number) for number in range(1, _MOST_RUNS))
    return b"".join(file.read_bytes() for file in runs if file.exists())


def _kind(url: str) -> str:
    """Return what the port is, without its address; `pty`: `mikas sim`, not an adapter."""
    port = parse(url)
    return "pty" if port.address.startswith("/dev/pts/") else port.scheme


def _file(folder: Path, number: int) -> Path:
    return folder / _NAME.format(number=number)
