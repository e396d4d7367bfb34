"""What a fake adapter's wire leads to: a virtual unit in real time, or bytes by hand."""

from __future__ import annotations

import asyncio
import os
import select
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

from browser.rig import CAR
from mikas.catalog import shipped
from mikas.virtual.build import build_bus
from mikas.virtual.bus import Bus
from mikas.virtual.instruments import VirtualInstrument
from mikas.virtual.serve import InstrumentPty, PtyPort, run

from .computer_rig import FT232, Adapter, Computer

UNTIL = 60.0  # s that bytes may take on a slow machine
KEPT = 4000  # bytes that a system keeps for a port that is not read

T = TypeVar("T")


class _Port(PtyPort):
    """Drops what a closed port of USB would: a pty keeps 64 kB of a unit that goes on sending while
    a page starts anew, and then brings them at once, which no line can.
    """

    def _send(self, data: bytes) -> None:
        import fcntl
        import termios

        waiting = fcntl.ioctl(self._slave, termios.FIONREAD, bytes(4))
        if int.from_bytes(waiting, sys.byteorder) < KEPT:
            super()._send(data)


class Cable:
    """An adapter on a virtual unit, that can be pulled out and put back; the unit runs on.

    `set`, `car`, `memory`: as `browser.rig.Garage`. The wire is real time's, in a thread of its
    own; `tune` changes the wire's settings (docs/reference/simulator.md), when the cable is
    put back.
    """

    def __init__(self, computer: Computer, adapter: Adapter, settings: dict[str, str]) -> None:
        self._computer, self._adapter, self._settings = computer, adapter, settings
        self._clock = time.monotonic
        self._bus = build_bus(settings, start=self._clock())
        self._port: PtyPort | None = None
        self._number: int | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._ready = threading.Event()
        self._thread = threading.Thread(target=lambda: run(self._serve()))
        self._thread.start()
        assert self._ready.wait(UNTIL)

    async def _serve(self) -> None:
        self._loop, self._end = asyncio.get_running_loop(), asyncio.Event()
        self._ready.set()
        await self._end.wait()

    def _there(self, act: Callable[[], T]) -> T:
        """Return what `act()` gives in the wire's thread."""

        async def acting() -> T:
            return act()

        assert self._loop is not None
        return asyncio.run_coroutine_threadsafe(acting(), self._loop).result(UNTIL)

    def put_back(self) -> None:
        """Plug it in."""
        self._port = self._there(lambda: _Port(self._bus, self._clock))
        self._number = self._computer.plug(self._adapter, self._port.url)

    def pull(self) -> None:
        """Unplug it; nothing happens if it is out."""
        if self._port is not None and self._number is not None:
            self._there(self._port.close)
            self._computer.unplug(self._number)
            self._port = self._number = None

    def tune(self, **settings: str) -> None:
        """Another car and another wire, from the next time that it is plugged in."""
        self._settings |= settings
        self._bus = build_bus(self._settings, start=self._clock())

    @contextmanager
    def instrument(self, name: str, adapter: Adapter) -> Iterator[None]:
        """Plug in a cable to an instrument of this kind in the car, which must have an engine."""
        made = VirtualInstrument(name, self.car, self._clock())
        port = self._there(lambda: InstrumentPty(made, self._clock))
        number = self._computer.plug(adapter, port.url)
        try:
            yield
        finally:
            self._computer.unplug(number)
            self._there(port.close)

    def set(self, name: str, raw: str) -> None:
        """The car's datum from now on: `set("UACC", "8A")`."""
        code, data = shipped().parameter(name).code, bytes.fromhex(raw)
        self._there(lambda: self.car.write(code, data))

    @property
    def bus(self) -> Bus:
        return self._bus

    @property
    def car(self):
        return self._bus.ecu.responder.car

    @property
    def memory(self):
        return self._bus.ecu.responder.memory

    def close(self) -> None:
        self.pull()
        assert self._loop is not None
        self._loop.call_soon_threadsafe(self._end.set)
        self._thread.join()


@contextmanager
def cable(
    computer: Computer, folder: Path, adapter: Adapter = FT232, **settings: str
) -> Iterator[Cable]:
    """Plug in an adapter on the car of `browser.rig`, whose values stand still.

    `settings`: those of docs/reference/simulator.md, as `latency_ms="16"`; a `scenario` is
    another car.
    """
    file = folder / "car.toml"
    file.write_text(CAR, "utf-8")
    made = Cable(computer, adapter, {"scenario": str(file)} | settings)
    try:
        made.put_back()
        yield made
    finally:
        made.close()


class Wire:
    """An adapter whose other end is the test itself: what it sends, what it got."""

    def __init__(self, computer: Computer, adapter: Adapter) -> None:
        self._computer, self._adapter = computer, adapter
        self.put_back()

    def put_back(self) -> None:
        import pty
        import tty

        self._master, slave = pty.openpty()
        tty.setraw(slave)
        self._number = self._computer.plug(self._adapter, os.ttyname(slave))
        self._slave = slave  # so that the port remains when the browser closes it
        self.is_there = True

    def send(self, data: bytes) -> None:
        os.write(self._master, data)

    def received(self, count: int) -> bytes:
        """Return what came since the last call, once it is `count` bytes."""
        data = b""
        while len(data) < count:
            ready, _, _ = select.select([self._master], [], [], UNTIL)
            assert ready, f"only {data!r} came"
            data += os.read(self._master, 4096)
        return data

    def arrived(self) -> bytes:
        """Return what has come since the last call."""
        ready, _, _ = select.select([self._master], [], [], 0)
        return os.read(self._master, 4096) if ready else b""

    def vanish(self) -> None:
        """Unplug it; nothing happens if it is out."""
        if self.is_there:
            self.is_there = False
            os.close(self._slave)
            os.close(self._master)
            self._computer.unplug(self._number)


@contextmanager
def wire(computer: Computer, adapter: Adapter = FT232) -> Iterator[Wire]:
    made = Wire(computer, adapter)
    try:
        yield made
    finally:
        made.vanish()
