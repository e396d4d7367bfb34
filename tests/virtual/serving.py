"""A virtual unit served in real time from a thread of its own, as `mikas sim` serves it."""

from __future__ import annotations

import asyncio
import queue
import threading
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import monotonic

from mikas.link import WallClock
from mikas.virtual import serve
from mikas.virtual.build import build_bus

PATIENCE = 30.0  # s; nothing here takes more than a moment, but the machine may be busy


@dataclass
class Served:
    """`close` takes the ports away, as Ctrl-C does to `mikas sim`."""

    urls: list[str]
    close: Callable[[], None]

    @property
    def url(self) -> str:
        return self.urls[0]


async def a_tcp_port(bus, clock) -> serve.TcpPort:
    return await serve.TcpPort.open(bus, clock, "127.0.0.1", 0)


async def a_pty_port(bus, clock) -> serve.PtyPort:
    return serve.PtyPort(bus, clock)


@contextmanager
def serving(
    open_port: Callable[..., Awaitable[serve.TcpPort | serve.PtyPort]],
    *cars: dict[str, str],
) -> Iterator[Served]:
    """A port for each car's settings, all on one loop; one warm car if none is named."""
    reported: queue.Queue = queue.Queue()

    async def main() -> None:
        clock = WallClock()
        stop = asyncio.Event()
        buses = [build_bus(settings, start=clock.now()) for settings in cars or ({},)]
        ports = [await open_port(bus, clock.now) for bus in buses]
        reported.put((ports, asyncio.get_running_loop(), stop))
        await stop.wait()
        for port in ports:
            port.close()

    thread = threading.Thread(target=lambda: serve.run(main()))
    thread.start()
    ports, loop, stop = reported.get(timeout=PATIENCE)

    def close() -> None:
        if thread.is_alive():
            loop.call_soon_threadsafe(stop.set)
        thread.join(PATIENCE)
        assert not thread.is_alive()

    try:
        yield Served([port.url for port in ports], close)
    finally:
        close()


def read_until(read_some: Callable[[float], bytes], enough: Callable[[bytes], bool]) -> bytes:
    """What `read_some(seconds)` brings, piece by piece, until it is enough."""
    data, deadline = b"", monotonic() + PATIENCE
    while not enough(data):
        left = deadline - monotonic()
        assert left > 0, f"only {data.hex(' ')} came"
        piece = read_some(left)
        assert piece, f"it ended behind {data.hex(' ')}"
        data += piece
    return data
