"""What happened on the line so far: counts, and the latest failures to look back at."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

from mikas.errors import LineError
from mikas.i18n import Text

_FAILURES_KEPT = 20


@dataclass(frozen=True, slots=True)
class Failure:
    """A spoilt exchange to look back at: what a `LineError` told, without the stack it kept."""

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
    """What happened on the line so far."""

    requests: int = 0
    repeated: int = 0
    failed: int = 0
    failures: deque[Failure] = field(default_factory=lambda: deque(maxlen=_FAILURES_KEPT))
    """The latest of them, those that a repetition cured included."""

    def fail(self, error: LineError) -> None:
        """Count one."""
        self.failed += 1
        self.failures.append(Failure.of(error))
