"""MegaLogViewer's binary log, format version 1 (EFI Analytics, “MLG Binary Log Format 1.0”).

Version 1, because version 2 adds only a category and wider offsets. Numbers are big-endian. `Time`
is a signed count of milliseconds with the scale 0.001: a 32-bit float resolves the tenth hour only
to 4 ms. The channels are such floats; a missing value is NaN.

    header   4D 4C 56 4C 47 00, version, UNIX time, where the info is, where the data begins,
             bytes in a record, number of fields
    field    type, name (34), unit (10), display style, scale, transform, digits: 55 bytes
    info     the two lines of `heading`, then 00
    block    00, rolling counter, 16 bits of a 10 µs clock, the fields, the sum of their bytes
    marker   01, the same counter and clock, its words (50, else the brief form), no sum
"""

from __future__ import annotations

import math
import struct
from itertools import count
from pathlib import Path

import numpy as np

from mikas.errors import ExportError
from mikas.i18n import Text
from mikas.recording.export.megalogviewer import LogMark, field_names, heading, marked
from mikas.recording.export.sheet import Column, Sheet
from mikas.recording.table.channels import Channel

_HEADER = struct.Struct(">6sHIHIHH")
_FIELD = struct.Struct(">B34s10sBffb")
_MARKER = struct.Struct(">BBH50s")
_MARK_BYTES = 49
_S32, _F32 = 5, 7
_FLOAT = 0  # display style
_MOST = (0xFFFF - _HEADER.size) // _FIELD.size - 1  # the info's place is a number of 16 bits


def write(path: Path, sheet: Sheet) -> None:
    """Write the whole sheet."""
    if len(sheet.channels) > _MOST:
        problem = Text(f"an .mlg holds {_MOST} channels", f".mlg вмещает каналов: {_MOST}")
        raise ExportError(str(path.with_suffix("")), problem)
    with path.open("wb") as file:
        file.write(_head(sheet))
        written = 0
        for piece in marked(sheet):
            if isinstance(piece, LogMark):
                file.write(_marker(written, piece))
                written += 1
                continue
            file.write(_blocks(written, piece.times, piece.columns))
            written += len(piece.times)


def _head(sheet: Sheet) -> bytes:
    fields = [_FIELD.pack(_S32, b"Time", b"s", _FLOAT, 0.001, 0.0, 3)]
    for name, channel in zip(_names(sheet.channels), sheet.channels, strict=True):
        unit, digits = _fitting(channel.unit, 9), min(max(channel.decimals, 0), 9)
        fields.append(_FIELD.pack(_F32, name, unit, _FLOAT, 1.0, 0.0, digits))
    info = heading(sheet) + b"\0"
    begins = _HEADER.size + _FIELD.size * len(fields)
    started = 0
    if sheet.started is not None:
        started = min(max(int(sheet.started.timestamp()), 0), 0xFFFFFFFF)
    record = _record(len(sheet.channels))
    header = _HEADER.pack(b"MLVLG", 1, started, begins, begins + len(info), record, len(fields))
    return header + b"".join(fields) + info


def _blocks(written: int, times: Column, columns: list[Column]) -> bytes:
    """Return the blocks: of bytes in their file's order, a column of each after the other."""
    rows, size = len(times), _record(len(columns)) + 5
    numbers = np.arange(written, written + rows) % 256
    clock = np.floor(times * 100_000).astype(np.int64) % 65_536
    fields = [
        clock.astype(">u2"),
        np.clip(np.rint(times * 1000), -(2**31), 2**31 - 1).astype(">i4"),
    ]
    with np.errstate(over="ignore"):  # a value beyond 32 bits becomes infinite
        fields += [values.astype(">f4") for values in columns]
    blocks = bytearray(rows * size)
    blocks[1::size] = numbers.astype(np.uint8).tobytes()
    at, total = 2, np.zeros(rows, np.int64)
    for field in fields:
        data, width = field.tobytes(), field.dtype.itemsize
        for byte in range(width):
            blocks[at::size] = column = data[byte::width]
            if at >= 4:  # the clock does not count
                total += np.frombuffer(column, np.uint8).astype(np.int64)
            at += 1
    blocks[at::size] = (total % 256).astype(np.uint8).tobytes()
    return bytes(blocks)


def _record(channels: int) -> int:
    """Return the bytes of a record: a block's type, number, clock and sum do not count."""
    return 4 + 4 * channels


def _marker(written: int, mark: LogMark) -> bytes:
    clock = math.floor(mark.time * 100_000) % 65_536
    return _MARKER.pack(1, written % 256, clock, _mark_text(mark))


def _mark_text(mark: LogMark) -> bytes:
    """Return the text, or its brief form, else its begin and its end: alarms begin alike."""
    for text in filter(None, (mark.text, mark.brief)):
        if len(data := text.encode()) <= _MARK_BYTES:
            return data
    whole, cut = mark.text.encode(), "…".encode()
    begin = _fitting(mark.text, _MARK_BYTES * 2 // 3 - len(cut))
    rest = _MARK_BYTES - len(begin) - len(cut)
    return begin + cut + whole[-rest:].decode(errors="ignore").encode()


def _names(channels: tuple[Channel, ...]) -> list[bytes]:
    """Return names that fit, all different."""
    names: list[bytes] = []
    taken = {b"Time"}
    for field in field_names(channels):
        name = _fitting(field, 33)
        for number in count(2):
            if name not in taken:
                break
            name = _fitting(field, 29) + f"~{number}".encode()
        taken.add(name)
        names.append(name)
    return names


def _fitting(text: str, size: int) -> bytes:
    """Return `text` in UTF-8, cut between two characters."""
    return text.encode()[:size].decode(errors="ignore").encode()
