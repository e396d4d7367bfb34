"""A served unit without requests: its engine runs on, so that no request waits for it."""

from __future__ import annotations

import heapq
import itertools

import pytest

from mikas.virtual import serve
from mikas.virtual.build import build_bus


class Loop:
    """An event loop on simulated time."""

    def __init__(self):
        self.now = 1000.0
        self._calls = []
        self._count = itertools.count()

    def call_later(self, delay, call):
        entry = (self.now + delay, next(self._count), call)
        heapq.heappush(self._calls, entry)
        return self.Handle(self._calls, entry)

    class Handle:
        def __init__(self, calls, entry):
            self._calls, self._entry = calls, entry

        def cancel(self):
            if self._entry in self._calls:
                self._calls.remove(self._entry)
                heapq.heapify(self._calls)

    def run(self, seconds):
        until = self.now + seconds
        while self._calls and self._calls[0][0] <= until:
            self.now, _, call = heapq.heappop(self._calls)
            call()
            yield
        self.now = until


@pytest.fixture
def loop(monkeypatch):
    loop = Loop()
    monkeypatch.setattr(serve.asyncio, "get_running_loop", lambda: loop)
    return loop


def test_the_engine_is_never_more_than_a_second_behind(loop):
    bus = build_bus({}, start=loop.now)
    engine = bus.ecu.responder.car.engine
    served = serve.ServedBus(bus, lambda: loop.now, write=print)
    served.advance()
    began = loop.now
    for _ in loop.run(60):
        assert loop.now - began - engine.time <= 1
    assert engine.time == pytest.approx(60, abs=1)
    served.stop()
    assert not list(loop.run(60))
