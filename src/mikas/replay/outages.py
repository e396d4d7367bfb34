"""When the replayed ECU is silent.

An ECU that left all requests of two seconds unanswered had no supply. During a span without any
packet the ECU may have worked, but the line was not recorded (the adapter was unplugged, or the
computer asleep), and an old value is not played as a new one. The recorder leaves a note on such a
hole; without a note, only a span of several usual cycles is a hole, for a person pauses too.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from math import inf
from statistics import median
from typing import Final

from mikas.recording.annotations.events import gap_of
from mikas.recording.capture.notes import Kind, Note
from mikas.recording.exchanges.result import GAP
from mikas.recording.table.channels import Span, united
from mikas.replay.model import Series

SILENT_FOR: Final = 2.0  # s of unanswered requests are a loss of supply
_JUST_BEFORE: Final = 0.001  # s; the supply is there when a request comes
_EARLY: Final = 0.05  # s; a hole ends earlier by this, as the time of its end is inexact
_CYCLES: Final = 5  # usual ones; a longer pause is a hole, also without a note
_STEADY: Final = 20  # responses with the same parameters that show the usual cycle
_MOST_STEPS: Final = 1000


class Outages:
    """Collects outages. `failing_since`: time of the first request that is unanswered so far."""

    def __init__(self) -> None:
        self.failing_since: float | None = None
        self._off: list[Span] = []
        self._quiet: list[tuple[int, float, float, float]] = []  # without a packet
        self._noted: dict[int, list[Span]] = {}

    def add_note(self, note: Note) -> None:
        """Take a note of the recording."""
        if (noted := _hole_of(note)) is not None:
            self._noted.setdefault(note.recording, []).append(noted)

    def failed(self, time: float) -> None:
        """Note that a request of `time` got no response."""
        if self.failing_since is None:
            self.failing_since = time

    def supplied(self, time: float) -> None:
        """Note that the ECU had its supply at the request of `time`."""
        since, self.failing_since = self.failing_since, None
        if since is not None and time - since > SILENT_FOR:
            self.without_supply(since - _JUST_BEFORE, time)

    def without_supply(self, begin: float, end: float) -> None:
        """Note that the ECU had no supply until the request of `end`."""
        self._off.append((begin, end - _JUST_BEFORE))

    def add_pause(self, recording: int, begin: float, end: float, shift: float) -> None:
        """Note a span without a packet. `shift`: from the recording's own times to these."""
        if end - begin > GAP:
            self._quiet.append((recording, begin, end, shift))

    def conclude(self, series: Iterable[Series]) -> tuple[list[Span], list[Span]]:
        """Return the losses of supply, and the holes."""
        cycle = _usual_cycle(series)
        least = inf if cycle is None else max(SILENT_FOR, _CYCLES * cycle)
        all_noted = {recording: united(noted) for recording, noted in self._noted.items()}
        holes = []
        for recording, begin, end, shift in self._quiet:
            noted = all_noted.get(recording, [])
            before = bisect_left(noted, (end - shift,))
            is_noted = before > 0 and begin - shift < noted[before - 1][1]
            if is_noted or end - begin > least:
                holes.append((begin + (cycle or 0.0), end - _EARLY))
        return united(self._off), united([it for it in holes if it[0] < it[1]])


def _hole_of(note: Note) -> Span | None:
    """Return the span of a noted hole, by the recording's own times."""
    if note.kind == Kind.STATE and note.data.get("state") == "no-port":
        return note.time, note.time
    if note.kind != Kind.GAP:
        return None
    began, ended = gap_of(note)
    return began, inf if ended is None else ended


def _usual_cycle(series: Iterable[Series]) -> float | None:
    longest: Sequence[float] = max((each.times for each in series), key=len, default=())
    if len(longest) < _STEADY:
        return None
    apart = max(1, len(longest) // _MOST_STEPS)
    return median(longest[at] - longest[at - 1] for at in range(1, len(longest), apart))
