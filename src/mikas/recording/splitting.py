"""A file with the recordings of several cars as a file for each car."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO, Final

from mikas.cancellation import check_cancelled
from mikas.cleaning import clean_line, public_port
from mikas.files import beside
from mikas.recording.annotations.cars import RecordedCar, cars_of
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.notes import FileIndex, index
from mikas.recording.capture.opening import capture_error, opened_capture
from mikas.recording.capture.scan import RawBlock, read_whole, scan

_BLOCK: Final = 1 << 20


def cars_in(path: str | os.PathLike[str]) -> list[RecordedCar]:
    """Return the cars of a file. Raises `CaptureError` if it is no capture."""
    with opened_capture(path) as file:
        return cars_in_sections(file, index(file))


def cars_in_sections(file: BinaryIO, found: FileIndex) -> list[RecordedCar]:
    """Return the cars of an open capture with this index."""
    if len(found.sections) < 2:
        return cars_of(found.notes, {0: ""})
    edges = [*found.sections, found.size]
    ports = {
        number: port
        for number, order in enumerate(found.orders)
        if (port := _port(file, edges[number], edges[number + 1], order)) is not None
    }
    return cars_of(found.notes, ports)


def _port(file: BinaryIO, begin: int, stop: int, order: pcapng.Order) -> str | None:
    """Return the name of a section's port; None without a packet."""
    name = ""
    for item in scan(file, begin, order, stop):
        if not isinstance(item, RawBlock):
            continue
        if item.kind == pcapng.ENHANCED:
            return name
        with suppress(pcapng.Malformed):
            block = pcapng.parse(item.kind, item.body, item.order)
            if isinstance(block, pcapng.Interface) and not name:
                name = public_port(clean_line(block.name))
    return None


def split(path: Path, target: Path) -> Iterator[tuple[RecordedCar, Path]]:
    """Write `target`-1, `target`-2 … with the recordings of each car; yield car and file.

    Existing files are left alone: the next free number counts. Raises `CaptureError`.
    """
    with opened_capture(path) as file:
        found = index(file)
        edges = [*found.sections, found.size]
        number = 0
        for car in cars_in_sections(file, found):
            try:
                while True:
                    number += 1
                    part = beside(target.with_name(target.stem), f"-{number}.pcapng")
                    with suppress(FileExistsError), _whole(part) as out:
                        for section in car.recordings:
                            _copy(file, edges[section], edges[section + 1], out)
                        break
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
