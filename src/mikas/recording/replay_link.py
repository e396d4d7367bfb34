"""`replay:` as a link: the wire of a virtual unit, until the recording is over.

A unit that falls silent is waited for; a recording that has ended is not. A wire has no words for
that, a port in this process has: `RecordingOver`. After a `seek` it goes on.
"""

from __future__ import annotations

from mikas.errors import RecordingOver
from mikas.link.virtual import RealTimeVirtualLink, VirtualLink
from mikas.recording.replay_car import ReplayCar
from mikas.virtual.bus import Bus


class ReplayLink(VirtualLink):
    """On simulated time. `file`: as the user wrote it."""

    def __init__(self, bus: Bus, *, url: str, start: float, file: str) -> None:
        super().__init__(bus, url=url, start=start)
        self._file = file

    def _check(self) -> None:
        super()._check()
        _raise_if_over(self.bus, self._file, self.now())


class RealTimeReplayLink(RealTimeVirtualLink):
    """In real time. `file`: as the user wrote it."""

    def __init__(self, bus: Bus, *, url: str, file: str) -> None:
        super().__init__(bus, url=url)
        self._file = file

    def _check(self) -> None:
        super()._check()
        _raise_if_over(self.bus, self._file, self.now())


def _raise_if_over(bus: Bus, file: str, now: float) -> None:
    car = bus.ecu.responder.car
    if isinstance(car, ReplayCar) and car.is_over(now):
        car.look(now)
        raise RecordingOver(file=file, time=now)
