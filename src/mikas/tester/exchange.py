"""Time-outs (D14), a response with its times, and the statistics of all exchanges."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

from mikas.errors import LineError
from mikas.i18n import Text

_FAILURES_KEPT = 20


@dataclass(frozen=True, slots=True)
class Timing:
    """Time-outs in seconds (D14).

    `response_timeout`: from the end of a request to its response. `inter_byte_timeout`: silence
    inside a response after which the rest is given up. `idle_time`: silence that counts as a quiet
    line when no response is pending. `max_busy_time`: the longest wait for a busy line to go quiet.
    """

    response_timeout: float = 0.5
    inter_byte_timeout: float = 0.02
    idle_time: float = 0.06
    max_busy_time: float = 1.0

    @property
    def late(self) -> float:
        """From the end of a request: when a response that has not come no longer comes (D13)."""
        return 2 * self.response_timeout


@dataclass(frozen=True, slots=True)
class Reply:
    """A response: its body, the bytes on the wire, and the link's time of its begin and end."""

    body: bytes
    wire: bytes
    began: float
    ended: float


@dataclass(frozen=True, slots=True)
class Failure:
    """A failed exchange: the content of its `LineError`, without the stack."""

    code: str
    reason: Text
    request: bytes | None
    received: bytes | None
    time: float | None

    @classmethod
    def of(cls, error: LineError) -> Failure:
        """Of the error, which is named by its class."""
        return cls(type(error).__name__, error.reason, error.request, error.received, error.time)


@dataclass(slots=True)
class Statistics:
    """Counts since the connection began."""

    requests: int = 0
    repeated: int = 0
    failed: int = 0
    failures: deque[Failure] = field(default_factory=lambda: deque(maxlen=_FAILURES_KEPT))
    """The latest of them, including those that a repetition cured."""

    def fail(self, error: LineError) -> None:
        """Count one."""
        self.failed += 1
        self.failures.append(Failure.of(error))
