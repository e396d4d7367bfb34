"""Notes in a recording, as blocks between the packets, and the index that finds them in a file.

`annotations/events.py` has the contents of each kind. A note is a Custom Block of pcapng, of the
copyable kind (0x0BAD): other tools skip it (new ones list it without a time, not as a packet), and
editcap keeps it. The project has no Private Enterprise Number: it uses 32473, which RFC 5612
reserves for documentation. Others may use it, too, hence the tag at the start of the payload; one
JSON object in ASCII follows, `{"kind", "time", "data"}`, padded with zeros.

The index is one pass over the file, a fraction of the time of its packets. Sections and notes are
found wherever they begin, also after damage; requests for faults only at multiples of four, where
an undamaged file has its blocks.
"""

from __future__ import annotations

import json
import os
import re
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from enum import StrEnum
from math import isfinite
from typing import Any, BinaryIO, Final

from mikas.cancellation import check_cancelled
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.scan import LARGEST, RawBlock, is_headless, scan

ENTERPRISE: Final = 32473  # RFC 5612: for documentation
TAG: Final = b"mikas/1\n"
_WINDOW: Final = 1 << 20
_OVERLAP: Final = 64  # longer than any pattern with the bytes before it in its block
_SECTION_START: Final = b"\x0a\x0d\x0d\x0a"  # the same in both byte orders
_BEFORE_TAG: Final = 12  # bytes of a note's block
_READ_FAULTS: Final = b"\x02\xfe\x0d"  # the frame; padded with a zero in a packet's block
_BEFORE_DATA: Final = 28  # bytes of a packet's block
_SECTION_OR_NOTE: Final = re.compile(
    rb"(\x0A\x0D\x0D\x0A.{4}(?:\x4D\x3C\x2B\x1A|\x1A\x2B\x3C\x4D))"
    rb"|(?:\xAD\x0B\0\0.{4}\xD9\x7E\0\0|\0\0\x0B\xAD.{4}\0\0\x7E\xD9)" + re.escape(TAG),
    re.DOTALL,
)


class Kind(StrEnum):
    """The kinds of notes."""

    UNIT = "unit"
    CATALOG = "catalog"
    PLAN = "plan"
    NOTE = "note"
    MARKER = "marker"
    GAP = "gap"
    STATE = "state"
    ADAPTER = "adapter"
    ALARM = "alarm"
    LEARNT = "learnt"
    FAULTS = "faults"


_KINDS: Final = frozenset(Kind)


@dataclass(frozen=True, slots=True)
class Note:
    """One note. `time`: the link's clock; `data`: JSON values by name.

    `kind` is a `Kind`, or a word of a later version. Of a note from a file, `recording` counts the
    file's recordings as `Source.recording` does, `offset` is the block's place.
    """

    kind: str
    time: float
    data: Mapping[str, Any] = field(default_factory=dict)
    recording: int = field(default=0, compare=False)
    offset: int = field(default=0, compare=False)


def block_of(note: Note) -> pcapng.Custom:
    """Return `note` as a block. Raises `ValueError` if it is too long or no JSON."""
    content = {"kind": str(note.kind), "time": note.time, "data": dict(note.data)}
    data = TAG + json.dumps(content, allow_nan=False, separators=(",", ":")).encode()
    if len(data) > LARGEST // 2:
        raise ValueError("the note is too long")
    return pcapng.Custom(ENTERPRISE, data)


def read_block(block: pcapng.Custom) -> Note | None:
    """Return the note in `block`; None for an unreadable one. An unknown kind stays.

    Its numbers are finite and fit a float; half of a surrogate pair in a text, which no file or
    screen can show, becomes a “?”.
    """
    if block.enterprise != ENTERPRISE or not block.data.startswith(TAG):
        return None
    try:
        text = block.data[len(TAG) :].rstrip(b"\0")
        content = _printable(_FROM_JSON.decode(text.decode()))
        kind, time, data = content["kind"], content["time"], dict(content["data"])
        if not isinstance(kind, str) or not isinstance(time, int | float):
            return None
        return Note(Kind(kind) if kind in _KINDS else kind, float(time), data)
    except (ValueError, TypeError, KeyError, OverflowError, RecursionError):
        return None


def _finite(text: str) -> float:
    number = float(text)  # 1e999 is infinite; NaN and Infinity are no JSON
    if not isfinite(number):
        raise ValueError(text)
    return number


def _whole(text: str) -> int:
    _finite(text)
    return int(text)


_FROM_JSON: Final = json.JSONDecoder(parse_float=_finite, parse_int=_whole, parse_constant=_finite)


def _printable(value: Any) -> Any:  # noqa: ANN401  (any JSON)
    match value:
        case str():
            return value.encode("utf-8", "replace").decode()
        case list():
            return [_printable(item) for item in value]
        case dict():
            return {_printable(key): _printable(item) for key, item in value.items()}
    return value


@dataclass(slots=True)
class FileIndex:
    """Offsets in a file of `size` bytes, rising. `orders`: the byte order of each section.

    `fault_requests`: packets that may be a request for the stored faults (02).
    """

    size: int = 0
    sections: list[int] = field(default_factory=list)
    orders: list[pcapng.Order] = field(default_factory=list)
    notes: list[Note] = field(default_factory=list)
    fault_requests: list[int] = field(default_factory=list)

    def section(self, offset: int) -> int:
        """Return the number of the section at `offset`; -1: before the first one."""
        return bisect_right(self.sections, offset) - 1

    def order(self, offset: int) -> pcapng.Order:
        """Return the byte order at `offset`."""
        return self.orders[max(0, self.section(offset))]


def index(file: BinaryIO) -> FileIndex:
    """Search a capture; `file` is seekable.

    Unreadable notes, and those of a section of an unknown version, are left out.
    """
    found = FileIndex(size=file.seek(0, os.SEEK_END))
    if is_headless(file):
        found.sections.append(0)
        found.orders.append("<")
    is_known = True
    for offset, kind in _places(file):
        if kind == _FAULTS:
            found.fault_requests.append(offset)
            continue
        block, order = _block_at(file, offset)
        if isinstance(block, pcapng.Section) and kind == _SECTION:
            found.sections.append(offset)
            found.orders.append(order)
            is_known = block.version[0] == 1
        elif isinstance(block, pcapng.Custom) and is_known and (note := read_block(block)):
            recording = max(0, found.section(offset))
            found.notes.append(Note(note.kind, note.time, note.data, recording, offset))
    return found


_SECTION, _NOTE, _FAULTS = range(3)


def _places(file: BinaryIO) -> Iterator[tuple[int, int]]:
    """Yield where a section, a note or a request for faults may begin, with its kind."""
    for start in range(0, 1 << 62, _WINDOW):
        check_cancelled()
        file.seek(start)
        window = file.read(_WINDOW + _OVERLAP)
        # Plain searches are twenty times as fast as the expression, which decides then.
        begins = {*_all(window, _SECTION_START, 0), *_all(window, TAG, _BEFORE_TAG)}
        places = [
            (start + begin, _SECTION if match[1] else _NOTE)
            for begin in begins
            if begin < _WINDOW and (match := _SECTION_OR_NOTE.match(window, begin))
        ]
        for at in _all(window, _READ_FAULTS, 0):
            padding = window[at + len(_READ_FAULTS) : at + len(_READ_FAULTS) + 1]
            if at < _WINDOW and padding == b"\0" and (start + at) % 4 == 0:
                places.append((start + at - _BEFORE_DATA, _FAULTS))
        yield from sorted(places)
        if len(window) <= _WINDOW:
            return


def _all(window: bytes, pattern: bytes, before: int) -> Iterator[int]:
    """Yield where blocks may begin that have `pattern` after `before` bytes."""
    at = window.find(pattern)
    while at >= 0:
        if at >= before:
            yield at - before
        at = window.find(pattern, at + 1)


def _block_at(file: BinaryIO, offset: int) -> tuple[pcapng.Block | None, pcapng.Order]:
    file.seek(offset)
    order: pcapng.Order = ">" if file.read(1) == b"\0" else "<"
    item = next(scan(file, offset, order), None)
    if isinstance(item, RawBlock):
        with suppress(pcapng.Malformed):
            return pcapng.parse(item.kind, item.body, item.order), item.order
    return None, order
