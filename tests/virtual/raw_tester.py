"""The tester's end of a simulated wire, with nothing clever about it: bytes out, timed bytes in."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf

from mikas.framing import encode
from mikas.virtual.bus import Bus

BYTE = 10 / 9600
TURN = 0.002


@dataclass
class RawTester:
    """`heard`: every byte that came, with the time of its end."""

    bus: Bus
    now: float = 0.0
    heard: list[tuple[float, int]] = field(default_factory=list)

    def say(self, data: bytes, at: float | None = None) -> None:
        """Puts bytes on the wire, now or at a time that has not passed."""
        if at is not None:
            self.listen(at)
        self.bus.send(data, self.now)

    def ask(self, body: bytes) -> bytes:
        """The bytes that come after the echo of the request `body`, within half a second."""
        wire = encode(body)
        start = len(self.heard)
        self.say(wire)
        self.listen(self.now + len(wire) * BYTE + 0.5)
        came = bytes(value for _, value in self.heard[start:])
        assert came.startswith(wire)
        return came[len(wire) :]

    def listen(self, until: float) -> bytes:
        """Runs the wire to `until` event by event; returns what came."""
        start = len(self.heard)
        while (due := self.bus.next_event()) <= until:
            assert due < inf
            self._take(max(due, self.now))
        self._take(until)
        self.now = until
        return bytes(value for _, value in self.heard[start:])

    def _take(self, now: float) -> None:
        data, time = self.bus.collect_received(now)
        self.heard += [(time, value) for value in data]

    @property
    def data(self) -> bytes:
        return bytes(value for _, value in self.heard)

    @property
    def times(self) -> list[float]:
        return [time for time, _ in self.heard]
