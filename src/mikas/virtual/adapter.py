"""The virtual K-Line adapter (D1).

Echo or no echo; bytes delivered at once or in lumps by a USB latency timer (FT232: 16 ms by
default, 62 bytes a packet); a supply that may be missing.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import ceil, inf

PACKET = 62  # bytes that an FT232 delivers without waiting for its timer


@dataclass(frozen=True, slots=True)
class AdapterKind:
    """The adapter's properties. `latency` in seconds: 0 delivers every byte at once."""

    echo: bool = True
    latency: float = 0.0
    supplied: bool = True  # False: no 12 V, so neither the wire nor an echo comes through


class Adapter:
    """The receiving half of an adapter, on its owner's clock: bytes in from the wire, lumps out."""

    def __init__(self, kind: AdapterKind) -> None:
        self.kind = kind
        self._held = bytearray()
        self._ready: deque[tuple[float, bytes]] = deque()
        self._tick_at = inf  # when the latency timer runs out, if something waits for it

    def hear(self, value: int, time: float) -> None:
        """Receive a byte of the wire that ended at `time`."""
        if not self.kind.latency:
            self._ready.append((time, bytes([value])))
            return
        self.tick(time)
        self._held.append(value)
        if len(self._held) >= PACKET:
            self._hand_over(time)
        elif len(self._held) == 1:
            # The timer runs on whether or not there is anything to hand over.
            self._tick_at = max(time, ceil(time / self.kind.latency) * self.kind.latency)

    def tick(self, now: float) -> None:
        """Let the latency timer run out if it is due by `now`."""
        if self._held and self._tick_at <= now:
            self._hand_over(self._tick_at)

    def _hand_over(self, time: float) -> None:
        self._ready.append((time, bytes(self._held)))
        self._held.clear()
        self._tick_at = inf

    def next_event(self) -> float:
        """Return when the tester gets the next known bytes."""
        return self._ready[0][0] if self._ready else self._tick_at

    def take(self, now: float) -> tuple[bytes, float]:
        """Return the bytes that the tester got by `now`, and the time of the last."""
        self.tick(now)
        data, time = bytearray(), now
        while self._ready and self._ready[0][0] <= now:
            time, lump = self._ready.popleft()
            data += lump
        return bytes(data), time
