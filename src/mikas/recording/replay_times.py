"""When what a recording holds happens in the replay, whose times count from the first packet.

Several recordings in one file (it was appended to) follow each other with a short silence between,
however long it really was; where times run back, they go on from there.
"""

from __future__ import annotations

from collections import deque
from typing import Final

from mikas.link.base import BITS_PER_BYTE
from mikas.link.tee import Direction
from mikas.recording.reader import Packet, Source
from mikas.recording.replay_recorded import Recorded
from mikas.recording.replay_silences import Silences

PAUSE: Final = 3.0  # s between two recordings in a file
AFTER: Final = 0.5  # s that the end of a recording is longer than its last packet
_JUMP: Final = 1.0  # s back: a clock that was set, not one that trembles
_MOST_PACKETS: Final = 8192  # longer than a frame can be in single bytes


class Arrivals:
    """One direction of a port: which packet brought which byte, and when."""

    def __init__(self, byte_time: float) -> None:
        self.byte_time = byte_time
        self._total = 0
        self._packets: deque[tuple[int, float]] = deque(maxlen=_MOST_PACKETS)

    def add(self, length: int, time: float) -> None:
        """A packet of `time`."""
        self._total += length
        self._packets.append((self._total, time))

    def began(self, offset: int) -> float:
        """When this byte began on the wire; those before it are forgotten."""
        packets = self._packets
        while packets[0][0] <= offset:
            packets.popleft()
        end, time = packets[0]
        return time - (end - offset) * self.byte_time


class Timeline:
    """Places packets, one after another. `latest`: the time of the last one; `began`: of the
    present recording.
    """

    def __init__(self, found: Recorded, silences: Silences) -> None:
        self.latest = 0.0
        self.began = 0.0
        self._found = found
        self._silences = silences
        self._shift: float | None = None
        self._recording = 0
        self._arrivals: dict[tuple[Source, Direction], Arrivals] = {}

    @property
    def has_begun(self) -> bool:
        """Whether there was a packet."""
        return self._shift is not None

    def is_of_another(self, packet: Packet) -> bool:
        """Whether `packet` is the first one of another recording."""
        return self._shift is not None and packet.source.recording != self._recording

    def place(self, packet: Packet) -> Packet:
        """The packet, with its time in the replay."""
        time = self._time(packet)
        key = packet.source, packet.direction
        if key not in self._arrivals:
            self._arrivals[key] = Arrivals(BITS_PER_BYTE / (packet.source.baud or 9600))
        self._arrivals[key].add(len(packet.data), time)
        return Packet(
            packet.direction, packet.data, time, packet.offset, packet.comment, packet.source
        )

    def placed(self, time: float) -> float:
        """A packet's time in the replay, if that runs on as before."""
        return time + (self._shift or 0.0)

    def arrivals(self, source: Source, direction: Direction) -> Arrivals:
        """Those of one direction of a port, which has brought a packet."""
        return self._arrivals[source, direction]

    def _time(self, packet: Packet) -> float:
        found, recording = self._found, packet.source.recording
        if self._shift is None:
            found.begin, self._shift = packet.time, -packet.time
            found.baud = packet.source.baud or found.baud
        elif recording != self._recording:
            self._arrivals.clear()
            self._silences.without_supply(self.latest + AFTER, self.latest + PAUSE)
            self.began = self.latest + PAUSE
            self._shift = self.began - packet.time
        elif packet.time + self._shift < self.latest - _JUMP:
            self._shift = self.latest - packet.time
        else:
            time = packet.time + self._shift
            self._silences.passed(recording, self.latest, time, self._shift)
        self._recording = recording
        self.latest = max(self.latest, packet.time + self._shift)
        return self.latest
