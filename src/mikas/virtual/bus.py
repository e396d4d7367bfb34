"""One K-Line wire with a virtual unit on it and a tester's adapter at its end (§1, D1, D2).

A byte takes 10 bits. Two bytes sent at the same time damage each other: the line carries the AND of
the two (low wins). Modelled a byte at a time: two bytes that overlap at all are
both heard as their AND, which is coarser than bits but never lets a collision pass unseen.

Time-explicit like the unit: `advance(now)` runs the wire forward; nothing sleeps.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import inf

from mikas.virtual.adapter import Adapter, AdapterKind
from mikas.virtual.ecu import VirtualEcu
from mikas.virtual.fault_injector import FaultInjector


@dataclass(slots=True)
class _Byte:
    start: float
    end: float
    value: int


class _Talker:
    """The bytes that one end has put on the wire, in order, and the last one that has passed."""

    def __init__(self, byte_time: float) -> None:
        self.byte_time = byte_time
        self.queue: deque[_Byte] = deque()
        self.last: _Byte | None = None
        self.free_at = -inf

    def transmit(self, data: bytes, start: float) -> None:
        start = max(start, self.free_at)
        for value in data:
            self.queue.append(_Byte(start, start + self.byte_time, value))
            start += self.byte_time
        self.free_at = start

    def next_end(self) -> float:
        return self.queue[0].end if self.queue else inf

    def overlapping(self, byte: _Byte) -> int:
        """The AND of all its bytes that overlap `byte`; FF, the idle line, if none does."""
        value = 0xFF
        if self.last and self.last.end > byte.start and self.last.start < byte.end:
            value &= self.last.value
        for other in self.queue:
            if other.start >= byte.end:
                break
            if other.end > byte.start:
                value &= other.value
        return value

    def silent_from(self, time: float) -> float:
        """`time` if it sends nothing then, else the end of the bytes that follow each other."""
        if time >= self.free_at:
            return time
        for byte in self.queue:
            if byte.start > time:
                break
            time = max(time, byte.end)
        return time

    def fall_silent(self, free_at: float) -> None:
        """Drops what is not through yet; the next byte can begin at `free_at`."""
        self.queue.clear()
        self.free_at = free_at


class Bus:
    """The wire. `send` and `take` are the tester's side, everything else its owner's."""

    def __init__(
        self,
        ecu: VirtualEcu,
        *,
        adapter: AdapterKind | None = None,
        fault_injector: FaultInjector | None = None,
    ) -> None:
        self.ecu = ecu
        self.byte_time = 10 / ecu.baud
        self.fault_injector = fault_injector or FaultInjector()
        self.adapter = Adapter(adapter or AdapterKind())
        self.bytes_carried = 0
        self._tester = _Talker(self.byte_time)
        self._unit = _Talker(self.byte_time)
        self._at = -inf  # time of the last event; no later event is before it
        self._next = self._next_on_wire()  # kept: it is read several times a byte

    def send(self, data: bytes, now: float) -> None:
        """Put `data` of the tester on the wire, after the bytes that it is still sending."""
        self.advance(now)
        if self.adapter.kind.supplied:
            self._tester.transmit(data, now)
            self._next = self._next_on_wire()

    def send_break(self, seconds: float, now: float) -> None:
        """Hold the line low: all bytes on it are lost, and the unit receives a break."""
        self.advance(now)
        if not self.adapter.kind.supplied:
            return
        for talker in (self._tester, self._unit):
            talker.fall_silent(now + seconds)
        self.ecu.receive_break(now + seconds)
        self._next = self._next_on_wire()
        if self.adapter.kind.echo:
            self.adapter.hear(0x00, now + seconds)

    def advance(self, now: float) -> None:
        """Run the wire up to `now`."""
        while (time := self._next) <= now:
            self._at = time
            if self._tester.next_end() <= time:
                self._through(self._tester, self._unit)
            elif self._unit.next_end() <= time:
                self._through(self._unit, self._tester)
            else:
                self._let_ecu_talk(time)
            if not self.ecu.on and self._unit.queue:
                self._unit.fall_silent(time)
            self._next = self._next_on_wire()
        self.adapter.tick(now)

    def take(self, now: float) -> tuple[bytes, float]:
        """Return the bytes that the tester got by `now`, and the time of the last."""
        self.advance(now)
        return self.adapter.take(now)

    def next_event(self) -> float:
        """Return when something happens next, on the wire or in the adapter."""
        return min(self._next, self.adapter.next_event())

    def _next_on_wire(self) -> float:
        return min(self._tester.next_end(), self._unit.next_end(), self._ecu_due())

    def _ecu_due(self) -> float:
        due = self.ecu.next_transmission()
        if due < inf:
            # D2: a unit does not begin while anything is sent, by itself too: a response
            # that a fault delayed or doubled is on the wire longer than the unit knows.
            due = self._tester.silent_from(max(due, self._unit.free_at, self._at))
        return min(due, self.ecu.next_change())

    def _let_ecu_talk(self, time: float) -> None:
        wire = self.ecu.transmit(time)
        if wire:
            for sent in self.fault_injector.respond(wire):
                self._unit.transmit(sent.data, time + sent.delay)

    def _through(self, talker: _Talker, other: _Talker) -> None:
        byte = talker.queue.popleft()
        value = byte.value & other.overlapping(byte)
        talker.last = byte
        self.bytes_carried += 1
        if talker is self._tester:
            self.ecu.receive(bytes([value]), byte.end)
            if self.adapter.kind.echo:
                self.adapter.hear(self.fault_injector.echo(value), byte.end)
        elif self.adapter.kind.supplied:
            self.adapter.hear(value, byte.end)
