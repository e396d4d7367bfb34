"""Keeps the engine of a virtual unit in this process up with the time.

The engine runs when a datum is read, 2 ms for each second that has passed. After 25 minutes without
a request (the dashboard is disconnected, a script does something else) the first would wait for
2.5 s. So a thread runs the engine every second, as `mikas sim` does in its event loop.
"""

from __future__ import annotations

import threading
from typing import Final
from weakref import WeakKeyDictionary, ref

from mikas.link.base import WallClock
from mikas.virtual.bus import Bus

_PERIOD = 1.0  # s


class Follower:
    """The thread of one bus; ends when no link and no other part uses the bus any more.

    `lock`: held while the bus is used. `clock`: the same for all links of the bus.
    """

    def __init__(self, bus: Bus) -> None:
        self.lock = threading.Lock()
        self.clock = WallClock()
        self._bus = ref(bus)
        self.thread = threading.Thread(target=self._run, name="mikas-sim", daemon=True)
        self.thread.start()

    def _run(self) -> None:
        pause = threading.Event()
        while not pause.wait(_PERIOD) and self._step():
            pass

    def _step(self) -> bool:
        bus = self._bus()
        if bus is None:
            return False
        with self.lock:
            bus.ecu.responder.car.engine_speed(self.clock.now())
        return True


_FOLLOWERS: Final[WeakKeyDictionary[Bus, Follower]] = WeakKeyDictionary()


def follower_of(bus: Bus) -> Follower:
    """Return the follower of `bus`, which starts with the first link."""
    if (follower := _FOLLOWERS.get(bus)) is None:
        follower = _FOLLOWERS[bus] = Follower(bus)
    return follower
