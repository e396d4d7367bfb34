"""A virtual unit in this process that no tester reads: its engine keeps up with the time."""

from __future__ import annotations

import gc
import threading

import pytest

from mikas.link import virtual
from mikas.link.clocks import AwakeClock
from mikas.link.virtual import RealTimeVirtualLink
from mikas.virtual.build import build_bus


@pytest.fixture
def seen(monkeypatch):
    """An event, set after 20 s of a clock that runs a second ahead at each look."""
    event = threading.Event()

    class Clock:
        time = 0.0

        def now(self) -> float:
            self.time += 1
            if self.time > 20:
                event.set()
            return self.time

    monkeypatch.setattr(virtual, "AwakeClock", Clock)
    monkeypatch.setattr(virtual, "_PERIOD", 0.0)
    return event


def test_the_engine_runs_without_a_link_as_long_as_the_car_is_kept(seen, begun):
    bus = build_bus({})
    link = RealTimeVirtualLink(bus)
    link.close()
    assert seen.wait(30)
    assert bus.ecu.responder.car.engine.time > 18
    (thread,) = begun
    RealTimeVirtualLink(bus)
    assert begun == [thread]  # one clock, one thread
    del bus, link
    gc.collect()
    thread.join(30)
    assert not thread.is_alive()


def test_a_virtual_car_catches_up_no_night_of_sleep() -> None:
    steady = [0.0]
    clock = AwakeClock(lambda: steady[0])
    began = clock.now()
    for steady[0], expected in ((1.0, 1.0), (2.0, 2.0), (43_202.0, 602.0), (43_203.0, 603.0)):
        assert clock.now() - began == pytest.approx(expected, abs=1e-3)
