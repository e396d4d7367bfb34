"""A served unit whose tester floods, never reads, vanishes, or comes a thousand times.

Real sockets on the loop of the test, which counts the bytes that wait.
"""

from __future__ import annotations

import asyncio
import gc
import socket
from contextlib import suppress

import pytest

from mikas.framing import encode
from mikas.link import WallClock
from mikas.virtual import serve
from mikas.virtual.build import build_bus
from virtual_harness import DATA

pytestmark = pytest.mark.realtime

ASKED = b"\x01\xff\x0d"
ANSWERED = ASKED + b"\x0a\xf6\x0d"
FAST = {"baud": "200000", "turn_round": "0"}
GARBAGE = bytes(range(256)) * 256
MOST = 1024


class Counted:
    """A served unit; `most` is the largest number of bytes that waited in it at any moment."""

    def __init__(self, **settings: str) -> None:
        self.clock = WallClock()
        self.ahead = 0.0
        self.bus = build_bus(FAST | settings, start=self.now())
        self.most = 0
        send = self.bus.send

        def counting(data, now):
            send(data, now)
            self.most = max(self.most, self.queued)

        self.bus.send = counting

    def now(self) -> float:
        return self.clock.now() + self.ahead

    @property
    def queued(self) -> int:
        return len(self.bus.tester.queue) if hasattr(self.bus, "tester") else 0

    async def on_tcp(self) -> serve.TcpPort:
        return await serve.TcpPort.open(self.bus, self.now, "127.0.0.1", 0)


async def client(port: serve.TcpPort) -> socket.socket:
    connection = socket.socket()
    connection.setblocking(False)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    host, number = port.url.removeprefix("socket://").split(":")
    await asyncio.get_running_loop().sock_connect(connection, (host, int(number)))
    return connection


async def until(condition) -> None:
    async with asyncio.timeout(30):
        while not condition():
            await asyncio.sleep(0)


async def flood(connection: socket.socket, turns: int = 100) -> int:
    """Send garbage in `turns` turns of the loop, as much as the system takes."""
    sent = 0
    for _ in range(turns):
        with suppress(BlockingIOError):
            sent += connection.send(GARBAGE)
        await asyncio.sleep(0)
    return sent


async def asks(connection: socket.socket) -> bytes:
    loop = asyncio.get_running_loop()
    await loop.sock_sendall(connection, ASKED)
    heard = b""
    async with asyncio.timeout(30):
        while len(heard) < len(ANSWERED):
            heard += await loop.sock_recv(connection, 4096)
    return heard


@pytest.mark.parametrize("settings", [{}, {"echo": "0"}, {"supplied": "0"}, {"adapter": "elm327"}])
def test_a_flood_waits_at_its_sender_and_goes_with_it(settings):
    async def main():
        it = Counted(**settings)
        port = await it.on_tcp()
        connection = await client(port)
        await until(lambda: port.tester)
        sent = await flood(connection)
        assert it.most <= MOST
        assert port.waiting > 0  # it was a flood
        assert sent < 8_000_000  # the sender has to wait
        carried = it.bus.bytes_carried
        connection.close()
        port.tester.abort()  # what the system reports once it knows
        await until(lambda: port.tester is None)
        assert it.queued == port.waiting == 0
        assert len(it.bus.ecu._answers) <= 4  # noqa: SLF001
        assert it.bus.bytes_carried - carried < 5000  # no more answers
        port.close()

    serve.run(main())


def test_a_flooder_that_leaves_is_noticed_and_the_next_tester_is_served():
    async def main():
        it = Counted()
        port = await it.on_tcp()
        connection = await client(port)
        await until(lambda: port.tester)
        await flood(connection)
        connection.close()  # with echoes unread: as a killed process
        await until(lambda: port.tester is None)
        assert it.queued == 0
        it.ahead += 1.0  # the unit waits 0.1 s for the rest of a request
        with await client(port) as another:
            await until(lambda: port.tester)
            assert await asks(another) == ANSWERED
        port.close()

    serve.run(main())


def test_no_byte_of_a_tester_is_lost_however_fast_it_sends():
    async def main():
        it = Counted()
        port = await it.on_tcp()
        heard = bytearray()
        with await client(port) as connection:
            loop = asyncio.get_running_loop()
            sending = asyncio.create_task(loop.sock_sendall(connection, b"\x55" * 5_000))
            while len(heard) < 5_000:
                heard += await loop.sock_recv(connection, 1 << 16)
            await sending
        assert heard == b"\x55" * 5_000
        assert it.most <= MOST
        port.close()

    serve.run(main())


def test_a_thousand_connections_leave_the_tester_and_nothing_else():
    async def main():
        it = Counted()
        port = await it.on_tcp()
        with await client(port) as tester:
            assert await asks(tester) == ANSWERED
            for _ in range(20):
                others = [await client(port) for _ in range(50)]
                for each in others:
                    each.close()
            assert await asks(tester) == ANSWERED
            await until(lambda: len(asyncio.all_tasks()) == 1)
            gc.collect()
            assert len(asyncio.get_running_loop()._transports) == 1  # noqa: SLF001
        port.close()

    serve.run(main())


@pytest.mark.parametrize("manner", ["silent", "flooding", "deaf"])
def test_one_that_is_no_tester_keeps_another_one_out_for_a_minute_only(manner):
    async def main():
        loop = asyncio.get_running_loop()
        it = Counted(echo="0", baud="2000000" if manner == "deaf" else "9600")
        port = await it.on_tcp()
        first = await client(port)
        await until(lambda: port.tester)
        if manner == "flooding":
            await flood(first)
        elif manner == "deaf":
            await loop.sock_sendall(first, encode(b"\x71" + bytes(DATA)))
            await until(lambda: port.tester.get_write_buffer_size() >= 4000)
            before = it.bus.bytes_carried
            await until(lambda: it.bus.bytes_carried > before + 5000)
            assert port.tester.get_write_buffer_size() < 3 * 4096
        held = port.tester
        port._active -= 59.0  # noqa: SLF001
        with await client(port) as second:
            assert await loop.sock_recv(second, 1) == b""
        assert port.tester is held
        port._active -= 1.0  # noqa: SLF001
        with await client(port) as third:
            await until(lambda: port.tester not in (held, None))
            it.ahead += 1.0
            await loop.sock_sendall(third, ASKED)
            assert await loop.sock_recv(third, 1)
        first.close()
        port.close()

    serve.run(main())
