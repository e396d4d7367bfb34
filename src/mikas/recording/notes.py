"""Notes in a recording: events beside the wire, between the packets.

What a note of each kind holds is in `annotations/events.py`, its bytes in `note_blocks.py`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Protocol


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


@dataclass(frozen=True, slots=True)
class Note:
    """One note. `time`: the link's clock; `data`: JSON values by name.

    `kind` is a `Kind`, or a word of a later version. Of a note that was read: `recording` counts
    the recordings of the file as `Source.recording` does, `offset` is the block's place in it.
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
