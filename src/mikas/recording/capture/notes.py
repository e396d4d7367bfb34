"""Notes in a recording: events, as blocks between the packets.

`annotations/events.py` has the contents of each kind; `index.py` finds notes in a file.

A note is a Custom Block of pcapng, of the copyable kind (0x0BAD): other tools skip it (new ones
list it without a time, not as a packet), and editcap keeps it. The project has no Private
Enterprise Number: it uses 32473, which RFC 5612 reserves for documentation. Others may use it, too,
hence the tag at the start of the payload; one JSON object in ASCII follows,
`{"kind", "time", "data"}`, padded with zeros.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Final, Protocol

from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.scan import LARGEST

ENTERPRISE: Final = 32473  # RFC 5612: for documentation
TAG: Final = b"mikas/1\n"


class Kind(StrEnum):
    """The kinds of notes."""

    UNIT = "unit"
    CATALOG = "catalog"
    PLAN = "plan"
    NOTE = "note"
    MARKER = "marker"
    GAP = "gap"
    STATE = "state"
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


class NoteSink(Protocol):
    """A writer of notes."""

    def note(self, note: Note) -> None:
        """Write `note`."""


def block_of(note: Note) -> pcapng.Custom:
    """Return `note` as a block. Raises `ValueError` if it is too long or no JSON."""
    content = {"kind": str(note.kind), "time": note.time, "data": dict(note.data)}
    data = TAG + json.dumps(content, allow_nan=False, separators=(",", ":")).encode()
    if len(data) > LARGEST // 2:
        raise ValueError("the note is too long")
    return pcapng.Custom(ENTERPRISE, data)


def read_block(block: pcapng.Custom) -> Note | None:
    """Return the note in `block`; None for an unreadable one. An unknown kind stays."""
    if block.enterprise != ENTERPRISE or not block.data.startswith(TAG):
        return None
    try:
        content = json.loads(block.data[len(TAG) :].rstrip(b"\0"), parse_constant=_refuse)
        kind, time, data = content["kind"], float(content["time"]), dict(content["data"])
        if not isinstance(kind, str):
            return None
        return Note(Kind(kind) if kind in _KINDS else kind, time, data)
    except (ValueError, TypeError, KeyError, OverflowError, RecursionError):
        return None


def _refuse(constant: str) -> None:
    """Refuse NaN and infinity, which are no JSON."""
    raise ValueError(constant)
