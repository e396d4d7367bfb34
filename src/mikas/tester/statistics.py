"""Statistics of the line: counts, and the latest failed exchanges."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

from mikas.errors import LineError
from mikas.i18n import Text

_FAILURES_KEPT = 20


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
