"""A file with the recordings of several cars as a file for each car."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import BinaryIO, Final

from mikas.cancellation import check_cancelled
from mikas.errors import MikasError
from mikas.files import beside
from mikas.recording.annotations.cars import PortSpan, RecordedCar, cars_of
from mikas.recording.capture.opening import capture_error, opened_capture
from mikas.recording.capture.scan import read_whole
from mikas.recording.capture.sections import Sections

_BLOCK: Final = 1 << 20


def cars_in(path: str | os.PathLike[str]) -> list[RecordedCar]:
    """Return the cars of a file. Raises `CaptureError` if it is no capture."""
    with opened_capture(path) as file:
        return cars_in_sections(Sections(file))


def cars_in_sections(sections: Sections) -> list[RecordedCar]:
    """Return the cars of an open capture."""
    notes, count = sections.index.notes, len(sections.index.sections)
    if count < 2:
        return cars_of(notes, {0: PortSpan("")})
    runs: dict[int, PortSpan] = {}
    for number in range(count):
        _, first = sections.head(number)
        if first is not None:
            runs[number] = PortSpan(first.source.url, partial(sections.span, number))
    return cars_of(notes, runs)


def split(path: Path, target: Path) -> Iterator[tuple[RecordedCar, Path]]:
    """Write `target`-1, `target`-2 … with the recordings of each car; yield car and file.

    Existing files are left alone: the next free number counts. Raises `CaptureError`.
    """
    stem = target.stem.removesuffix(".pcapng")  # of one that is packed
    with opened_capture(path) as file:
        sections, number = Sections(file), 0
        for car in cars_in_sections(sections):
            try:
                while True:
                    number += 1
                    part = beside(target.with_name(stem), f"-{number}.pcapng")
                    with suppress(FileExistsError), _whole(part) as out:
                        for section in car.recordings:
                            begin, end = sections.edges[section : section + 2]
                            _copy(file, begin, end, out)
                        break
            except MikasError:
                raise
            except OSError as error:
                raise capture_error(part, error) from error
            yield car, part


@contextmanager
def _whole(path: Path) -> Iterator[BinaryIO]:
    """Open a new file, which an exception removes: half a recording looks like a whole one."""
    with path.open("xb") as out:
        try:
            yield out
            out.flush()
        except BaseException:
            with suppress(OSError):  # the last bytes that wait are refused, too
                out.close()
            path.unlink(missing_ok=True)
            raise


def _copy(file: BinaryIO, begin: int, end: int, out: BinaryIO) -> None:
    file.seek(begin)
    for at in range(begin, end, _BLOCK):
        check_cancelled()
        out.write(read_whole(file, min(_BLOCK, end - at)))
