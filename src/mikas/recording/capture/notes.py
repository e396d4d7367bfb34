"""Notes in a recording, as blocks between the packets, and the index that finds them in a file.

`annotations/events.py` has the contents of each kind. A note is a Custom Block of pcapng, of the
copyable kind (0x0BAD): other tools skip it (new ones list it without a time, not as a packet), and
editcap keeps it. The project has no Private Enterprise Number: it uses 32473, which RFC 5612
reserves for documentation. Others may use it, too, hence the tag at the start of the payload; one
JSON object in ASCII follows, `{"kind", "time", "data"}`, padded with zeros.

The index is one pass over the file, a fraction of the time of its packets. Sections and notes are
found wherever they begin, also after damage, but not inside each other, so each byte is read once
more at most; requests for faults only at multiples of four, where an undamaged file has its blocks.
"""

from __future__ import annotations

import json
import re
from bisect import bisect_right
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, BinaryIO, Final

from mikas.cancellation import check_cancelled
from mikas.cleaning import clean_json, is_in_calendar
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.scan import RawBlock, Scanner, read_whole, scan

ENTERPRISE: Final = 32473  # RFC 5612: for documentation
TAG: Final = b"mikas/1\n"
CLOCK_TAG: Final = b'"clock"'  # in each note of a `Kind.CLOCK`, hardly in another
LONGEST: Final = 1 << 21  # bytes of a note; 100,000 characters in JSON are at most 1.2 million
_WINDOW: Final = 1 << 20
_OVERLAP: Final = 64  # longer than any pattern with the bytes before it in its block
_SECTION_START: Final = b"\x0a\x0d\x0d\x0a"  # the same in both byte orders
_BEFORE_TAG: Final = 12  # bytes of a note's block
_READ_FAULTS: Final = b"\x02\xfe\x0d"  # the frame; padded with a zero in a packet's block
_BEFORE_DATA: Final = 28  # bytes of a packet's block
_FAULT_REQUESTS: Final = 256
_SECTION_OR_NOTE: Final = re.compile(
    rb"(\x0A\x0D\x0D\x0A.{4}(?:\x4D\x3C\x2B\x1A|\x1A\x2B\x3C\x4D))"
    rb"|(?:\xAD\x0B\0\0.{4}\xD9\x7E\0\0|(\0\0\x0B\xAD.{4}\0\0\x7E\xD9))" + re.escape(TAG),
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
    FAULTS_READ = "faults-read"
    FAULTS = "faults"
    TEST = "test"
    CAR = "car"
    CLOCK = "clock"


_KINDS: Final = frozenset(Kind)
LEFT_OUT: Final = "left-out"
"""Kind of a note that stands only in a capture as it was made ready for reading (`opening`): what
could not be placed in it, or was moved. It becomes a problem."""
INSTRUMENT_PORT: Final = "instrument-port"
"""Kind of a note that stands in no file: a reader of the unit has met the port of an instrument."""


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
    if len(data) > LONGEST:
        raise ValueError("the note is too long")
    return pcapng.Custom(ENTERPRISE, data)


def said_in_place(data: Mapping[str, Any], order: pcapng.Order) -> bytes:
    """Return a note of the kind `LEFT_OUT` as bytes."""
    return pcapng.encode(block_of(Note(LEFT_OUT, 0.0, data)), order)


def read_block(block: pcapng.Custom) -> Note | None:
    """Return the note in `block`, cleaned; None for an unreadable one. An unknown kind stays.

    A note with a number of no use (`clean_json`), or a time outside the calendar, is unreadable.
    """
    is_ours = block.enterprise == ENTERPRISE and block.data.startswith(TAG)
    if not is_ours or len(block.data) > LONGEST:
        return None
    try:
        text = block.data[len(TAG) :].rstrip(b"\0")
        content = clean_json(json.loads(text.decode()))
        kind, time, data = content["kind"], content["time"], dict(content["data"])
        if not isinstance(kind, str) or not isinstance(time, int | float):
            return None
        if isinstance(time, bool) or not is_in_calendar(abs(time)):  # a clock may start below 0
            return None
        return Note(Kind(kind) if kind in _KINDS else kind, float(time), data)
    except (ValueError, TypeError, KeyError, OverflowError, RecursionError):
        return None


@dataclass(slots=True)
class FileIndex:
    """Offsets in a file of `size` bytes, rising. `orders`: the byte order of each section.

    `fault_requests`: the last packets that may be a request for the stored faults (02);
    `corrections`: seconds that `notes` were moved by (`capture.dating`), by recording.
    """

    size: int = 0
    sections: list[int] = field(default_factory=list)
    orders: list[pcapng.Order] = field(default_factory=list)
    notes: list[Note] = field(default_factory=list)
    fault_requests: deque[int] = field(default_factory=lambda: deque(maxlen=_FAULT_REQUESTS))
    corrections: Mapping[int, float] = field(default_factory=dict)

    def section(self, offset: int) -> int:
        """Return the number of the section at `offset`; -1: before the first one."""
        return bisect_right(self.sections, offset) - 1


def index(file: BinaryIO) -> FileIndex:
    """Search a capture; `file` is seekable.

    Unreadable notes, and those of a section of an unknown version, are left out.
    """
    scanner = Scanner(file)
    found = FileIndex(size=scanner.size)
    first = next((item for item in scan(file) if isinstance(item, RawBlock)), None)
    if first is not None and first.kind != pcapng.SECTION:  # the file has lost its begin
        found.sections.append(0)
        found.orders.append("<")
    is_known, end = True, 0  # of the last section or note
    for offset, kind in _places(file, scanner.size):
        if kind == _FAULTS:
            found.fault_requests.append(offset)
            continue
        if offset < end:
            continue
        raw = scanner.block(offset, ">" if kind == _NOTE_REVERSED else "<")
        if raw is None:
            continue
        end, order = raw.end, raw.order
        block: pcapng.Block | None = None
        with suppress(pcapng.Malformed):
            block = pcapng.parse(raw.kind, raw.body, order)
        if isinstance(block, pcapng.Section):
            found.sections.append(offset)
            found.orders.append(order)
            is_known = block.version[0] == 1
        elif isinstance(block, pcapng.Custom) and is_known and (note := read_block(block)):
            if note.kind == LEFT_OUT:
                continue
            recording = max(0, len(found.sections) - 1)
            found.notes.append(Note(note.kind, note.time, note.data, recording, offset))
    return found


_SECTION, _NOTE, _NOTE_REVERSED, _FAULTS = range(4)


def _places(file: BinaryIO, size: int) -> Iterator[tuple[int, int]]:
    """Yield where a section, a note or a request for faults may begin, with its kind."""
    for start in range(0, size, _WINDOW):
        check_cancelled()
        file.seek(start)
        window = read_whole(file, _WINDOW + _OVERLAP)
        # Plain searches are twenty times as fast as the expression, which decides then.
        begins = {*find_all(window, _SECTION_START, 0), *find_all(window, TAG, _BEFORE_TAG)}
        places = [
            (start + begin, _SECTION if match[1] else _NOTE_REVERSED if match[2] else _NOTE)
            for begin in begins
            if begin < _WINDOW and (match := _SECTION_OR_NOTE.match(window, begin))
        ]
        places += [
            (start + at - _BEFORE_DATA, _FAULTS)
            for at in find_all(window, _READ_FAULTS, 0)
            if at < _WINDOW and (start + at) % 4 == 0 and _is_short_packet(window, at)
        ]
        yield from sorted(places)


def _is_short_packet(window: bytes, at: int) -> bool:
    """Return whether a block with the request for faults at `at` may be one: they are short."""
    begin = at - _BEFORE_DATA
    length = window[begin + 4 : begin + 8] if begin >= 0 else bytes(4)
    padding = window[at + len(_READ_FAULTS) : at + len(_READ_FAULTS) + 1]
    return padding == b"\0" and bytes(3) in (length[1:], length[:3])  # in either byte order


def find_all(window: bytes, pattern: bytes, before: int) -> Iterator[int]:
    """Yield where blocks of `window` may begin that have `pattern` after `before` bytes."""
    at = window.find(pattern)
    while at >= 0:
        if at >= before:
            yield at - before
        at = window.find(pattern, at + 1)
