"""The values of an exchange: time-outs (D14), frames and responses with times, statistics."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from math import inf

from mikas.errors import LineError
from mikas.framing import Damage, Decoder, Frame
from mikas.i18n import Text
from mikas.link import Chunk

_FAILURES_KEPT = 20


@dataclass(frozen=True, slots=True)
class Timing:
    """Time-outs in seconds (D14).

    `response_timeout`: from the end of a request to its response. `inter_byte_timeout`: silence
    inside a response after which the rest is given up. `idle_time`: silence that counts as a quiet
    line when no response is pending. `stream_gap`: silence that counts as the gap between two
    responses of a stream (D12). `max_busy_time`: the longest wait for a busy line to go quiet.
    """

    response_timeout: float = 0.5
    inter_byte_timeout: float = 0.2
    idle_time: float = 0.06
    stream_gap: float = 0.02
    max_busy_time: float = 1.0

    @property
    def late(self) -> float:
        """The time from the end of a request after which no response arrives any more (D13)."""
        return 2 * self.response_timeout


@dataclass(frozen=True, slots=True)
class Reply:
    """A response: its body, the bytes on the wire, and the link's time of its start and end."""

    body: bytes
    wire: bytes
    began: float
    ended: float


@dataclass(frozen=True, slots=True)
class Failure:
    """A failed exchange: the content of its `LineError`, without the stack. `code`: its class."""

    code: str
    reason: Text
    request: bytes | None
    received: bytes | None
    time: float | None


@dataclass(slots=True)
class Statistics:
    """Counts since the start of the connection."""

    requests: int = 0
    repeated: int = 0
    failed: int = 0
    failures: deque[Failure] = field(default_factory=lambda: deque(maxlen=_FAILURES_KEPT))
    """The latest failures, including those before a successful repetition."""

    def fail(self, error: LineError) -> None:
        """Count `error`."""
        self.failed += 1
        code = type(error).__name__
        self.failures.append(Failure(code, error.reason, error.request, error.received, error.time))


class TimedDecoder:
    """A `Decoder` that also returns the time when each frame began on the wire.

    A chunk's time is that of its last byte, or later, for adapters hand bytes over in lumps. A
    frame that began `n` bytes before a chunk's end began at most at the chunk's time minus `n` byte
    times; the earliest result of all its chunks is the best. If chunks arrive late and then at
    once, a frame could seem to begin before the previous one: it counts as one byte time later.
    """

    def __init__(self, decoder: Decoder, byte_time: float) -> None:
        self._decoder = decoder
        self._byte_time = byte_time
        # Of each chunk with unfinished bytes: its end, and the time of byte 0 according to it.
        self._chunks: deque[tuple[int, float]] = deque()
        self._latest = -inf  # when the previous frame began

    @property
    def pending(self) -> bytes:
        """The bytes of an unfinished frame."""
        return self._decoder.pending

    @property
    def noise(self) -> int:
        """The bare terminators skipped (D5)."""
        return self._decoder.noise

    def feed(self, chunk: Chunk) -> list[tuple[Frame | Damage, float]]:
        """Decode `chunk`; return what it completes, each with the time of its first byte."""
        end = self._decoder.offset + len(chunk.data)
        self._chunks.append((end, chunk.time - end * self._byte_time))
        events = [(event, self._began(event.offset)) for event in self._decoder.feed(chunk.data)]
        begun = end - len(self._decoder.pending)
        while self._chunks and self._chunks[0][0] <= begun:
            self._chunks.popleft()
        return events

    def _began(self, offset: int) -> float:
        zero = min(zero for end, zero in self._chunks if end > offset)
        began = zero + offset * self._byte_time
        if began <= self._latest:
            began = self._latest + self._byte_time
        self._latest = began
        return began
