"""A served unit on TCP, for real: sockets, the clock, several of them at once."""

from __future__ import annotations

import socket
import threading
from contextlib import contextmanager
from math import inf
from time import monotonic, sleep

import pytest

import mikas
from mikas.errors import NotAKLineAdapter, PortFailed
from mikas.framing import encode
from mikas.virtual import serve
from mikas.virtual.build import build_bus
from virtual_harness import DATA

from .serving import PATIENCE, a_tcp_port, read_until, serving

pytestmark = pytest.mark.realtime

BYTE, TURN = 10 / 9600, 0.002
ASKED = b"\x01\xff\x0d"
ANSWERED = ASKED + b"\x0a\xf6\x0d"


@contextmanager
def client(url: str):
    host, port = url.removeprefix("socket://").rsplit(":", 1)
    with socket.create_connection((host.strip("[]"), int(port)), PATIENCE) as connection:
        yield connection


def receive(connection: socket.socket, count: int) -> bytes:
    def some(seconds: float) -> bytes:
        connection.settimeout(seconds)
        return connection.recv(4096)

    return read_until(some, lambda data: len(data) >= count)


def ask(connection: socket.socket, wire: bytes = ASKED, count: int = len(ANSWERED)) -> bytes:
    connection.sendall(wire)
    return receive(connection, count)


def is_hung_up(connection: socket.socket) -> bool:
    connection.settimeout(PATIENCE)
    try:
        return connection.recv(1) == b""
    except ConnectionError:
        return True


def test_the_tester_receives_the_echo_and_the_answer():
    with serving(a_tcp_port) as server, client(server.url) as connection:
        assert server.url.startswith("socket://127.0.0.1:")
        assert ask(connection) == ANSWERED


def test_without_echo_the_tester_receives_the_answer_alone():
    with serving(a_tcp_port, {"echo": "0"}) as server, client(server.url) as connection:
        assert ask(connection, count=3) == ANSWERED[3:]


def test_bytes_are_no_faster_than_the_wire():
    """All of a full set: 25 bytes out, 27 and what is stuffed back, never in less than 56 ms."""
    request = encode(b"\x61" + bytes(DATA))
    size = len(request) + 27
    with serving(a_tcp_port) as server, client(server.url) as connection:
        began = monotonic()
        heard = ask(connection, request, size)
        assert monotonic() - began >= size * BYTE + TURN - 1e-3
        assert heard.startswith(request)


def test_bytes_arrive_one_by_one():
    """By a clock that stands still between them, as a busy machine would not read each at once."""
    buses, time = [], [0.0]

    async def open_port(bus, clock) -> serve.TcpPort:
        buses.append(bus)
        time[0] = clock()
        return await serve.TcpPort.open(bus, lambda: time[0], "127.0.0.1", 0)

    with serving(open_port) as server, client(server.url) as connection:
        connection.sendall(ASKED)
        connection.settimeout(PATIENCE)
        deadline = monotonic() + PATIENCE
        while buses[0].sending_until <= time[0]:  # the server has not read them yet
            assert monotonic() < deadline
            sleep(0.001)
        for each in ASKED:
            time[0] += 1.01 * BYTE
            assert connection.recv(4096) == bytes((each,))
        time[0] += 1.0
        assert receive(connection, 3) == ANSWERED[3:]


def test_bytes_take_the_time_of_the_baud_rate():
    with serving(a_tcp_port, {"baud": "300"}) as server, client(server.url) as connection:
        began = monotonic()
        assert ask(connection) == ANSWERED
        assert monotonic() - began >= 6 * 10 / 300


def test_a_second_tester_is_turned_away_and_the_first_one_goes_on():
    with serving(a_tcp_port) as server, client(server.url) as first:
        assert ask(first) == ANSWERED
        with client(server.url) as second:
            assert is_hung_up(second)
        assert ask(first) == ANSWERED


def test_a_tester_may_reconnect():
    with serving(a_tcp_port) as server:
        for _ in range(3):
            with client(server.url) as connection:
                assert ask_when_free(connection) == ANSWERED


def ask_when_free(connection: socket.socket) -> bytes:
    """The server may not have noticed yet that the one before has left."""
    deadline = monotonic() + PATIENCE
    address = connection.getpeername()
    while monotonic() < deadline:
        try:
            connection.sendall(ASKED)
            connection.settimeout(PATIENCE)
            if first := connection.recv(1):
                return first + receive(connection, len(ANSWERED) - 1)
        except ConnectionError:
            pass
        with socket.create_connection(address, PATIENCE) as again:
            try:
                again.sendall(ASKED)
                again.settimeout(PATIENCE)
                if first := again.recv(1):
                    return first + receive(again, len(ANSWERED) - 1)
            except ConnectionError:
                pass
    raise AssertionError("never let in")


def test_a_wire_too_fast_for_this_computer_does_not_block_others():
    """A stream at 400 kB a second, into a socket that is never read."""
    cars = ({"baud": "4000000", "turn_round": "0"}, {})
    with serving(a_tcp_port, *cars) as server, client(server.urls[1]) as other:
        with client(server.urls[0]) as deaf:
            deaf.sendall(encode(b"\x71" + bytes(DATA)))
            for _ in range(20):
                assert ask(other) == ANSWERED
        assert ask(other) == ANSWERED


def test_closing_hangs_up_and_takes_the_port_away():
    with serving(a_tcp_port) as server, client(server.url) as connection:
        assert ask(connection) == ANSWERED
        server.close()
        assert is_hung_up(connection)
        with pytest.raises(OSError), client(server.url):  # noqa: PT011  (each system its own)
            pass


def test_closing_without_a_tester_is_no_error():
    with serving(a_tcp_port) as server:
        server.close()


def test_many_units_on_one_loop_answer_as_themselves():
    models = ["5.4", "7.1"] * 4
    heard: dict[int, bytes] = {}

    def work(number: int, url: str) -> None:
        with client(url) as connection:
            heard[number] = b"".join(ask(connection) for _ in range(5))

    with serving(a_tcp_port, *({"model": model} for model in models)) as server:
        assert len(set(server.urls)) == len(models)
        threads = [
            threading.Thread(target=work, args=(number, url))
            for number, url in enumerate(server.urls)
        ]
        began = monotonic()
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(PATIENCE)
        assert monotonic() - began >= 5 * (6 * BYTE + TURN)
    for number, model in enumerate(models):
        code = 0x09 if model == "5.4" else 0x0A
        assert heard[number] == (ASKED + encode(bytes([code]))) * 5


def test_an_elm327_on_tcp_is_recognized(tmp_path):
    with (
        serving(a_tcp_port, {"adapter": "elm327"}) as server,
        pytest.raises(NotAKLineAdapter),
    ):
        mikas.connect(server.url, journal=tmp_path / "journal", state=tmp_path)


def test_a_port_that_is_taken_is_an_error():
    with serving(a_tcp_port) as server:
        number = int(server.url.rsplit(":", 1)[1])

        async def open_it_again():
            await serve.TcpPort.open(build_bus({}), monotonic, "127.0.0.1", number)

        with pytest.raises(PortFailed, match=str(number)):
            serve.run(open_it_again())


def test_a_host_that_does_not_exist_is_an_error():
    async def open_it():
        await serve.TcpPort.open(build_bus({}), monotonic, "256.256.256.256", 0)

    with pytest.raises(PortFailed):
        serve.run(open_it())


def test_the_testers_bytes_precede_overdue_ones():
    """The loop woke late: the unit's next response had not started when the tester's byte came."""
    now = 0.0
    heard = bytearray()

    async def main():
        nonlocal now
        bus = build_bus({"stream_end": "byte"})
        served = serve.ServedBus(bus, lambda: now, heard.extend)
        served.feed(encode(b"\x71\x1a"))
        while not heard.endswith(b"\x0d") or len(heard) < 7:
            now = bus.next_event()
            served.advance()
        gap_began = now
        now = gap_began + 1.0  # it slept through the next response's begin
        served.feed(b"\x01")
        served.stop()
        assert bus.next_event() == inf

    serve.run(main())
    request, response = 4, 3
    assert len(heard) == request + response + 1
    assert heard.endswith(b"\x01")  # whole, and the stream ended before it said anything more
