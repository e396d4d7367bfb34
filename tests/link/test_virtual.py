"""The contract over a virtual unit's link, on simulated time and in real time."""

from __future__ import annotations

import threading
from collections import deque
from math import inf
from types import SimpleNamespace

import pytest

from mikas.errors import LinkLost
from mikas.framing import encode
from mikas.link.virtual import RealTimeVirtualLink, VirtualLink
from mikas.testing.links import FAR, LinkContract, RealTimeContract, Rig
from mikas.virtual.bus import Adapter, AdapterKind
from virtual_harness import make_bus


class PlainBus:
    """A wire without a unit: bytes sent are kept, bytes from the test arrive."""

    def __init__(self) -> None:
        car = SimpleNamespace(engine_speed=lambda now: 0.0)  # a link's follower asks each second
        self.ecu = SimpleNamespace(baud=9600, responder=SimpleNamespace(car=car))
        self.adapter = Adapter(AdapterKind())
        self.baud = 9600
        self.sent = b""
        self.breaks: list[float] = []
        self._coming: deque[tuple[float, bytes]] = deque()
        self._lock = threading.Lock()

    def say(self, data: bytes, time: float) -> None:
        with self._lock:
            self._coming.append((time, data))

    def send(self, data: bytes, now: float) -> None:
        self.sent += data

    def send_break(self, seconds: float, now: float) -> None:
        self.breaks.append(seconds)

    def set_baud(self, baud: int) -> None:
        self.baud = baud

    def advance(self, now: float) -> None:
        pass

    def next_event(self) -> float:
        with self._lock:
            return self._coming[0][0] if self._coming else inf

    def collect_received(self, now: float) -> tuple[bytes, float]:
        data, time = b"", now
        with self._lock:
            while self._coming and self._coming[0][0] <= now:
                time, piece = self._coming.popleft()
                data += piece
        return data, time


class BusPeer:
    """Lets bytes arrive `delay` seconds from now."""

    def __init__(self, link: VirtualLink | RealTimeVirtualLink, delay: float) -> None:
        self.link = link
        self.delay = delay

    def send(self, data: bytes) -> None:
        self.link.bus.say(data, self.link.now() + self.delay)

    def received(self, count: int) -> bytes:
        sent, self.link.bus.sent = self.link.bus.sent, b""
        assert len(sent) == count
        return sent

    def vanish(self) -> None:
        self.link.unplug()


class TestSimulated(LinkContract):
    can_set_baud = True

    @pytest.fixture
    def rig(self):
        with VirtualLink(PlainBus()) as link:
            yield Rig(link, BusPeer(link, 0.003))

    def let_time_pass(self, link):
        link.gather(link.now() + 0.01)

    def test_waiting_takes_no_time_at_all(self, rig):
        began = rig.link.now()
        assert rig.link.read(began + 1e6).data == b""
        assert rig.link.now() == began + 1e6

    def test_it_stops_at_the_first_arrival(self, rig):
        rig.link.bus.say(b"a", 5.0)
        rig.link.bus.say(b"b", 6.0)
        assert rig.link.read(9.0) == (b"a", 5.0)
        assert rig.link.now() == 5.0
        assert rig.link.read(9.0) == (b"b", 6.0)
        assert rig.link.read(9.0) == (b"", 9.0)

    def test_an_endless_wait_for_nothing_is_a_mistake(self, rig):
        with pytest.raises(ValueError, match="no end"):
            rig.link.read(inf)

    def test_a_break_reaches_the_wire(self, rig):
        rig.link.send_break(0.05)
        assert rig.link.bus.breaks == [0.05]


@pytest.mark.realtime
class TestRealTime(RealTimeContract):
    can_set_baud = True

    @pytest.fixture
    def rig(self):
        with RealTimeVirtualLink(PlainBus()) as link:
            yield Rig(link, BusPeer(link, 0.0))


@pytest.mark.parametrize(
    "kind", [AdapterKind(), AdapterKind(echo=False), AdapterKind(latency=0.016)]
)
def test_a_unit_behind_it_answers_at_the_wires_pace(kind):
    link = VirtualLink(make_bus(adapter=kind))
    link.write(encode(b"\x01"))
    came = []
    while (chunk := link.read(1.0)).data:
        came.append(chunk)
    data = b"".join(chunk.data for chunk in came)
    assert data == (encode(b"\x01") if kind.echo else b"") + encode(b"\x0a")
    assert came[-1].time == pytest.approx(6 * link.byte_time + 0.002, abs=kind.latency + 1e-9)
    assert [chunk.time for chunk in came] == sorted(chunk.time for chunk in came)
    assert (len(came) < len(data)) is (kind.latency > 0)
    assert link.now() == 1.0


def test_a_break_takes_the_response_off_the_wire():
    link = VirtualLink(make_bus(adapter=AdapterKind(echo=False)))
    link.write(encode(b"\x01"))
    assert link.read(3.5 * link.byte_time).data == b""
    link.send_break(0.05)
    assert link.read(link.now() + 1).data == b""


def test_unplugged_in_the_middle_of_a_response_it_is_lost():
    link = VirtualLink(make_bus())
    link.write(encode(b"\x01"))
    link.read(FAR)
    link.unplug()
    with pytest.raises(LinkLost):
        link.read(FAR)
