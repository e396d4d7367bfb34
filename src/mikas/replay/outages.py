"""When a replayed ECU is silent: it had no supply, or nothing was recorded.

An ECU that left all requests of two seconds unanswered had no supply. During a stretch without any
packet the ECU may have worked, but the line was not recorded: the adapter was pulled out, or the
computer asleep. Its responses are not known, and an old value is not played as a new one. The
recorder has left a note on such a hole; without a note, only a stretch of several usual cycles is
one. A pause between two requests of a person is none.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from statistics import median
from typing import Final

from mikas.recording.capture.notes import Kind, Note
from mikas.recording.exchanges.result import GAP
from mikas.replay.model import Series

Stretch = tuple[float, float]

SILENT_FOR: Final = 2.0  # s with requests and no answer: then the unit had no supply
_JUST_BEFORE: Final = 0.001  # s; the supply is there when a request comes
_EARLY: Final = 0.05  # s; a hole ends so much before its end, whose time is not so sure
_CYCLES: Final = 5  # usual ones: a stretch of more without any packet is a hole, note or not
_STEADY: Final = 20  # responses with the same parameters, or there is no usual cycle
_MOST_STEPS: Final = 1000


class Outages:
    """Collects outages. `failing_since`: time of the first request that is unanswered so far."""

    def __init__(self, notes: Iterable[Note] = ()) -> None:
        self.failing_since: float | None = None
        self._off: list[Stretch] = []
        self._quiet: list[tuple[float, float, bool]] = []  # without a packet; whether noted
        self._noted: dict[int, list[Stretch]] = {}
        for note in notes:
            if (noted := _hole_of(note)) is not None:
                self._noted.setdefault(note.recording, []).append(noted)
        self._noted = {number: _joined(holes) for number, holes in self._noted.items()}

    def failed(self, time: float) -> None:
        """Note that a request of `time` got no response."""
        if self.failing_since is None:
            self.failing_since = time

    def ended(self, time: float) -> None:
        """Note that the ECU had its supply at `time`, when it was asked."""
        since, self.failing_since = self.failing_since, None
        if since is not None and time - since > SILENT_FOR:
            self.without_supply(since - _JUST_BEFORE, time)

    def without_supply(self, begin: float, end: float) -> None:
        """Note that it had no supply until the request of `end`."""
        self._off.append((begin, end - _JUST_BEFORE))

    def passed(self, recording: int, begin: float, end: float, shift: float) -> None:
        """Note a stretch without a packet. `shift`: from the recording's own times to these."""
        if end - begin > GAP:
            noted = self._noted.get(recording, [])
            before = bisect_left(noted, (end - shift,))
            is_noted = before > 0 and begin - shift < noted[before - 1][1]
            self._quiet.append((begin, end, is_noted))

    def conclude(self, series: Iterable[Series]) -> tuple[list[Stretch], list[Stretch]]:
        """Return the losses of supply, and the holes."""
        cycle = _usual_cycle(series)
        least = max(SILENT_FOR, _CYCLES * cycle) if cycle else 0.0
        holes = [
            (begin + (cycle or 0.0), end - _EARLY)
            for begin, end, noted in self._quiet
            if noted or (cycle is not None and end - begin > least)
        ]
        return _joined(self._off), _joined([it for it in holes if it[0] < it[1]])


def _hole_of(note: Note) -> Stretch | None:
    """Return the stretch of a noted hole, by the recording's own times."""
    if note.kind == Kind.STATE and note.data.get("state") == "no-port":
        return note.time, note.time
    if note.kind != Kind.GAP:
        return None
    began, ended = note.data.get("began"), note.data.get("ended")
    if not isinstance(began, (int, float)):
        return None
    return float(began), float(ended) if isinstance(ended, (int, float)) else float("inf")


def _usual_cycle(series: Iterable[Series]) -> float | None:
    longest: Sequence[float] = max((each.times for each in series), key=len, default=())
    if len(longest) < _STEADY:
        return None
    apart = max(1, len(longest) // _MOST_STEPS)
    return median(longest[at] - longest[at - 1] for at in range(1, len(longest), apart))


def _joined(stretches: list[Stretch]) -> list[Stretch]:
    """Return the stretches in order, overlapping ones as one."""
    joined: list[Stretch] = []
    for begin, end in sorted(stretches):
        if joined and begin <= joined[-1][1]:
            joined[-1] = joined[-1][0], max(end, joined[-1][1])
        else:
            joined.append((begin, end))
    return joined
