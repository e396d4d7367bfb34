"""Runs of regular exchanges in a stretch of packets, found at once: what replay passes over.

A regular exchange is three packets: a request, its echo byte for byte, one response; or two on a
line without echo; or, of a stream, a response alone. Each packet is one sound frame in its usual
form. Behind such an exchange nothing is left that could touch the next one: the decoders wait for
nothing, and the request has been answered. So where two of them stand side by side, what
`mikas.recording.inspect.frames` comes to for the second does not depend on the first.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mikas.framing import Decoder, Frame
from mikas.recording.exchanges.arrays import Bytes, Floats, Index, Mask, equal, joined
from mikas.recording.exchanges.frames import SOUND, BulkDecoder
from mikas.recording.exchanges.packets import Packets


@dataclass(frozen=True, slots=True)
class Run:
    """Regular exchanges of one kind, one behind another. `size`: packets of each.

    `first`, `count`: of packets, of exchanges. `asked`: the requests' wire bytes, as numbers in
    `wires`; none in a stream. `times`: of the first packet of each; `ends`: of the last.
    """

    first: int
    count: int
    size: int
    asked: Index
    wires: list[bytes]
    times: Floats
    ends: Floats
    wire_lengths: Index
    bodies: Bytes
    body_starts: Index
    body_lengths: Index


class Regular:
    """The packets of one stretch."""

    def __init__(self, packets: Packets) -> None:
        self._packets = packets
        self._count = packets.sent.size
        received = (~packets.sent).nonzero()[0]
        lengths = packets.lengths[received]
        wire = joined(packets.buffer, packets.at[received], lengths)
        block = BulkDecoder().feed(wire)
        sound = (block.reasons == SOUND) & ~block.raw_checksum & ~block.irregular
        starts, ends = block.starts[sound], block.ends[sound]
        begins = lengths.cumsum() - lengths
        at = np.minimum(starts.searchsorted(begins), max(0, starts.size - 1))
        self._frame: Index = np.full(self._count, -1)
        if starts.size:
            whole = (starts[at] == begins) & (ends[at] == begins + lengths)
            self._frame[received[whole]] = sound.nonzero()[0][at[whole]]
        self._block = block
        self._rising: Mask = np.ones(self._count, np.bool_)
        self._rising[1:] = np.diff(packets.times) >= 0
        self._kinds: dict[int, Mask] = {}

    def run(self, first: int, *, size: int) -> Run | None:
        """The run of exchanges of `size` packets that begins at packet `first`; None: no two."""
        if size not in self._kinds:
            self._kinds[size] = self._begins(size)
        exchanges = self._kinds[size][first::size]
        stop = exchanges.argmin() if not exchanges.all() else exchanges.size
        if stop < 2:
            return None
        return self._made(first, int(stop), size)

    @cached_property
    def _raw(self) -> bytes:
        return self._packets.buffer.tobytes()

    def _begins(self, size: int) -> Mask:
        """Where a regular exchange of this size begins."""
        packets, count = self._packets, self._count
        good = np.zeros(count, np.bool_)
        if count < size + 1:
            return good
        sent, frame = packets.sent, self._frame
        last = count - size  # what follows must be seen
        answer = frame[size - 1 : count - 1] >= 0
        good[:last] = answer
        for step in range(size):
            good[:last] &= self._rising[step : step + last]
        if size == 1:
            return good
        good[:last] &= sent[:last] & sent[size : size + last]
        good[:last] &= ~sent[size - 1 : size - 1 + last]
        if size == 3:
            good[:last] &= ~sent[1 : 1 + last] & (frame[1 : 1 + last] >= 0)
        maybe = good.nonzero()[0]
        same = packets.lengths[maybe] == packets.lengths[maybe + 1]
        pairs = maybe[same]
        repeated = equal(
            packets.buffer,
            packets.at[pairs],
            packets.buffer,
            packets.at[pairs + 1],
            packets.lengths[pairs],
        )
        echoed = np.zeros(count, np.bool_)
        echoed[pairs[repeated]] = True
        return good & echoed if size == 3 else good & ~echoed

    def _made(self, first: int, count: int, size: int) -> Run:
        packets, block = self._packets, self._block
        begin = first + size * np.arange(count)
        end = begin + size - 1
        frames = self._frame[end]
        asked, wires = np.full(count, -1), list[bytes]()
        if size > 1:
            numbers: dict[bytes, int] = {}
            raw = self._raw
            at, lengths = packets.at[begin].tolist(), packets.lengths[begin].tolist()
            pieces = [raw[a : a + n] for a, n in zip(at, lengths, strict=True)]
            asked = np.array([numbers.setdefault(piece, len(numbers)) for piece in pieces])
            wires = list(numbers)
        return Run(
            first=first,
            count=count,
            size=size,
            asked=asked,
            wires=wires,
            times=packets.times[begin],
            ends=packets.times[end],
            wire_lengths=packets.lengths[end],
            bodies=block.bodies,
            body_starts=block.body_starts[frames],
            body_lengths=block.body_ends[frames] - block.body_starts[frames],
        )


def body_of(wire: bytes) -> bytes | None:
    """The body, if `wire` is one sound frame in its usual form."""
    events = Decoder().feed(wire)
    match list(events):
        case [Frame(raw_checksum=False, irregular=False) as frame] if frame.wire == wire:
            return frame.body
    return None
