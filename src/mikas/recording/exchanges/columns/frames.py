"""A direction's bytes to arrays of frames: `mikas.framing.Decoder` for many at once (§2).

The rules are those of `mikas.framing`, the reference: same events, same order, after the same byte,
however the bytes are cut into pieces, and no error for any bytes. The sum modulo 256 is the same
before and after stuffing, so one pass of `add.reduceat` over 8-bit sums checks all frames (D3);
then one step removes all escapes. A sound frame with an irregular escape (D4), or with a raw
checksum 40, is rare and goes through the incremental decoder. Pieces of 128 to 256 KiB stay in the
processor's cache; memory is bounded by the piece and `limit`.

Every terminator ends a segment. A segment's sum, terminator included, is 0D for a sound frame, and
00 where a checksum 0D may be raw; then the next segment, if it is only a terminator, belongs to the
frame (D3, D5). Such an empty segment has the sum 0D itself, so no rule looks further than one
neighbour.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mikas.framing import ESCAPE, TERMINATOR, Decoder, Frame
from mikas.recording.exchanges.arrays import Bytes, Index, Mask

SOUND, CHECKSUM, TOO_LONG, GIVEN_UP = range(4)
"""An event is sound, or the reason why not. GIVEN_UP: an unfinished frame before a cut, which the
incremental decoder's `reset()` returns.
"""
_NOWHERE: Final = np.empty(0, np.int64)
_NOTHING: Final = np.empty(0, np.uint8)
_NO_FLAG: Final = np.empty(0, np.bool_)
_END: Final = np.uint8(TERMINATOR)
_ESCAPE: Final = np.uint8(ESCAPE)


@dataclass(frozen=True, slots=True)
class FrameBlock:
    """Events in order. Positions count from `wire[0]`, which is byte `origin` of the stream.

    `reasons`: SOUND, or why not. `starts`, `ends`: a frame with its terminators, damage without.
    `needed`: bytes of `wire` that decided the event. `body_starts`, `body_ends`: in `bodies`, which
    is unstuffed; of damage they mean nothing.
    """

    wire: Bytes
    origin: int
    reasons: NDArray[np.uint8]
    starts: Index
    ends: Index
    needed: Index
    bodies: Bytes
    body_starts: Index
    body_ends: Index
    raw_checksum: Mask

    def __len__(self) -> int:
        return len(self.starts)

    @property
    def counted(self) -> Index:
        """The events except abandoned frames."""
        counted: Index = (self.reasons != GIVEN_UP).nonzero()[0]
        return counted

    def wire_of(self, index: int) -> bytes:
        """Return the received bytes of a frame or of damage."""
        return self.wire[self.starts[index] : self.ends[index]].tobytes()

    def body_of(self, index: int) -> bytes:
        """Return the unstuffed body, without checksum."""
        return self.bodies[self.body_starts[index] : self.body_ends[index]].tobytes()


class BulkDecoder:
    """`mikas.framing.Decoder` for large pieces, not strict. `offset`: bytes fed."""

    def __init__(self, *, limit: int = 4096) -> None:
        if limit < 1:
            raise ValueError("limit must be at least 1 byte")
        self.limit = limit
        self.offset: int = 0
        self._carry: Bytes = _NOTHING
        self._overflowed = False

    @property
    def pending(self) -> bytes:
        """The bytes of the unfinished frame."""
        return self._carry.tobytes()

    def feed(self, data: bytes | Bytes, cuts: Index = _NOWHERE) -> FrameBlock:
        """Return the events that `data` completes.

        `cuts`: rising positions in `data` at which the decoder is reset.
        """
        fresh = np.frombuffer(data, np.uint8) if isinstance(data, bytes) else data
        carried = self._carry.size
        wire = np.concatenate((self._carry, fresh)) if carried else fresh
        origin = self.offset - carried
        self.offset += fresh.size
        found = cut_up(wire, cuts + carried if carried else cuts, self.limit, self._overflowed)
        self._overflowed = found.overflowed
        self._carry = wire[found.tail :].copy()
        return self._unstuffed(wire, origin, found)

    def _unstuffed(self, wire: Bytes, origin: int, found: Segments) -> FrameBlock:
        starts, reasons = found.starts, found.reasons
        count = starts.size
        region = wire[: found.stop]
        escapes, owners = found.escapes, found.owners
        if found.torn.size:  # nothing follows them in their frame
            escapes = escapes[~np.isin(escapes + 1, found.torn)]
        if not count or not escapes.size:
            bodies, body_starts, body_ends = region, starts, found.ends - 2
            odd = _NOWHERE
        else:
            followers = region.take(escapes + 1, mode="clip")
            if owners is None:
                owners = starts.searchsorted(escapes, "right")
            before = np.bincount(owners, minlength=count + 1).cumsum()
            keep = np.ones(region.size, np.bool_)
            keep[escapes] = False
            bodies = region[keep]
            # An escape's follower has moved down by all escapes up to its own.
            bodies[escapes - np.arange(escapes.size)] = followers + np.uint8(ESCAPE)
            body_starts, body_ends = starts - before[:-1], found.ends - 2 - before[1:]
            wrong = (followers != TERMINATOR - ESCAPE + 256) & (followers != 0)
            odd = np.unique(owners[wrong]) - 1 if wrong.any() else _NOWHERE
        block = FrameBlock(
            wire=wire,
            origin=origin,
            reasons=reasons,
            starts=starts,
            ends=found.ends,
            needed=found.needed,
            bodies=bodies,
            body_starts=body_starts,
            body_ends=body_ends,
            raw_checksum=found.raw,
        )
        odd = odd[odd >= 0]
        odd = odd[reasons[odd] == SOUND]
        return self._one_by_one(block, odd) if odd.size else block

    def _one_by_one(self, block: FrameBlock, odd: Index) -> FrameBlock:
        """Decode these frames incrementally; their bodies go to the end of `bodies`."""
        decoder = Decoder(limit=self.limit)
        extra = bytearray()
        for index in odd.tolist():
            (event,) = decoder.feed(block.wire_of(index))
            assert isinstance(event, Frame)  # its checksum is right
            block.body_starts[index] = block.bodies.size + len(extra)
            extra += event.body
            block.body_ends[index] = block.bodies.size + len(extra)
            block.raw_checksum[index] = event.raw_checksum
        bodies = np.concatenate((block.bodies, np.frombuffer(extra, np.uint8)))
        return replace(block, bodies=bodies)


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
    reasons: NDArray[np.uint8] = field(default_factory=lambda: _NOTHING)
    raw: Mask = field(default_factory=lambda: _NO_FLAG)
    torn: Index = field(default_factory=lambda: _NOWHERE)
    escapes: Index = field(default_factory=lambda: _NOWHERE)
    owners: Index | None = None
    overflowed: bool = False
    damaged: bool = False


def cut_up(wire: Bytes, cuts: Index, limit: int, overflowed: bool) -> Segments:
    """Return the events in `wire`. It begins with an unfinished or inside an over-long frame."""
    # One search for both special bytes; their order says which escape is in which segment.
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
