"""Where a replayed unit says nothing: it had no supply, or nothing was recorded.

A unit that left all requests of two seconds without an answer had no supply. A stretch without any
packet is another matter: the unit may have been well, but nobody listened, the adapter being pulled
out or the laptop asleep. What it would have said is not known, and the value from before is not
played as a fresh one. Whoever recorded it has left a note; in a file without notes it takes a
stretch of several times the usual cycle. A person's pause between two requests is none.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from statistics import median
from typing import Final

from mikas.recording.exchanges.result import GAP
from mikas.recording.notes import Kind, Note
from mikas.replay.model import Series

Stretch = tuple[float, float]

SILENT_FOR: Final = 2.0  # s with requests and no answer: then the unit had no supply
_JUST_BEFORE: Final = 0.001  # s; the supply is there when a request comes
_EARLY: Final = 0.05  # s; a hole ends so much before its end, whose time is not so sure
_CYCLES: Final = 5  # usual ones: a stretch of more without any packet is a hole, note or not
_STEADY: Final = 20  # responses with the same parameters, or there is no usual cycle
_MOST_STEPS: Final = 1000


class Outages:
    """Collects them. `failing_since`: the first of the requests that are without answer so far."""

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
        """A request of `time` got no answer."""
        if self.failing_since is None:
            self.failing_since = time

    def ended(self, time: float) -> None:
        """The unit answered: it had its supply when it was asked, at `time`."""
        since, self.failing_since = self.failing_since, None
        if since is not None and time - since > SILENT_FOR:
            self.without_supply(since - _JUST_BEFORE, time)

    def without_supply(self, begin: float, end: float) -> None:
        """Nor at `end`, but for the request that comes then."""
        self._off.append((begin, end - _JUST_BEFORE))

    def passed(self, recording: int, begin: float, end: float, shift: float) -> None:
        """No packet between two times. `shift`: from the recording's own times to these."""
        if end - begin > GAP:
            noted = self._noted.get(recording, [])
            before = bisect_left(noted, (end - shift,))
            is_noted = before > 0 and begin - shift < noted[before - 1][1]
            self._quiet.append((begin, end, is_noted))

    def conclude(self, series: Iterable[Series]) -> tuple[list[Stretch], list[Stretch]]:
        """Without supply, and holes."""
        cycle = _usual_cycle(series)
        least = max(SILENT_FOR, _CYCLES * cycle) if cycle else 0.0
        holes = [
            (begin + (cycle or 0.0), end - _EARLY)
            for begin, end, noted in self._quiet
            if noted or (cycle is not None and end - begin > least)
        ]
        return _joined(self._off), _joined([it for it in holes if it[0] < it[1]])


def _hole_of(note: Note) -> Stretch | None:
    """When nothing came, by the recording's own times."""
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
    """In order, those that overlap as one."""
    joined: list[Stretch] = []
    for begin, end in sorted(stretches):
        if joined and begin <= joined[-1][1]:
            joined[-1] = joined[-1][0], max(end, joined[-1][1])
        else:
            joined.append((begin, end))
    return joined
