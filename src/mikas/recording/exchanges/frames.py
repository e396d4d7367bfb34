"""A direction's bytes to arrays of frames: `mikas.framing.Decoder` for many at once (§2).

The rules are those of `mikas.framing`, the reference: same events, same order, after the same byte,
however the bytes are cut into pieces, and no error for any bytes. The sum modulo 256 is the same
before and after stuffing, so one pass of `add.reduceat` over 8-bit sums checks all frames (D3);
then one step removes all escapes. A sound frame with an irregular escape (D4), or with a raw
checksum 40, is rare and goes through the incremental decoder. Pieces of 128 to 256 KiB stay in the
processor's cache; memory is bounded by the piece and `limit`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mikas.framing import ESCAPE, TERMINATOR, Decoder, Frame
from mikas.recording.exchanges.arrays import Bytes, Index, Mask
from mikas.recording.exchanges.segments import (
    GIVEN_UP,
    SOUND,
    Segments,
    cut_up,
)

_NOWHERE: Final = np.empty(0, np.int64)
_NOTHING: Final = np.empty(0, np.uint8)


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
    irregular: Mask

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
        self.offset = 0
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
        irregular = np.zeros(count, np.bool_)
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
            irregular=irregular,
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
            block.irregular[index] = event.irregular
        bodies = np.concatenate((block.bodies, np.frombuffer(extra, np.uint8)))
        return replace(block, bodies=bodies)
