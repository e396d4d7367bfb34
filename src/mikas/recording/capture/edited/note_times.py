"""Find out whether another tool has given the packets of a recording other times than its notes.

`editcap -t` shifts the packets; a note has no time that it knows, and stays as it was. But it stays
in its place, too, and a note that is written while the line is read has a time between those of the
packets around it:

    packet 10.00   note 10.02   packet 10.05   as recorded: 0 lies between -0.02 and 0.03
    packet 70.00   note 10.02   packet 70.05   shifted, by something between 59.98 and 60.03

One such note proves nothing: a thread may have been held up before it wrote. Notes in two places
that agree to 50 ms do, if time has passed between them. A file may hold parts that were shifted by
other seconds, as in a merged one: notes that follow each other and agree are a part.

The notes of a shifted part follow their packets. Left out are those between two parts, those of
moments where the shift is not known to 0.1 s, and notes of a set date (`capture.dating`): who
shifted the packets has given them their date.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from math import inf
from operator import itemgetter
from typing import BinaryIO, Final, NamedTuple

from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.dating import moved, set_by
from mikas.recording.capture.edited.marks import Edit, Marked, PacketTimes, changed, marked
from mikas.recording.capture.notes import LEFT_OUT, Kind, Note, block_of, said_in_place
from mikas.recording.capture.scan import RawBlock, Scanner

_LEAST: Final = 0.5  # s that count as a shift
_AGREE: Final = 0.05  # s
_KNOWN: Final = 0.1  # s
_STAMPED: Final = 0.01  # s
_DIGITS: Final = 6
_LIVE: Final = frozenset(
    [Kind.UNIT, Kind.CATALOG, Kind.PLAN, Kind.STATE, Kind.LEARNT, Kind.FAULTS_READ]
)
"""Kinds that are written at their time; others may be added later, or have an earlier time."""
_TIMELESS: Final = frozenset([Kind.UNIT, Kind.CATALOG, Kind.CAR, Kind.PLAN, "about"])


class Shift(NamedTuple):
    """By how many seconds the packets are later than their notes. `known`: so are its moments."""

    seconds: float = 0.0
    known: bool = True


_NONE: Final = Shift()
_UNKNOWN: Final = Shift(known=False)


@dataclass(slots=True)
class _Run:
    """Notes that follow each other. `times`: of those that were written at their time."""

    begin: int
    end: int
    order: pcapng.Order
    times: list[float] = field(default_factory=list)


@dataclass(slots=True)
class _Part:
    """Runs that agree: their shift lies between `least` and `most`."""

    begin: int
    end: int
    least: float = -inf
    most: float = inf
    shifted: list[float] = field(default_factory=list)  # the first and the last note that shows it

    def takes(self, run: _Run, least: float, most: float) -> bool:
        """Add a run; not if it does not agree."""
        if max(self.least, least) > min(self.most, most) + _AGREE:
            return False
        self.least, self.most = max(self.least, least), min(self.most, most)
        self.end = run.end
        if least > _LEAST or most < -_LEAST:
            self.shifted[1:] = [run.times[0]]
        return True

    @property
    def shift(self) -> Shift | None:
        """None: a single note shows one, which proves nothing."""
        if not self.shifted:
            return _NONE
        if self.shifted[-1] - self.shifted[0] <= _AGREE:
            return None
        least, most = sorted((self.least, self.most))
        return Shift(_shortest(least, most), most - least <= _KNOWN)


def _shortest(least: float, most: float) -> float:
    """Return the number with the fewest digits between these: what a person has typed.

    A note may be stamped some milliseconds before the packet that it follows.
    """
    middle = (least + most) / 2
    digits = (round(middle, digits) for digits in range(_DIGITS))
    slack = max(_STAMPED - (most - least), 0.0) / 2
    close = (it for it in digits if least - slack <= it <= most + slack)
    return next(close, round(middle, _DIGITS))


class NoteTimes:
    """The shifts in a file, from what `marked` yields of it."""

    def __init__(self, file: BinaryIO) -> None:
        self._scanner = Scanner(file)
        self._begin = 0  # of the present section
        self._packets = PacketTimes(self._scanner)
        self._run: _Run | None = None
        self._parts: list[_Part] = []
        self._places: list[tuple[int, Shift]] = []  # where each begins

    def add(self, raw: RawBlock, item: Marked) -> None:
        """Take the next of them."""
        match item:
            case pcapng.Section():
                self.finish()
                self._begin = raw.offset
                self._packets.begin(raw)
            case Note():
                if self._run is None or self._run.end != raw.offset:
                    self._end_run()
                    self._run = _Run(raw.offset, raw.end, raw.order)
                self._run.end = raw.end
                if item.kind in _LIVE:
                    self._run.times.append(item.time)

    def finish(self) -> None:
        """Take the end of a section."""
        self._end_run()
        shifts = [part.shift for part in self._parts]
        if any(shift and shift.seconds for shift in shifts):
            between = _UNKNOWN if len(shifts) > 1 else shifts[0] or _UNKNOWN
            self._places.append((self._begin, between))
            for part, shift in zip(self._parts, shifts, strict=True):
                self._places += [(part.begin, shift or _UNKNOWN), (part.end, between)]
            self._places[-1] = (self._parts[-1].end, shifts[-1] or _UNKNOWN)
        elif self._places:
            self._places.append((self._begin, _NONE))
        self._parts = []

    @property
    def is_shifted(self) -> bool:
        """Whether any packets were shifted."""
        return bool(self._places)

    def at(self, offset: int) -> Shift:
        """Return the shift of a note at that place of the file."""
        number = bisect_right(self._places, offset, key=itemgetter(0))
        return self._places[number - 1][1] if number else _NONE

    def _end_run(self) -> None:
        run, self._run = self._run, None
        if run is None or not run.times:
            return
        before = self._packets.of(self._scanner.extent_before(run.begin, run.order))
        after = self._packets.of(self._scanner.extent(run.end, run.order))
        if before is None or after is None:  # perhaps put there: before all packets, or behind them
            return
        shift = before - min(run.times), after - max(run.times)
        if not self._parts or not self._parts[-1].takes(run, *shift):
            self._parts.append(_Part(run.begin, run.end))
            self._parts[-1].takes(run, *shift)


def shift_at_end(file: BinaryIO) -> float:
    """Return by how many seconds readers move a note that is added to a file."""
    times = NoteTimes(file)
    for raw, item in marked(file):
        times.add(raw, item)
    times.finish()
    return times.at(file.seek(0, 2)).seconds


def with_moved_notes(file: BinaryIO, times: NoteTimes) -> BinaryIO:
    """Return a capture whose notes follow their packets, a temporary file."""
    return changed(file, _changes(file, times))


def _changes(file: BinaryIO, times: NoteTimes) -> Iterator[Edit]:
    count = end = 0
    order: pcapng.Order = "<"
    said = _NONE
    for raw, note in marked(file):
        shift = times.at(raw.offset)
        if not isinstance(note, Note) or note.kind == LEFT_OUT or shift == _NONE:
            continue
        blocks, end, order = b"", raw.end, raw.order
        if shift.seconds not in (0.0, said.seconds):
            said = shift
            blocks += said_in_place({"seconds": shift.seconds}, order)
        if note.kind in _TIMELESS or (shift.known and not set_by(note)):
            later = moved(note, shift.seconds)
            later = replace(later, time=round(later.time, _DIGITS))
            blocks += pcapng.encode(block_of(later), order)
        else:
            count += 1
        yield Edit(raw.offset, raw.end, blocks)
    if count:
        yield Edit(end, end, said_in_place({"count": count, "shifted": True}, order))
