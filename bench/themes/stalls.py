"""A line that stalls, and a computer that is busy (D14): what sampling keeps of the wire."""

from __future__ import annotations

import os
import select
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, closing, contextmanager

import serial

from bench.rig import Meter, Session, everything, paced, sample, serving
from bench.rows import Row, Scope, Theme
from mikas.client.parameters.polling import FixedMethod
from mikas.link import open_link
from mikas.link.reconnecting import ReconnectingPort
from mikas.link.virtual import VirtualLink
from mikas.virtual.build import build_bus
from mikas.virtual.bus import Stalls

_EVERY = 1.0  # s from one stall to the next, about
_LONGEST = 0.18  # s
_RATES: dict[FixedMethod, int] = {"single": 5, "batch": 17, "list": 29, "stream": 34}  # sets/s
_HOLE = 0.6  # s

StallingLine = Callable[
    [float], AbstractContextManager[tuple[ReconnectingPort, Callable[[], float]]]
]
"""A port with a stall about every so many seconds, and the seconds of its stalls so far."""

_STALLS = """\
About once a second nothing passes between tester and ECU for 30 to 180 ms, in either direction, as
through a Wi-Fi bridge; nothing is lost. 100 % is the rate of the same line without stalls, times
the time that they leave; more is possible, because a stream goes on meanwhile. A hole is the
longest time between two samples. """
_SIMULATED = "On the simulated clock."
_BRIDGE = "In real time, through a TCP bridge in front of a virtual ECU on a paced pty."
_BUSY = """\
Sampling over a paced pty beside one busy process for each core, in relation to the rate without
them, measured just before. The virtual ECU suffers from them as well: what it sends late is not
made up for."""


def run(scope: Scope) -> Iterator[Theme]:
    yield Theme("A line that stalls", _STALLS + _SIMULATED, list(_stalled(scope, _simulated, 60)))
    rows = list(_stalled(scope, _bridge, 20))
    yield Theme("A bridge that stalls", _STALLS + _BRIDGE, rows)
    yield Theme("A busy computer", _BUSY, list(_busy(scope)))


def _stalled(scope: Scope, line: StallingLine, seconds: int) -> Iterator[Row]:
    for method, rate in _RATES.items():
        with line(0.0) as (plug, _):
            sets = rate * scope.of(seconds // 2, 3)
            (calm,) = sample(plug, everything(), method, sets=sets, runs=1).laps
        session, stalled = _beside_stalls(line, method, rate * scope.of(seconds, 5))
        (lap,) = session.laps
        percent = 100 * lap.rate / (calm.rate * (1 - stalled / lap.seconds))
        aside = f"{stalled:.1f} s of {lap.seconds:.0f} s stalled; {_faults(session)}"
        yield Row(f"`{method}`", [percent], "%", 1, at_least=95, aside=aside)
        yield Row(f"`{method}`, longest hole", [session.hole], "s", 2, at_most=_HOLE)


def _beside_stalls(line: StallingLine, method: FixedMethod, sets: int) -> tuple[Session, float]:
    """The session, and the seconds of the stalls in it."""
    before: list[float] = []
    with line(_EVERY) as (plug, total):
        session = sample(
            plug, everything(), method, sets=sets, runs=1, began=lambda: before.append(total())
        )
        return session, total() - before[0]


def _faults(session: Session) -> str:
    return f"{session.errors} line errors, {session.gaps} cycles lost"


@contextmanager
def _simulated(every: float) -> Iterator[tuple[ReconnectingPort, Callable[[], float]]]:
    bus = build_bus({"stall_every": str(every), "stall_ms": str(1000 * _LONGEST), "seed": "1"})
    plug = ReconnectingPort("sim:", open_port=lambda _: Meter(VirtualLink(bus)))
    yield plug, lambda: bus.adapter.stalls.total


@contextmanager
def _bridge(every: float) -> Iterator[tuple[ReconnectingPort, Callable[[], float]]]:
    with ExitStack() as stack:
        pty = stack.enter_context(serving())
        port = stack.enter_context(closing(serial.Serial(pty, timeout=0)))
        server = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
        relay = _Relay(server, port, Stalls(every, _LONGEST, seed=1))
        stack.callback(relay.stop)
        relay.start()
        url = f"socket://127.0.0.1:{server.getsockname()[1]}"
        plug = ReconnectingPort(url, open_port=lambda url: Meter(open_link(url)))
        yield plug, lambda: relay.stalled


class _Relay(threading.Thread):
    """Passes bytes between one connection of `server` and `port`, with stalls."""

    def __init__(self, server: socket.socket, port: serial.Serial, stalls: Stalls) -> None:
        super().__init__(daemon=True)
        self.stalled = 0.0
        self._server = server
        self._port = port
        self._stalls = stalls
        self._stopped = False

    def stop(self) -> None:
        self._stopped = True
        self.join()

    def run(self) -> None:
        connection, _ = self._server.accept()
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        with connection:
            while not self._stopped:
                numbers = [connection.fileno(), self._port.fileno()]
                ready, _, _ = select.select(numbers, [], [], 0.05)
                now = time.perf_counter()
                wait = self._stalls.passed(now) - now
                if wait > 0:
                    self.stalled += wait
                    time.sleep(wait)  # the stall
                if numbers[0] in ready:
                    if not (data := connection.recv(4096)):
                        return
                    self._port.write(data)
                if numbers[1] in ready:
                    connection.sendall(self._port.read(4096))


def _busy(scope: Scope) -> Iterator[Row]:
    for method, rate in _RATES.items():
        sets = rate * scope.of(10, 3)
        idle = _on_pty(method, sets)
        with _busy_cores():
            busy = _on_pty(method, sets)
        percent = 100 * busy.laps[0].rate / idle.laps[0].rate
        aside = f"{busy.laps[0].rate:.1f} of {idle.laps[0].rate:.1f} sets/s"
        aside += f"; longest hole {busy.hole:.2f} s; {_faults(busy)}"
        yield Row(f"`{method}`", [percent], "% of the idle rate", 1, at_least=90, aside=aside)


def _on_pty(method: FixedMethod, sets: int) -> Session:
    with paced() as plug:
        return sample(plug, everything(), method, sets=sets, runs=1)


@contextmanager
def _busy_cores() -> Iterator[None]:
    command = [sys.executable, "-c", "while True: pass"]
    processes = [subprocess.Popen(command) for _ in range(os.cpu_count() or 1)]
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()
