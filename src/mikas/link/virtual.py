"""`sim:` — a virtual unit in this process, on simulated time or in real time.

On the simulated clock `read` runs the bus forward until bytes arrive or the deadline passes: hours
take seconds, and the tester's own computing takes no time. In real time each `read` runs the same
bus forward to the present, and the waits are real.
"""

from __future__ import annotations

import threading
from contextlib import AbstractContextManager, nullcontext
from math import inf
from threading import Thread
from typing import Final
from weakref import WeakKeyDictionary, ref

from mikas.errors import usage_error
from mikas.i18n import Text
from mikas.link.base import CLOSED_HERE, Chunk, Link, link_lost
from mikas.link.clocks import AwakeClock, WallClock
from mikas.link.ports import VIRTUAL
from mikas.link.urls import take_clock
from mikas.options import check_names
from mikas.virtual.bus import Bus

_PERIOD: Final = 1.0  # s between two steps of an engine that no request reads


class BusLink(Link):
    """The common part of the links of both clocks."""

    is_virtual = True

    def __init__(self, bus: Bus, url: str) -> None:
        self.bus = bus
        self.url = url
        self.baud: int = bus.baud
        latency, stalls = bus.adapter.kind.latency, bus.adapter.stalls
        self.granularity: float = latency + (stalls.longest if stalls.every else 0.0)
        self._problem: Text | None = None
        self._gone = threading.Event()  # set with the problem

    @property
    def description(self) -> str:
        return VIRTUAL.en

    def write(self, data: bytes) -> None:
        self._check()
        self.bus.send(data, self.now())

    def set_baud(self, baud: int) -> bool:
        self._check()
        self.bus.set_baud(baud)
        self.baud = baud
        return True

    def held(self) -> AbstractContextManager[object]:
        """Return what keeps other threads from the bus while the car in it is read."""
        return nullcontext()

    def unplug(self) -> None:
        """Pull out the adapter, for tests."""
        self._problem = Text("it was unplugged", "он отключён")
        self._gone.set()

    def close(self) -> None:
        self._problem = self._problem or CLOSED_HERE
        self._gone.set()

    def _check(self) -> None:
        if self._problem:
            raise link_lost(self.url, self._problem, time=self.now())


class VirtualLink(BusLink):
    """A virtual unit on simulated time, which passes only during `read`."""

    is_simulated = True

    def __init__(self, bus: Bus, *, url: str = "sim:?clock=simulated", start: float = 0.0) -> None:
        super().__init__(bus, url)
        self._now = start

    def now(self) -> float:
        return self._now

    def read(self, deadline: float) -> Chunk:
        while True:
            self._check()
            following = self.bus.next_event()
            if following > self._now:
                if following > deadline or following == inf:
                    if deadline == inf:
                        raise ValueError("no byte will ever arrive, and the wait has no end")
                    self._now = max(self._now, deadline)
                    return Chunk(b"", self._now)
                self._now = following
            data, time = self.bus.collect_received(self._now)
            if data:
                return Chunk(data, time)

    def gather(self, until: float) -> None:
        if not self._problem:
            self._now = max(self._now, until)

    def pass_time(self, seconds: float) -> None:
        """Let time pass, also for a link that is closed or unplugged; for tests."""
        self._now += seconds

    def send_break(self, seconds: float) -> None:
        self._check()
        self.bus.send_break(seconds, self._now)
        self._now += seconds


class Follower:
    """A thread that keeps the engine of one bus up with the time, until nothing uses the bus.

    The engine runs when a datum is read, 2 ms for each second that has passed. After 25 minutes
    without a request (the dashboard is disconnected, a script does something else) the first would
    wait for 2.5 s. So it runs every second, as `mikas sim` does in its event loop.

    `lock`: held while the bus is used. `clock`: the same for all links of the bus.
    """

    def __init__(self, bus: Bus) -> None:
        self.lock: threading.Lock = threading.Lock()
        self.clock: WallClock = AwakeClock()
        self._bus = ref(bus)
        self.thread: Thread = threading.Thread(target=self._run, name="mikas-sim", daemon=True)
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


class RealTimeVirtualLink(BusLink):
    """A virtual unit in this process, in real time."""

    def __init__(self, bus: Bus, *, url: str = "sim:") -> None:
        super().__init__(bus, url)
        self._follower = follower_of(bus)

    def held(self) -> AbstractContextManager[object]:
        return self._follower.lock

    def now(self) -> float:
        return self._follower.clock.now()

    def write(self, data: bytes) -> None:
        with self._follower.lock:
            super().write(data)

    def read(self, deadline: float) -> Chunk:
        while True:
            self._check()
            with self._follower.lock:
                now = self.now()
                data, time = self.bus.collect_received(now)
                following = self.bus.next_event()
            if data:
                return Chunk(data, time)
            if now >= deadline:
                return Chunk(b"", now)
            # Wake up every second: a wait without end must notice that the link was closed.
            self._gone.wait(max(0.0, min(following, deadline, now + 1) - now))

    def gather(self, until: float) -> None:
        self._gone.wait(max(0.0, until - self.now()))

    def send_break(self, seconds: float) -> None:
        self._check()
        with self._follower.lock:
            self.bus.send_break(seconds, self.now())
        self._gone.wait(seconds)


def open_sim(url: str, options: dict[str, str]) -> Link:
    """Open `sim:?scenario=…&seed=…&clock=real|simulated&…`.

    `mikas.virtual.build` has the other options. Raises `BadPortUrl` for an unknown option or an
    invalid value, `CatalogError` for an invalid scenario file.
    """
    from mikas.virtual.build import SETTINGS, build_bus  # the engine, the catalog: for this only

    check_names(options, ("clock", *SETTINGS))
    settings = dict(options)
    simulated = take_clock(settings)
    if place := url.partition("?")[0].partition(":")[2].strip("/"):
        raise usage_error(
            f"sim: has no address, only options; “{place}” may be a ?scenario={place}",
            f"у sim: нет адреса, только параметры; может быть, ?scenario={place}",
        )
    start = 0.0 if simulated else WallClock().now()
    bus = build_bus(settings, start=start)
    return VirtualLink(bus, url=url) if simulated else RealTimeVirtualLink(bus, url=url)
