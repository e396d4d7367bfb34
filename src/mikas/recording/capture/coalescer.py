"""Fewer packets, the same bytes: a response that comes byte by byte becomes one packet.

A wire hands over 960 bytes a second (§1); a packet each would be 34 million in ten hours, at 48
bytes of file for every byte. Joined, there is about one a response. What is joined has no gap worth
the name in it, so that nothing is lost that anybody measures:

- a reader takes a byte for `(bytes behind it in its packet) · byte time` older than its packet. A
  joined packet has the time that makes this right for the packet's first byte, hence for the
  response's begin: to half a byte time for the first response in a packet, to one for another, or
  better: where later chunks show that the first was seen late, the begin is put right;
- a packet ends with the chunk that brings a terminator, so it waits for nothing but the rest of
  its own frame. Sent chunks are never joined.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Final, Protocol, Self

from mikas.framing import TERMINATOR
from mikas.link.base import BITS_PER_BYTE
from mikas.link.tee import Direction, Sink
from mikas.recording.capture.notes import Note, NoteSink

if TYPE_CHECKING:
    from types import TracebackType

_MOST_BYTES: Final = 4096
_LONGEST: Final = 1.0  # s
# In byte times:
_PAUSE: Final = 3  # inside a packet, between two chunks
_ALL_PAUSES: Final = 8  # inside a packet, in all: its end may seem earlier by so much
_CLOSE: Final = 0.5
_LATE: Final = 1.0  # how late the first chunk may have been seen, as later ones show


class NotedSink(Sink, NoteSink, Protocol):
    """A sink that takes notes too, as `CaptureWriter` does."""


class Coalescer:
    """Stands between a `CaptureTee` and `sink`; implements `Sink` and takes notes.

    What waits is written when its frame ends, the direction changes, a note comes, a chunk follows
    too late, or at `flush`, `tick` and `close`. Closing it does not close `sink`. Any thread may
    add a note.
    """

    def __init__(self, sink: NotedSink, *, baud: int = 9600) -> None:
        self._sink = sink
        self._byte_time = BITS_PER_BYTE / baud
        self._lock = threading.RLock()
        self._waiting = bytearray()
        self._first = 0.0  # when the first waiting chunk came
        self._last = 0.0
        self._begin = 0.0  # when its first byte began on the wire
        self._seen = 0.0  # what the first chunk by itself said of that
        self._joined = False  # whether more than one chunk is waiting

    def record(self, direction: Direction, data: bytes, time: float) -> None:
        """Keep one chunk, soon. What `sink` raises comes through, at times for an earlier chunk."""
        with self._lock:
            if direction is Direction.SENT:
                self.flush()
                self._sink.record(direction, data, time)
                return
            if self._waiting and self._joins(data, time):
                self._joined = True
                # The first was seen late: so many bytes can't have begun later than this.
                length = len(self._waiting) + len(data)
                self._begin = min(self._begin, time - length * self._byte_time)
            else:
                self.flush()
                self._first = time
                self._begin = self._seen = time - len(data) * self._byte_time
            self._waiting += data
            self._last = time
            if data.endswith(_TERMINATOR) or len(self._waiting) >= _MOST_BYTES:
                self.flush()

    def note(self, note: Note) -> None:
        """Keep a note, behind what came before it."""
        with self._lock:
            self.flush()
            self._sink.note(note)

    def tick(self, now: float) -> None:
        """Write what has waited for a second by `now`; for whoever watches a silent line."""
        with self._lock:
            if now - self._first >= _LONGEST:
                self.flush()

    def flush(self) -> None:
        """Write what is waiting."""
        with self._lock:
            if not self._waiting:
                return
            data, time = bytes(self._waiting), self._last
            if self._joined:
                # Never later than it was: the next packet must not seem to come before this one.
                time = min(time, self._begin + len(data) * self._byte_time)
            self._waiting.clear()
            self._joined = False
            self._sink.record(Direction.RECEIVED, data, time)

    def close(self) -> None:
        """Write what is waiting; the sink stays its maker's."""
        self.flush()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def _joins(self, data: bytes, time: float) -> bool:
        length = len(self._waiting) + len(data)
        if length > _MOST_BYTES or time - self._first > _LONGEST:
            return False
        pause = (time - self._last) / self._byte_time - len(data)
        # How much later the packet would have to begin for this chunk's bytes to be in their place.
        late = (time - self._seen) / self._byte_time - length
        if _TERMINATOR in self._waiting or data.find(_TERMINATOR, 0, len(data) - 1) >= 0:
            early, most = _CLOSE, _CLOSE  # another begins in here, and has to begin in its place
        else:
            early, most = _LATE, _ALL_PAUSES
        return pause <= _PAUSE and -early <= late <= most


_TERMINATOR: Final = bytes([TERMINATOR])
