"""One direction of a port: its frames, and which packet brought which byte (§1, §2)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mikas.recording.exchanges.arrays import Floats, Index, Mask
from mikas.recording.exchanges.columns.frames import SOUND, BulkDecoder, FrameBlock
from mikas.recording.exchanges.columns.packets import Packets
from mikas.recording.exchanges.matching import SILENCE, SILENCE_AFTER_SENDING
from mikas.recording.exchanges.verdicts import NO_REQUEST


@dataclass(slots=True)
class Events:
    """The events of one direction except abandoned frames, as columns. `index`: in `block`.

    `turns`: of the packets that completed them. `packets`: these; `packet_ends`: where these end in
    `block.wire`. `begins`, `ends`: times of the packets with their first and last bytes. `came`,
    `brought`: by turn, how many bytes came before it, and in it. `numbers`: of request bodies.
    """

    block: FrameBlock
    index: Index
    turns: Index
    packets: Index
    packet_ends: Index
    begins: Floats
    ends: Floats
    came: Index
    brought: Index
    stream: PacketStream
    sound: Mask = field(init=False)
    starts: Index = field(init=False)
    lengths: Index = field(init=False)
    numbers: Index = field(init=False)

    def __post_init__(self) -> None:
        block = self.block
        self.sound = block.reasons[self.index] == SOUND
        self.starts = block.starts[self.index]
        self.lengths = block.ends[self.index] - self.starts
        self.numbers = np.full(self.index.size, NO_REQUEST)

    @property
    def body_lengths(self) -> Index:
        """Lengths of the bodies; of damage they mean nothing."""
        return self.block.body_ends[self.index] - self.block.body_starts[self.index]

    @property
    def byte_time(self) -> float:
        return self.stream.byte_time

    def wire_time(self, event: int) -> float:
        """Return when the first byte of an event began on the wire."""
        return float(self.stream.wire_times(self.block, self.index[event : event + 1])[0])

    def of_turn(self, turn: int) -> range:
        """Return the events of one turn."""
        first, last = self.turns.searchsorted([turn, turn + 1])
        return range(first, last)

    def wire(self, event: int) -> bytes:
        return self.block.wire_of(int(self.index[event]))

    def body(self, event: int) -> bytes | None:
        """Return the body of a frame; None for damage."""
        return self.block.body_of(int(self.index[event])) if self.sound[event] else None


class PacketStream:
    """One direction of a port: its frames, and which packet brought which byte (§1, §2).

    Decodes frames; abandons an unfinished one after a silence, as `exchanges.scalar` does.
    """

    def __init__(self, byte_time: float) -> None:
        self.byte_time = byte_time
        self._decoder = BulkDecoder()
        self._last = np.nan  # time of the latest packet
        # The packets of the unfinished frame: where they end in the stream, and their times.
        self._ends: Index = np.empty(0, np.int64)
        self._times: Floats = np.empty(0)

    def events(self, packets: Packets, placed: tuple[Mask, Index, int], after_sent: Mask) -> Events:
        """Return the events of some packets. `placed`: which, the turn of each, and the number of
        turns.
        """
        chosen, turns, count = placed
        numbers = chosen.nonzero()[0]
        times, lengths = packets.times[numbers], packets.lengths[numbers]
        decoder = self._decoder
        before = decoder.offset
        unfinished = before - len(decoder.pending)
        ends = lengths.cumsum()
        cuts = (ends - lengths)[self._late(times, lengths, after_sent[numbers])]
        block = decoder.feed(packets.data(numbers), cuts)
        index = block.counted
        completed = block.needed[index] + (block.origin - before)
        by = ends.searchsorted(completed) if index.size else index

        needed, brings = self._ends > unfinished, lengths > 0
        self._ends = np.concatenate((self._ends[needed], before + ends[brings]))
        self._times = np.concatenate((self._times[needed], times[brings]))
        of_turn = np.bincount(turns[numbers], lengths, count).astype(np.int64)
        return Events(
            block=block,
            index=index,
            turns=turns[numbers[by]] if index.size else index,
            packets=numbers[by] if index.size else index,
            packet_ends=ends[by] + (before - block.origin) if index.size else index,
            begins=self._times[self._first_packets(block, index)],
            ends=self._times[self._ends.searchsorted(block.ends[index] + block.origin)],
            came=before + of_turn.cumsum() - of_turn,
            brought=of_turn,
            stream=self,
        )

    def _first_packets(self, block: FrameBlock, events: Index) -> Index:
        found: Index = self._ends.searchsorted(block.starts[events] + block.origin, "right")
        return found

    def wire_times(self, block: FrameBlock, events: Index) -> Floats:
        """Return when the first bytes of these frames of the latest block began on the wire.

        That is the earliest time that any packet with a byte of the frame implies: a packet may
        have been delayed (`mikas.tester.exchange`).
        """
        starts = block.starts[events] + block.origin
        packet = self._first_packets(block, events)
        last = self._ends.searchsorted(block.ends[events] + block.origin)
        times: Floats = self._times[packet] - (self._ends[packet] - starts) * self.byte_time
        more = (packet < last).nonzero()[0]
        while more.size:
            packet[more] += 1
            at = packet[more]
            implied = self._times[at] - (self._ends[at] - starts[more]) * self.byte_time
            times[more] = np.minimum(times[more], implied)
            more = more[at < last[more]]
        return times

    def _late(self, times: Floats, lengths: Index, after_sent: Mask) -> Mask:
        if not times.size:
            return np.zeros(0, np.bool_)
        before = np.concatenate(([self._last], times[:-1]))
        self._last = times[-1]
        silence = times - lengths * self.byte_time - before
        late: Mask = silence > np.where(after_sent, SILENCE_AFTER_SENDING, SILENCE)
        return late
