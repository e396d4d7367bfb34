"""The K-Line with the virtual unit on it, behind the UART of a chip model, and the scissors.

The unit keeps the pace of the line in real time. Where the chip is at another rate or form than
the unit, each reads of the other what a UART would: the unit gets garbage, the tester garbage for
every response; but the tester's own echo is sampled with the clock that sent it, and is whole. Its
time alone shows the wrong rate.

All of this runs on the loop of `Lines`, and so do the transports of the chips.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Coroutine
from concurrent.futures import Future
from dataclasses import replace
from typing import Any, TypeVar

from mikas.link import WallClock
from mikas.virtual import serve
from mikas.virtual.bus import Bus
from usb.chips.uart import BREAK, Damage, Settings, Uart, sampled

T = TypeVar("T")
PATIENCE = 180.0  # s; emulation on a busy machine is slow
Condition = Callable[[bytes], bool]


class Wire(serve.ServedBus):
    """The line behind one cable: the `Line` of its chip. All methods run on the loop of `Lines`."""

    def __init__(self, bus: Bus, clock: Callable[[], float]) -> None:
        super().__init__(bus, clock, self._to_tester)
        self.bus = bus
        self.unit = Settings(rate=bus.ecu.baud)
        """The rate and the form of the unit."""
        self.sent = bytearray()
        """All bytes that the tester has sent while the cable was plugged in."""
        self.delivered: list[bytearray] = []
        """All bytes that the line had for the tester, from each plugging-in to the next."""
        self.breaks = 0
        self._uart: Uart | None = None
        self._echo = bus.adapter.kind.echo
        self._echoed_until = 0.0
        self._condition: Condition | None = None
        self._seen = bytearray()
        self._cut: Future[bytes] = Future()
        self._low = False

    @property
    def plugged(self) -> bool:
        return self._uart is not None

    # -- the chip's side ---------------------------------------------------------------------------

    def send(self, data: bytes, settings: Settings) -> None:
        """Take what the chip sends."""
        if self._uart is None:
            return
        self.sent += data
        fits = settings.fits(self.unit)
        self._let_echo(fits)
        if fits:
            self.feed(data)
            return
        found = sampled(data, settings, self.unit)
        if any(Damage.BREAK in it.damage for it in found):  # zeros, much slower than the unit
            self.breaks += 1
            self.bus.send_break(len(data) * settings.character_time, self._clock())
            self.advance()
        else:
            self.feed(bytes(it.value for it in found))
        if self._echo:
            self._echo_by_itself(data, settings)

    def hold(self, low: bool) -> None:
        """Begin or end a break; a chip hears its own, where the line echoes."""
        if self._low and not low:
            self.breaks += 1
            self._let_echo(False)
            self.bus.send_break(0.0, self._clock())
            self._low = False
            self.advance()
            self._let_echo(True)
            if self._uart is not None and self._echo:
                self.delivered[-1].append(BREAK.value)
                self._uart.receive([BREAK])
        self._low = low
        self.advance()

    def _let_echo(self, on: bool) -> None:
        adapter = self.bus.adapter
        if adapter.kind.echo != (on and self._echo):
            adapter.kind = replace(adapter.kind, echo=on and self._echo)

    def _echo_by_itself(self, data: bytes, settings: Settings) -> None:
        """Echo `data` at the pace of the chip, which is not that of the unit."""
        now = self._loop.time()
        self._echoed_until = max(now, self._echoed_until)
        for value in data:
            self._echoed_until += settings.character_time
            self._loop.call_at(self._echoed_until, self._hear, bytes((value,)), settings)

    # -- the test's side ---------------------------------------------------------------------------

    def cut_when(self, condition: Condition) -> Future[bytes]:
        """Cut at the byte to the tester with which `condition` of those seen first holds.

        That byte still arrives, and nothing after it, in either direction. The future has the
        bytes.
        """
        self._condition, self._cut = condition, Future()
        self._seen.clear()
        return self._cut

    def carry(self, uart: Uart) -> None:
        """The cable is plugged in, with a new chip."""
        self._uart = uart
        self._low = False
        self.delivered.append(bytearray())

    def drop(self) -> None:
        """The cable is pulled out."""
        self._uart = None

    # -- the line's side ---------------------------------------------------------------------------

    def _to_tester(self, data: bytes) -> None:
        self._hear(data, self.unit)

    def _hear(self, data: bytes, settings: Settings) -> None:
        uart = self._uart
        if uart is None or self._low:
            return
        if self._condition is not None:
            data = self._up_to_the_cut(data, self._condition)
        self.delivered[-1] += data
        uart.hear(data, settings)

    def _up_to_the_cut(self, data: bytes, condition: Condition) -> bytes:
        for number, value in enumerate(data, start=1):
            self._seen.append(value)
            if condition(bytes(self._seen)):
                self._condition = self._uart = None
                self._cut.set_result(bytes(self._seen))
                return data[:number]
        return data


class Lines:
    """The loop on which all wires and transports run, in a thread of its own."""

    def __init__(self) -> None:
        started: Future[asyncio.AbstractEventLoop] = Future()
        self._stop = asyncio.Event()

        async def main() -> None:
            started.set_result(asyncio.get_running_loop())
            await self._stop.wait()

        self._thread = threading.Thread(target=lambda: serve.run(main()))
        self._thread.start()
        self.loop = started.result(PATIENCE)
        self._clock = WallClock()

    def call(self, function: Callable[[], T]) -> T:
        """Run `function` on the loop; return its result."""

        async def run() -> T:
            return function()

        return self.run(run())

    def run(self, work: Coroutine[Any, Any, T]) -> T:
        """Run `work` on the loop to its end; return its result."""
        return asyncio.run_coroutine_threadsafe(work, self.loop).result(PATIENCE)

    def put(self, bus_from: Callable[[float], Bus]) -> Wire:
        """Return a new wire; `bus_from` its begin."""

        def build() -> Wire:
            wire = Wire(bus_from(self._clock.now()), self._clock.now)
            wire.advance()
            return wire

        return self.call(build)

    def remove(self, wire: Wire) -> None:
        """End `wire`."""
        self.call(wire.drop)
        self.call(wire.stop)

    def close(self) -> None:
        self.loop.call_soon_threadsafe(self._stop.set)
        self._thread.join(PATIENCE)
