"""Fewer packets, the same bytes: a response that arrives byte by byte becomes one packet.

The wire brings 960 bytes a second (§1); a packet each would be 34 million in ten hours, 48 bytes of
file for every byte. Joined, there is about one packet a response, and no time that matters is lost:

- a reader takes a byte for `(later bytes in its packet) · byte time` older than its packet. The
  time of a joined packet makes this right for its first byte, hence for the response's begin: to
  half a byte time for the first response in a packet, to one for another. If later chunks show that
  the first one was seen late, the begin is corrected;
- a packet ends with the chunk that brings a terminator, also one in its middle: what was received
  whole may be shown at once, and is in the file before. Sent chunks are never joined.
"""

from __future__ import annotations

import threading
from typing import Final

from mikas.framing import TERMINATOR
from mikas.link.base import BITS_PER_BYTE, Direction
from mikas.recording.capture.notes import Note
from mikas.recording.capture.writer import CaptureWriter

_MOST_BYTES: Final = 4096
_LONGEST: Final = 1.0  # s
# In byte times:
_PAUSE: Final = 3  # inside a packet, between two chunks
_ALL_PAUSES: Final = 8  # inside a packet, in all: its end may seem earlier by so much
_CLOSE: Final = 0.5
_LATE: Final = 1.0  # of the first chunk at most, as later ones show


class Coalescer:
    """Stands between a `CaptureTee` and `sink`; implements `Sink` and takes notes.

    Waiting bytes are written when a frame ends in them, the direction changes, a note arrives, a
    chunk follows too late, and at `flush` and `tick`. Any thread may add a note.
    """

    def __init__(self, sink: CaptureWriter, *, baud: int = 9600) -> None:
        self._sink = sink
        self._byte_time = BITS_PER_BYTE / baud
        self._lock = threading.RLock()
        self._waiting = bytearray()
        self._first = 0.0  # time of the first waiting chunk
        self._last = 0.0
        self._begin = 0.0  # of its first byte on the wire
        self._seen_begin = 0.0  # the same by the first chunk alone
        self._joined = False  # whether more than one chunk is waiting

    def record(self, direction: Direction, data: bytes, time: float) -> None:
        """Write one chunk, perhaps later. Raises what `sink` raises, also for an earlier chunk."""
        with self._lock:
            if direction is Direction.SENT:
                self.flush()
                self._sink.record(direction, data, time)
                return
            if self._waiting and self._joins(data, time):
                self._joined = True
                # The first chunk was seen late: so many bytes can't have begun later than this.
                length = len(self._waiting) + len(data)
                self._begin = min(self._begin, time - length * self._byte_time)
            else:
                self.flush()
                self._first = time
                self._begin = self._seen_begin = time - len(data) * self._byte_time
            self._waiting += data
            self._last = time
            if _TERMINATOR in data or len(self._waiting) >= _MOST_BYTES:
                self.flush()

    def note(self, note: Note) -> None:
        """Write a note after the waiting bytes."""
        with self._lock:
            self.flush()
            self._sink.note(note)

    def tick(self, now: float) -> None:
        """Write bytes that have waited for a second by `now`, as on a silent line."""
        with self._lock:
            if now - self._first >= _LONGEST:
                self.flush()

    def flush(self) -> None:
        """Write the waiting bytes."""
        with self._lock:
            if not self._waiting:
                return
            data, time = bytes(self._waiting), self._last
            if self._joined:
                # Never later than the last chunk: the next packet must not seem to be older.
                time = min(time, self._begin + len(data) * self._byte_time)
            self._waiting.clear()
            self._joined = False
            self._sink.record(Direction.RECEIVED, data, time)

    def _joins(self, data: bytes, time: float) -> bool:
        length = len(self._waiting) + len(data)
        if length > _MOST_BYTES or time - self._first > _LONGEST:
            return False
        pause = (time - self._last) / self._byte_time - len(data)
        # When the packet would begin by the time of this chunk, in byte times after its begin as
        # the first chunk showed it.
        begin = (time - self._seen_begin) / self._byte_time - length
        earliest, latest = -_LATE, float(_ALL_PAUSES)
        if data.find(_TERMINATOR, 0, len(data) - 1) >= 0:
            # Another frame begins here; its time must be right, by the begin that will be written.
            written = (self._begin - self._seen_begin) / self._byte_time
            earliest, latest = max(earliest, written - _CLOSE), written + _CLOSE
        return pause <= _PAUSE and earliest <= begin <= latest


_TERMINATOR: Final = bytes([TERMINATOR])
