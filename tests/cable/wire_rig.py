"""The virtual unit behind a cable, and the scissors.

QEMU's emulated FT232 passes bytes to a socket; a `Wire` at its other end is the K-Line with the
unit on it, at the pace of the line. Three things differ from `mikas sim --tcp`: an unplugged cable
carries nothing, a break reaches the line, and the cable can be cut at an exact byte.
"""

from __future__ import annotations

import asyncio
import socket
import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from typing import TypeVar

from mikas.link import WallClock
from mikas.virtual import serve
from mikas.virtual.bus import Bus

T = TypeVar("T")
PATIENCE = 180.0  # s; emulation on a busy machine is slow
Condition = Callable[[bytes], bool]


class Wire(serve.ServedBus):
    """The line behind one cable. All methods run on the loop of its `Lines`."""

    def __init__(self, bus: Bus, clock: Callable[[], float], adapter_end: socket.socket) -> None:
        super().__init__(bus, clock, self._to_tester)
        self.bus = bus
        self.plugged = False
        self.sent = bytearray()
        """All bytes that the tester has sent while the cable was plugged in."""
        self.delivered: list[bytearray] = []
        """All bytes that the adapter got for the tester, from each plugging-in to the next."""
        self.breaks = 0
        self._end = adapter_end
        self._condition: Condition | None = None
        self._seen = bytearray()
        self._cut: Future[bytes] = Future()
        self._low = False

    def receive(self) -> None:
        """Take what the adapter sends."""
        with suppress(BlockingIOError):
            data = self._end.recv(4096)
            if self.plugged and not self._low:
                self.sent += data
                self.feed(data)

    def cut_when(self, condition: Condition) -> Future[bytes]:
        """Cut at the byte to the tester with which `condition` of those seen first holds.

        That byte still arrives, and nothing after it, in either direction. The future has the
        bytes.
        """
        self._condition, self._cut = condition, Future()
        self._seen.clear()
        return self._cut

    def carry(self) -> None:
        """The cable is plugged in."""
        self.plugged = True
        self.delivered.append(bytearray())

    def drop(self) -> None:
        """The cable is pulled out."""
        self.plugged = False

    def hold(self, *, low: bool) -> None:
        """Begin or end a break."""
        if self._low and not low:
            self.breaks += 1
            self.bus.send_break(0.0, self._clock())
        self._low = low
        self.advance()

    def _to_tester(self, data: bytes) -> None:
        if not self.plugged or self._low:
            return
        if self._condition is not None:
            data = self._up_to_the_cut(data, self._condition)
        self.delivered[-1] += data
        with suppress(BlockingIOError):  # an adapter that is not read loses bytes
            self._end.send(data)

    def _up_to_the_cut(self, data: bytes, condition: Condition) -> bytes:
        for number, value in enumerate(data, start=1):
            self._seen.append(value)
            if condition(bytes(self._seen)):
                self._condition, self.plugged = None, False
                self._cut.set_result(bytes(self._seen))
                return data[:number]
        return data


class Lines:
    """The loop on which all wires run, in a thread of its own."""

    def __init__(self) -> None:
        started: Future[asyncio.AbstractEventLoop] = Future()
        self._stop = asyncio.Event()

        async def main() -> None:
            started.set_result(asyncio.get_running_loop())
            await self._stop.wait()

        self._thread = threading.Thread(target=lambda: serve.run(main()))
        self._thread.start()
        self._loop = started.result(PATIENCE)
        self._clock = WallClock()

    def call(self, function: Callable[[], T]) -> T:
        """Run `function` on the loop; return its result."""
        done: Future[T] = Future()

        def run() -> None:
            try:
                done.set_result(function())
            except BaseException as error:  # it is the caller's
                done.set_exception(error)

        self._loop.call_soon_threadsafe(run)
        return done.result(PATIENCE)

    def put(self, adapter_end: socket.socket, bus_from: Callable[[float], Bus]) -> Wire:
        """Return a new wire on `adapter_end`, instead of the one before; `bus_from` its begin."""
        adapter_end.setblocking(False)

        def build() -> Wire:
            wire = Wire(bus_from(self._clock.now()), self._clock.now, adapter_end)
            self._loop.add_reader(adapter_end, wire.receive)
            wire.advance()
            return wire

        return self.call(build)

    def remove(self, wire: Wire, adapter_end: socket.socket) -> None:
        """End `wire`."""

        def end() -> None:
            self._loop.remove_reader(adapter_end)
            wire.stop()

        self.call(end)

    def close(self) -> None:
        self._loop.call_soon_threadsafe(self._stop.set)
        self._thread.join(PATIENCE)
