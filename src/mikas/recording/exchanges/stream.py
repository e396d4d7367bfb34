"""One direction of a port as arrays: its frames, and which packet brought which byte (§1, §2)."""

from __future__ import annotations

import numpy as np

from mikas.recording.exchanges.arrays import Floats, Index, Mask
from mikas.recording.exchanges.frames import BulkDecoder, FrameBlock
from mikas.recording.exchanges.matching import NO_REQUEST, SILENCE, SILENCE_AFTER_SENDING
from mikas.recording.exchanges.packets import Packets
from mikas.recording.exchanges.segments import SOUND


class PacketStream:
    """Decodes frames; abandons an unfinished one after a silence, as `exchanges.scalar` does."""

    def __init__(self, byte_time: float) -> None:
        self._byte_time = byte_time
        self._decoder = BulkDecoder()
        self._last = np.nan  # time of the latest packet
        # The packets of the unfinished frame: where they end in the stream, and their times.
        self._ends: Index = np.empty(0, np.int64)
        self._times: Floats = np.empty(0)

    def feed(self, packets: Packets, chosen: Mask, after_sent: Mask) -> tuple[FrameBlock, Index]:
        """Return the events of the `chosen` packets, and the packet that completed each."""
        numbers = chosen.nonzero()[0]
        times, lengths = packets.times[numbers], packets.lengths[numbers]
        decoder = self._decoder
        before = decoder.offset
        unfinished = before - len(decoder.pending)
        ends = lengths.cumsum()
        cuts = (ends - lengths)[self._late(times, lengths, after_sent[numbers])]
        block = decoder.feed(packets.data(numbers), cuts)
        completed = block.needed + (block.origin - before)
        by = numbers[ends.searchsorted(completed)] if len(block) else numbers[:0]

        needed, brings = self._ends > unfinished, lengths > 0
        self._ends = np.concatenate((self._ends[needed], before + ends[brings]))
        self._times = np.concatenate((self._times[needed], times[brings]))
        return block, by

    def packet_times(self, block: FrameBlock, events: Index) -> Floats:
        """Return the times of the packets that brought the first bytes of these frames."""
        times: Floats = self._times[self._first_packets(block, events)]
        return times

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
        times: Floats = self._times[packet] - (self._ends[packet] - starts) * self._byte_time
        more = (packet < last).nonzero()[0]
        while more.size:
            packet[more] += 1
            at = packet[more]
            implied = self._times[at] - (self._ends[at] - starts[more]) * self._byte_time
            times[more] = np.minimum(times[more], implied)
            more = more[at < last[more]]
        return times

    def _late(self, times: Floats, lengths: Index, after_sent: Mask) -> Mask:
        if not times.size:
            return np.zeros(0, np.bool_)
        before = np.concatenate(([self._last], times[:-1]))
        self._last = times[-1]
        silence = times - lengths * self._byte_time - before
        late: Mask = silence > np.where(after_sent, SILENCE_AFTER_SENDING, SILENCE)
        return late


class Events:
    """The events of one direction except abandoned frames, with turns. `index`: in `block`."""

    def __init__(self, block: FrameBlock, turns: Index) -> None:
        self.block = block
        self.index = block.counted
        self.turns = turns[self.index]
        self.sound: Mask = block.reasons[self.index] == SOUND
        self.starts = block.starts[self.index]
        self.lengths = block.ends[self.index] - self.starts
        self.numbers: Index = np.full(self.index.size, NO_REQUEST)

    def of_turn(self, turn: int) -> range:
        """Return the events of one turn."""
        first, last = self.turns.searchsorted([turn, turn + 1])
        return range(first, last)

    def wire(self, event: int) -> bytes:
        return self.block.wire_of(int(self.index[event]))

    def body(self, event: int) -> bytes | None:
        """Return the body of a frame; None for damage."""
        return self.block.body_of(int(self.index[event])) if self.sound[event] else None
