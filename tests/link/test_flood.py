"""No link brings more than a line can carry; and what is slower is never taken for a flood."""

from __future__ import annotations

import socket
import threading
from contextlib import suppress

import pytest

from mikas.errors import LineFlooded
from mikas.link import Chunk, Link, open_link
from mikas.link.flood import BACKLOG, BURST, FloodGuard

from .network.terminal_server import served

LINE = 960.0  # bytes a second at 9600 baud


class Brings(Link):
    """Brings `rate` bytes a second, `size` at a time, on a simulated clock."""

    url = "test:"

    def __init__(self, rate: float, size: int = 64) -> None:
        self.rate, self.size = rate, size
        self.time, self.closed, self.brought = 1000.0, False, 0

    def write(self, data: bytes) -> None:
        pass

    def read(self, deadline: float) -> Chunk:
        self.time += self.size / self.rate
        self.brought += self.size
        return Chunk(b"\x55" * self.size, self.time)

    def now(self) -> float:
        return self.time

    def send_break(self, seconds: float) -> None:
        pass

    def close(self) -> None:
        self.closed = True


def bytes_until_flooded(line: Brings, most: int) -> int | None:
    guard = FloodGuard(line)
    while line.brought < most:
        try:
            guard.read(0.0)
        except LineFlooded as error:
            assert line.closed
            assert f"{error.fields['rate']} bytes a second" in str(error)
            return line.brought
    return None


@pytest.mark.parametrize(
    ("times", "size"), [(3, 64), (10, 1), (10, BACKLOG), (1000, 64), (1e6, 1), (1e6, BACKLOG)]
)
def test_more_than_a_line_carries_is_given_up(times, size):
    brought = bytes_until_flooded(Brings(times * LINE, size), most=10**6)
    assert brought is not None
    surplus = 1 - 2 / times
    assert brought <= BURST * LINE / surplus + 2 * size


def bytes_until_refused(link: Link) -> int:
    taken = 0
    with suppress(LineFlooded):
        while True:
            taken += len(link.read(link.now() + 1).data)
    return taken


@pytest.mark.parametrize("times", [0.5, 1.0, 1.05, 1.9])
def test_a_line_is_never_given_up(times):
    """An hour of a stream, and of a unit whose clock is fast, or of twice the named rate."""
    assert bytes_until_flooded(Brings(times * LINE), most=int(3600 * LINE)) is None


def test_a_late_network_is_no_flood():
    """Bytes of ten seconds come together, again and again."""
    assert bytes_until_flooded(Brings(LINE, size=9600), most=10**6) is None


def test_what_came_while_no_one_read_is_no_flood():
    """The computer was asleep for an hour in a stream."""
    line = Brings(LINE)
    guard = FloodGuard(line)
    guard.read(0.0)
    line.time += 3600
    line.rate, line.size = 1e9, BACKLOG
    for _ in range(int(3600 * LINE / BACKLOG)):
        guard.read(0.0)


def test_an_emulator_that_answers_at_once_is_no_flood():
    line = Brings(1e9, size=600)
    guard = FloodGuard(line)
    for _ in range(5000):
        guard.write(b"\x01\xff\x0d")
        guard.read(0.0)


def test_after_a_flood_every_call_raises_and_names_its_request():
    guard = FloodGuard(Brings(1e9, size=20_000))
    guard.read(0.0)  # what has come is not withheld
    with pytest.raises(LineFlooded) as caught:
        guard.write(b"\x01\xff\x0d")
    assert caught.value.request == b"\x01\xff\x0d"
    for call in (lambda: guard.read(0.0), lambda: guard.send_break(0.1)):
        with pytest.raises(LineFlooded, match="a line of 9600 baud carries 960 at most"):
            call()
    assert "линия на 9600 бод пропускает не больше 960" in caught.value.text.ru


@pytest.mark.realtime
def test_a_network_port_that_sends_at_full_speed_is_given_up():
    def send() -> None:
        with server.accept()[0] as connection, suppress(OSError):
            while True:
                connection.sendall(b"\x55" * 65536)

    with socket.create_server(("127.0.0.1", 0)) as server:
        sender = threading.Thread(target=send)
        sender.start()
        with open_link(f"socket://127.0.0.1:{server.getsockname()[1]}") as link:
            began = link.now()
            taken = bytes_until_refused(link)
            assert taken <= (BURST + 2 * (link.now() - began)) * LINE + BACKLOG
        sender.join(10)
        assert not sender.is_alive()  # the connection is closed


@pytest.mark.realtime
def test_a_terminal_server_that_sends_at_full_speed_waits_while_no_one_reads():
    """What was not read stays in the system, which stops the sender."""
    waited, closed = threading.Event(), threading.Event()

    def flood(client: socket.socket) -> None:
        client.sendall(b"\xff\xfd\x2c")
        client.settimeout(1.5)  # longer than the link takes to open
        try:
            client.sendall(b"\x55" * 100_000_000)
        except TimeoutError:
            waited.set()
            closed.wait(30)

    with served(flood) as place, open_link(f"rfc2217://{place}"):
        assert waited.wait(30)
        closed.set()
