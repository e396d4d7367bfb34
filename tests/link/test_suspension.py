"""What came while the program did not run is dropped; what is only slow or late is not."""

from __future__ import annotations

import socket
import time
from contextlib import closing
from math import inf
from types import SimpleNamespace
from typing import Any

import pytest

from mikas.browser import web_serial
from mikas.browser.web_serial import WebSerialLink
from mikas.errors import LinkLost, ReadingSuspended
from mikas.i18n import Text
from mikas.link import CaptureTee, Chunk, Link, open_link
from mikas.link.base import NETWORK, LinkWrapper
from mikas.link.clocks import WallClock, _steady
from mikas.link.flood import FloodGuard
from mikas.link.reconnecting import ReconnectingPort
from mikas.link.suspension import LATE, WAIT, SuspensionGuard

BACKLOG = b"\x55" * 4096


class Port(Link):
    """A port on simulated time: bytes wait in it until they are read; `late`: of each wait."""

    url = "test:"

    def __init__(self, *arrivals: tuple[float, bytes]) -> None:
        self.time, self.late, self.lost = 1000.0, 0.0, False
        self.arrivals = [(self.time + after, data) for after, data in arrivals]
        self.written: list[bytes] = []
        self.reads = 0

    def now(self) -> float:
        return self.time

    def sleep(self, until: float) -> None:
        self.time = max(self.time, until) + self.late
        self.late = 0.0

    def read(self, deadline: float) -> Chunk:
        if self.lost:
            raise LinkLost(url=self.url, problem=Text("gone", "пропал"), time=self.time)
        self.reads += 1
        first = min((time for time, _ in self.arrivals), default=inf)
        if first > self.time:
            self.sleep(min(first, deadline))
        data = b"".join(data for time, data in self.arrivals if time <= self.time)
        self.arrivals = [each for each in self.arrivals if each[0] > self.time]
        return Chunk(data[:4095], self._keep(data[4095:]))

    def _keep(self, rest: bytes) -> float:
        if rest:
            self.arrivals.insert(0, (self.time, rest))
        return self.time

    def write(self, data: bytes) -> None:
        self.written.append(data)
        self.sleep(self.time)

    def gather(self, until: float) -> None:
        self.sleep(until)

    def send_break(self, seconds: float) -> None:
        self.sleep(self.time + seconds)

    def close(self) -> None:
        pass


def guarded(*arrivals: tuple[float, bytes]) -> tuple[Port, SuspensionGuard]:
    port = Port(*arrivals)
    guard = SuspensionGuard(port)
    guard.read(port.time)  # from here on
    return port, guard


def dropped(guard: SuspensionGuard, wait: float = 0.5) -> ReadingSuspended:
    with pytest.raises(ReadingSuspended) as caught:
        guard.read(guard.now() + wait)
    return caught.value


def stop_in_a_wait(port: Port, guard: SuspensionGuard) -> None:
    port.late = 30.0


def stop_between(port: Port, guard: SuspensionGuard) -> None:
    port.time += 30.0


def stop_while_gathering(port: Port, guard: SuspensionGuard) -> None:
    port.late = 30.0
    guard.gather(port.time + 0.03)


def stop_in_a_write(port: Port, guard: SuspensionGuard) -> None:
    port.late = 30.0
    guard.write(b"\x01\xff\r")


def stop_in_a_break(port: Port, guard: SuspensionGuard) -> None:
    port.late = 30.0
    guard.send_break(0.05)


STOPS = [stop_in_a_wait, stop_between, stop_while_gathering, stop_in_a_write, stop_in_a_break]


@pytest.mark.parametrize("stop", STOPS)
def test_what_came_while_the_program_stood_is_dropped_and_the_time_said(stop):
    port, guard = guarded((5.0, b"old"), (29.0, BACKLOG), (32.0, b"new"))
    stop(port, guard)
    error = dropped(guard)
    assert error.fields["seconds"] == pytest.approx(30, abs=WAIT)
    assert error.received == BACKLOG[-16:]
    assert "30." in str(error)
    assert guard.read(port.time + 5).data == b"new"


@pytest.mark.parametrize("stop", STOPS)
def test_a_stop_without_bytes_is_said_too(stop):
    port, guard = guarded((32.0, b"new"))
    stop(port, guard)
    assert dropped(guard).received == b""
    assert guard.read(port.time + 5).data == b"new"


def test_more_than_the_system_gives_at_once_is_dropped_to_its_end():
    port, guard = guarded((1.0, BACKLOG * 8))  # 30 s of a stream
    port.time += 30
    dropped(guard)
    assert not guard.read(port.time).data


def test_what_still_flows_from_a_thread_or_a_network_is_dropped_too():
    pieces = [(30.0 + 0.01 * number, bytes(50)) for number in range(30)]
    port, guard = guarded(*pieces, (32.0, b"new"))
    port.time += 30
    dropped(guard)
    assert guard.read(port.time + 5).data == b"new"


def test_the_line_itself_is_not_dropped_when_the_backlog_has_ended():
    line = [(30.0 + number / 960, b"x") for number in range(960)]
    port, guard = guarded((1.0, BACKLOG), *line)
    port.time += 30
    dropped(guard)
    kept = 0
    while data := guard.read(port.time + 0.01).data:
        kept += len(data)
    assert 800 < kept < 960


def test_a_flood_does_not_keep_it_dropping():
    class Flood(Port):
        def read(self, deadline: float) -> Chunk:
            self.time += 0.001
            return Chunk(bytes(100), self.time)

    port = Flood()
    guard = SuspensionGuard(port)
    guard.read(port.time)
    port.time += 30
    began = port.time
    dropped(guard)
    assert port.time < began + 3
    assert guard.read(port.time).data  # which is the business of the guard against floods


def test_a_link_through_a_network_is_waited_for_longer():
    port, guard = guarded((30.15, b"late"), (32.0, b"new"))
    guard.granularity = NETWORK
    port.time += 30
    assert dropped(guard).received == b"late"


@pytest.mark.parametrize("late", [0.0, 0.2, LATE - 0.01])
def test_a_busy_computer_loses_nothing(late):
    port, guard = guarded(*[(0.1 * number, b"x") for number in range(100)])
    got = b""
    while len(got) < 99:
        port.late = late
        got += guard.read(port.time + 1).data
        port.time += late
    assert got == b"x" * 99


def test_a_long_silence_and_a_long_gathering_are_no_stops():
    port, guard = guarded((60.0, b"new"), (61.5, b"more"))
    assert guard.read(port.time + 100).data == b"new"
    guard.gather(port.time + 1.6)
    assert guard.read(port.time).data == b"more"
    guard.send_break(1.0)
    port.late = 0.5
    guard.write(bytes(524))  # as long as the line needs for it
    assert not guard.read(port.time).data


def test_a_wait_without_end_is_one_wait():
    port, guard = guarded((60.0, b"new"))
    reads = port.reads
    assert guard.read(inf).data == b"new"
    assert port.reads == reads + 1


def test_the_time_before_the_first_use_is_listened_to():
    port = Port((1.0, b"heard"))
    guard = SuspensionGuard(port)
    port.time += 30  # the program was loaded
    assert guard.read(port.time).data == b"heard"


def test_nothing_is_sent_after_a_stop():
    port, guard = guarded()
    port.time += 30
    with pytest.raises(ReadingSuspended):
        guard.write(b"\x62\x0e\x08")
    assert port.written == []
    guard.write(b"\x01")
    assert port.written == [b"\x01"]


def test_who_only_looks_is_not_kept_waiting():
    port, guard = guarded()
    port.time += 30
    began, reads = port.time, port.reads
    with pytest.raises(ReadingSuspended):
        guard.read(port.time)
    assert (port.time, port.reads) == (began, reads + 1)


def test_a_lost_port_is_lost():
    port, guard = guarded()
    port.time += 30
    port.lost = True
    with pytest.raises(LinkLost):
        guard.read(port.time + 1)


def test_what_is_dropped_is_not_recorded():
    class Sink:
        data = b""

        def record(self, direction: object, data: bytes, time: float) -> None:
            self.data += data

    port, guard = guarded((1.0, b"old"), (32.0, b"new"))
    tee = CaptureTee(guard, sink := Sink())
    port.time += 30
    with pytest.raises(ReadingSuspended):
        tee.read(port.time + 0.1)
    tee.read(port.time + 5)
    assert sink.data == b"new"


def test_every_port_is_guarded_inside_the_guard_against_floods_which_does_not_see_the_backlog():
    with closing(socket.create_server(("127.0.0.1", 0))) as server:
        link = open_link(f"socket://127.0.0.1:{server.getsockname()[1]}")
        link.close()
        assert isinstance(link, FloodGuard)
        assert isinstance(link.link, SuspensionGuard)


def test_a_virtual_unit_is_guarded_where_it_is_sampled():
    with ReconnectingPort("sim:").open() as link:
        assert isinstance(link, LinkWrapper)
        assert isinstance(link.link, SuspensionGuard)


def test_a_virtual_unit_on_a_busy_computer_loses_nothing_as_its_bytes_keep_their_times():
    port = Port((0.1, b"x"))
    with ReconnectingPort("sim:", open_port=lambda _: port).open() as link:
        assert not isinstance(link, SuspensionGuard)
    port.is_virtual = True
    with ReconnectingPort("sim:", open_port=lambda _: port).open() as link:
        link.read(port.time)
        port.late = 1.5
        assert link.read(port.time + 0.5).data == b"x"
        port.late = 2.5
        with pytest.raises(ReadingSuspended):
            link.read(port.time + 0.5)


def test_a_frozen_tab_leaves_out_what_the_browser_kept(monkeypatch):
    port = FrozenPage((10.0, b"old"), (32.0, b"new"))
    monkeypatch.setattr(web_serial, "_host", lambda: (SimpleNamespace(now=port.now), port.suspend))
    link = SuspensionGuard(WebSerialLink("webserial:", port, baud=9600, about="FT232"))
    link.read(port.time)
    port.late = 30.0
    assert dropped(link).received == b"old"
    assert link.read(port.time + 5).data == b"new"


class FrozenPage(Port):
    """JavaScript's half of a Web Serial port (`serial.ts`), which stands as Python does."""

    lost, takenAt = "", 0.0  # noqa: N815
    arrival = gathering = lambda self, until: SimpleNamespace(promise=until)
    suspend = Port.sleep

    def take(self) -> Any | None:
        data, self.takenAt = Port.read(self, self.time)
        return SimpleNamespace(to_bytes=lambda: data) if data else None


def test_the_clock_of_real_links_goes_on_while_the_computer_sleeps():
    steady = iter([100.0, 101.0, 28901.0])
    clock = WallClock(lambda: next(steady))
    began = clock.now()
    assert clock.now() - began == pytest.approx(28800)


@pytest.mark.parametrize(
    ("system", "clock"), [("linux", "CLOCK_BOOTTIME"), ("darwin", "CLOCK_MONOTONIC_RAW")]
)
def test_that_clock_is_none_of_the_calendar(system, clock, monkeypatch):
    monkeypatch.setattr(time, clock, 77, raising=False)
    monkeypatch.setattr(time, "CLOCK_MONOTONIC", 1, raising=False)
    monkeypatch.setattr(time, "clock_gettime", lambda number: number, raising=False)
    assert _steady(system)() == 77
    monkeypatch.delattr(time, clock)
    assert _steady(system) is time.perf_counter
    assert _steady("win32") is _steady("emscripten") is time.perf_counter
