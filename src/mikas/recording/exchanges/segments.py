"""Where events begin and end in a stretch of the wire, and which are sound (§2, D3, D5).

The rules of `mikas.framing` as array operations. Every terminator ends a segment. A segment's sum,
terminator included, is 0D for a sound frame, and 00 where a checksum 0D may be raw; then the next
segment, if it is only a terminator, belongs to the frame. Such an empty segment has the sum 0D
itself, so no rule looks further than one neighbour.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mikas.framing import ESCAPE, TERMINATOR
from mikas.recording.exchanges.arrays import Bytes, Index, Mask

SOUND, CHECKSUM, TOO_LONG, GIVEN_UP = range(4)
"""An event is sound, or the reason why not. GIVEN_UP: an unfinished frame before a cut, which the
incremental decoder's `reset()` returns.
"""
_NOWHERE: Final = np.empty(0, np.int64)
_NO_REASON: Final = np.empty(0, np.uint8)
_NO_FLAG: Final = np.empty(0, np.bool_)
_END: Final = np.uint8(TERMINATOR)
_ESCAPE: Final = np.uint8(ESCAPE)


@dataclass(slots=True)
class Segments:
    """Events as positions. `ends`: frames with terminators, damage without. `tail`: where the
    unfinished frame begins; `stop`: end of the last event. `torn`: cuts in the middle of a frame.
    `escapes`: every 40 before `stop`; `owners`: how many events begin at or before each, if known.
    """

    tail: int
    stop: int = 0
    starts: Index = field(default_factory=lambda: _NOWHERE)
    ends: Index = field(default_factory=lambda: _NOWHERE)
    needed: Index = field(default_factory=lambda: _NOWHERE)
    reasons: NDArray[np.uint8] = field(default_factory=lambda: _NO_REASON)
    raw: Mask = field(default_factory=lambda: _NO_FLAG)
    torn: Index = field(default_factory=lambda: _NOWHERE)
    escapes: Index = field(default_factory=lambda: _NOWHERE)
    owners: Index | None = None
    overflowed: bool = False
    damaged: bool = False


def cut_up(wire: Bytes, cuts: Index, limit: int, overflowed: bool) -> Segments:
    """Return the events in `wire`. It begins with an unfinished or inside an over-long frame."""
    # One search for both special bytes; their order tells which escape is in which segment.
    special = ((wire == _END) | (wire == _ESCAPE)).nonzero()[0]
    is_end = wire.take(special) == _END
    ends = special.take(is_end.nonzero()[0]) + 1
    ranks = (~is_end).nonzero()[0]
    escapes = special.take(ranks)
    torn = _NOWHERE
    if cuts.size:
        inner = cuts[cuts > 0]
        torn = inner[wire[inner - 1] != _END]
        if torn.size:
            ends = np.union1d(ends, torn)
    start = 0
    if overflowed and not (cuts.size and cuts[0] == 0):
        if not ends.size:
            return Segments(tail=wire.size, overflowed=True)
        start = int(ends[0])
        ends = ends[1:]
    found = Segments(tail=start)
    if ends.size:
        found = _judged(wire, (start, ends), limit, (cuts, torn))
        if not (found.damaged or start):
            # Special bytes before an escape are escapes or terminators.
            found.owners = ranks - np.arange(ranks.size) + 1
            inside = int(found.owners.searchsorted(ends.size, "right"))
            found.owners = found.owners[:inside]
        else:
            inside = int(escapes.searchsorted(found.stop))
        found.escapes = escapes[:inside]
    found.torn = torn
    if wire.size - found.tail > limit and not _is_held(wire, found.tail, limit):
        _add_overflow(found, wire.size, limit)
    return found


def _judged(
    wire: Bytes, edges: tuple[int, Index], limit: int, broken: tuple[Index, Index]
) -> Segments:
    """Judge the segments between `edges`. `broken`: all cuts, and those within a frame."""
    (start, ends), (cuts, torn) = edges, broken
    starts = np.empty_like(ends)
    starts[0] = start
    starts[1:] = ends[:-1]
    stop = int(ends[-1])
    sums = np.add.reduceat(wire[:stop], starts, dtype=np.uint8)
    lengths = ends - starts - 1
    plain = sums == _END
    found = Segments(tail=stop, stop=stop, starts=starts, ends=ends, needed=ends)
    if not torn.size and plain.all() and lengths.min() > 0 and lengths.max() <= limit:
        found.reasons = np.zeros(starts.size, np.uint8)
        found.raw = np.zeros(starts.size, np.bool_)
        return found

    finished = wire[ends - 1] == _END
    lengths += ~finished
    too_long = lengths > limit
    empty = lengths == 0
    hopeful = (sums == 0) & finished & ~too_long  # a raw checksum 0D, if another 0D follows
    lost_hope = hopeful & np.isin(ends, cuts) if cuts.size else np.zeros_like(hopeful)
    raw = hopeful & ~lost_hope
    holds = bool(raw[-1]) and stop == wire.size  # the next byte decides
    raw[:-1] &= empty[1:]
    raw[-1] = False

    reasons = np.where((plain | raw) & finished, SOUND, CHECKSUM).astype(np.uint8)
    reasons[~finished | lost_hope] = GIVEN_UP
    reasons[too_long] = TOO_LONG
    found.damaged = True

    last = np.where(reasons == CHECKSUM, ends - 1, ends + raw)
    last[too_long] = starts[too_long] + limit
    needed = np.where(too_long, last + 1, ends + (hopeful & ~lost_hope))
    events = ~empty
    if holds:
        events[-1] = False
        found.tail = found.stop = int(starts[-1])
    found.starts, found.ends, found.needed = starts[events], last[events], needed[events]
    found.reasons, found.raw = reasons[events], raw[events]
    return found


def _is_held(wire: Bytes, tail: int, limit: int) -> bool:
    """Return whether a frame of exactly the limit waits for a second terminator."""
    return wire.size - tail == limit + 1 and bool(wire[-1] == _END)


def _add_overflow(found: Segments, size: int, limit: int) -> None:
    """Add an unfinished frame beyond the limit as damage; its rest will be skipped."""
    start = found.tail
    found.starts = np.append(found.starts, start)
    found.ends = np.append(found.ends, start + limit)
    found.needed = np.append(found.needed, start + limit + 1)
    found.reasons = np.append(found.reasons, np.uint8(TOO_LONG))
    found.raw = np.append(found.raw, np.False_)
    found.overflowed = found.damaged = True
    found.tail = size
