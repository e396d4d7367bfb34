"""Recordings that stay open, so that scrolling does not read them each time: few, and not for long.

Ten hours take some 170 MB, a hundred ten times as much. So only the one that was used last may take
more than `MOST_BYTES`, and none stays open that was not used for `IDLE` seconds. Freed memory
goes back to the system.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

from mikas.recording.recording import Recording

_MOST: Final = 2
MOST_BYTES: Final = 1 << 29
IDLE: Final = 60.0


@dataclass(frozen=True, slots=True)
class OpenRecording:
    """`stamp`: of its file when it was read, at the time `at`; `used`: the last time."""

    stamp: tuple[int, int, int]
    at: float
    recording: Recording
    used: float = 0.0


class OpenRecordings:
    """The open recordings by id, the latest used last. `clock`: seconds that never run back.

    Any thread may call.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._open: dict[str, OpenRecording] = {}
        self._lock = threading.Lock()

    def __len__(self) -> int:
        return len(self._open)

    def pop(self, identity: str) -> OpenRecording | None:
        """Take one out, to use it or to replace it."""
        with self._lock:
            return self._open.pop(identity, None)

    def put(self, identity: str, opened: OpenRecording) -> None:
        """Keep one, as the latest used; others may be closed for it."""
        with self._lock:
            self._open[identity] = replace(opened, used=self._clock())
        self.close_some()

    def close_some(self) -> None:
        """Close those that were not used for long, and the oldest of too many or too large ones."""
        with self._lock:
            since = self._clock() - IDLE
            for identity in [name for name, it in self._open.items() if it.used <= since]:
                del self._open[identity]
            while len(self._open) > 1 and (len(self._open) > _MOST or self._held > MOST_BYTES):
                del self._open[next(iter(self._open))]

    def clear(self) -> None:
        """Close all."""
        with self._lock:
            self._open.clear()

    @property
    def _held(self) -> int:
        return sum(it.recording.held for it in self._open.values())
