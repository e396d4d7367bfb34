"""One K-Line wire with a virtual unit on it and a tester's adapter at its end (§1, D1, D2).

A byte takes 10 bits. Two bytes sent at the same time damage each other: the line carries the AND of
the two (low wins). Time advances a byte at a time: two bytes that overlap at all are both received
as their AND, which is coarser than bits but hides no collision.

The adapter echoes or does not; delivers bytes at once or in lumps by a USB latency timer (FT232:
16 ms by default, 62 bytes a packet); and needs a 12 V supply.

The caller gives the time: `advance(now)` runs the wire forward, and no method sleeps.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import ceil, inf
from random import Random

from mikas.virtual.ecu import VirtualEcu
from mikas.virtual.fault_injector import FaultInjector
from mikas.virtual.rates import seen

PACKET = 62  # bytes that an FT232 delivers without waiting for its timer


@dataclass(frozen=True, slots=True)
class AdapterKind:
    """The adapter's properties. `latency` in seconds: 0 delivers every byte at once."""

    echo: bool = True
    latency: float = 0.0
    supplied: bool = True  # False: no 12 V, so neither the wire nor an echo comes through


SHORTEST_STALL = 1 / 6  # of the longest


class Stalls:
    """Pauses of a network or a busy computer between the tester and the wire (D14).

    About every `every` seconds (0: never) no byte passes, in either direction, for up to `longest`
    seconds; nothing is lost. Seeded. Times must not run back.
    """

    def __init__(self, every: float = 0.0, longest: float = 0.18, *, seed: int = 0) -> None:
        self.every = every
        self.longest = longest
        self.total: float = 0.0
        """Seconds of all stalls so far."""
        self._random = Random(seed)
        self._begin = self._end = -inf

    def passed(self, time: float) -> float:
        """Return when a byte that comes at `time` passes: at once, or at the end of the stall."""
        if not self.every:
            return time
        if self._end == -inf:
            self._schedule(time)
        while time >= self._end:
            self._schedule(self._end)
        return self._end if time >= self._begin else time

    def _schedule(self, after: float) -> None:
        self._begin = after + self.every * self._random.uniform(0.5, 1.5)
        length = self.longest * self._random.uniform(SHORTEST_STALL, 1)
        self._end = self._begin + length
        self.total += length


class Adapter:
    """The receiving half of an adapter: bytes in from the wire, lumps out."""

    def __init__(self, kind: AdapterKind, stalls: Stalls | None = None) -> None:
        self.kind = kind
        self.stalls: Stalls = stalls or Stalls()
        self._pending = bytearray()
        self._ready: deque[tuple[float, bytes]] = deque()
        self._tick_at = inf  # when the latency timer expires, if bytes wait

    def receive(self, value: int, time: float) -> None:
        """Receive a byte of the wire that ended at `time`."""
        if not self.kind.latency:
            self._ready.append((self.stalls.passed(time), bytes([value])))
            return
        self.tick(time)
        self._pending.append(value)
        if len(self._pending) >= PACKET:
            self._flush(time)
        elif len(self._pending) == 1:
            # The timer runs always, also without bytes.
            self._tick_at = max(time, ceil(time / self.kind.latency) * self.kind.latency)

    def tick(self, now: float) -> None:
        """Expire the latency timer if it is due by `now`."""
        if self._pending and self._tick_at <= now:
            self._flush(self._tick_at)

    def _flush(self, time: float) -> None:
        self._ready.append((self.stalls.passed(time), bytes(self._pending)))
        self._pending.clear()
        self._tick_at = inf

    def next_event(self) -> float:
        """Return when the tester gets the next bytes."""
        return self._ready[0][0] if self._ready else self._tick_at

    def collect_received(self, now: float) -> tuple[bytes, float]:
        """Return the bytes that the tester got by `now`, and the time of the last."""
        self.tick(now)
        data, time = bytearray(), now
        while self._ready and self._ready[0][0] <= now:
            time, lump = self._ready.popleft()
            data += lump
        return bytes(data), time


@dataclass(slots=True)
class _Byte:
    start: float
    end: float
    value: int


class Transmitter:
    """The bytes that one end has put on the wire, in order, and the last one that has passed."""

    def __init__(self, byte_time: float) -> None:
        self.byte_time = byte_time
        self.queue: deque[_Byte] = deque()
        self.last: _Byte | None = None
        self.free_at: float = -inf

    def transmit(self, data: bytes, start: float, pause: float = 0.0) -> None:
        """Put `data` on the wire, with `pause` seconds between two bytes."""
        start = max(start, self.free_at)
        for value in data:
            self.free_at = start + self.byte_time
            self.queue.append(_Byte(start, self.free_at, value))
            start = self.free_at + pause

    def next_end(self) -> float:
        return self.queue[0].end if self.queue else inf

    def overlapping(self, byte: _Byte) -> int:
        """Return the AND of its bytes that overlap `byte`; FF, the idle line, if none does."""
        value = 0xFF
        if self.last and self.last.end > byte.start and self.last.start < byte.end:
            value &= self.last.value
        for other in self.queue:
            if other.start >= byte.end:
                break
            if other.end > byte.start:
                value &= other.value
        return value

    def idle_from(self, time: float) -> float:
        """Return `time` if idle then, else the end of the bytes that follow each other."""
        if time >= self.free_at:
            return time
        for byte in self.queue:
            if byte.start > time:
                break
            time = max(time, byte.end)
        return time

    def clear(self, free_at: float) -> None:
        """Drop pending bytes; the next byte can begin at `free_at`."""
        self.queue.clear()
        self.free_at = free_at


class Bus:
    """The wire. `send`, `send_break` and `collect_received` are the tester's side."""

    def __init__(
        self,
        ecu: VirtualEcu,
        *,
        adapter: AdapterKind | None = None,
        fault_injector: FaultInjector | None = None,
        stalls: Stalls | None = None,
    ) -> None:
        self.ecu = ecu
        self.baud: int = ecu.baud  # of the adapter
        self.byte_time: float = 10 / ecu.baud
        self.fault_injector: FaultInjector = fault_injector or FaultInjector()
        self.adapter: Adapter = Adapter(adapter or AdapterKind(), stalls)
        self.bytes_carried: int = 0
        self.tester: Transmitter = Transmitter(self.byte_time)
        self.unit: Transmitter = Transmitter(self.byte_time)
        self._break_end = -inf
        self._at = -inf  # time of the latest event
        self._next = self._next_on_wire()  # cached: read several times a byte

    def send(self, data: bytes, now: float) -> None:
        """Put `data` of the tester on the wire, after the bytes that it is still sending."""
        self.advance(now)
        start = self.adapter.stalls.passed(now)
        if self.adapter.kind.supplied:
            self.tester.transmit(data, start)
            self._next = self._next_on_wire()
        else:  # they take their time, and go nowhere
            self.tester.free_at = max(start, self.tester.free_at) + len(data) * self.byte_time

    def set_baud(self, baud: int) -> None:
        """Set the adapter to this rate; a unit of another one and it receive each other wrongly."""
        self.baud, self.byte_time = baud, 10 / baud
        self.tester.byte_time = self.byte_time

    @property
    def sending_until(self) -> float:
        """When the adapter will have sent all bytes of the tester."""
        return self.tester.free_at

    def send_break(self, seconds: float, now: float) -> None:
        """Hold the line low: all bytes on it are lost, and the unit receives a break."""
        self.advance(now)
        if not self.adapter.kind.supplied:
            return
        # A break within a longer one ends with that.
        end = self._break_end = max(now + seconds, self._break_end)
        for transmitter in (self.tester, self.unit):
            transmitter.clear(end)
        self.ecu.receive_break(end)
        self._next = self._next_on_wire()
        if self.adapter.kind.echo:
            self.adapter.receive(0x00, end)

    def drop_unsent(self, now: float) -> None:
        """Drop the tester's bytes that the adapter has not sent: the tester has gone."""
        self.advance(now)
        self.tester.clear(now)
        self._next = self._next_on_wire()

    def advance(self, now: float) -> None:
        """Run the wire up to `now`."""
        while (time := self._next) <= now:
            self._at = time
            if self.tester.next_end() <= time:
                self._deliver(self.tester, self.unit)
            elif self.unit.next_end() <= time:
                self._deliver(self.unit, self.tester)
                if not self.tester.queue:
                    self._deliver_rest(min(now, self.ecu.next_change()))
            elif wire := self.ecu.transmit(time):
                pause = self.ecu.responder.quirks.inter_byte
                for sent in self.fault_injector.respond(wire):
                    self.unit.transmit(sent.data, time + sent.delay, pause)
            if not self.ecu.on and self.unit.queue:
                self.unit.clear(time)
            self._next = self._next_on_wire()
        self.adapter.tick(now)

    def collect_received(self, now: float) -> tuple[bytes, float]:
        """Return the bytes that the tester got by `now`, and the time of the last."""
        self.advance(now)
        return self.adapter.collect_received(now)

    def next_event(self) -> float:
        """Return the time of the next event on the wire or in the adapter."""
        return min(self._next, self.adapter.next_event())

    def _next_on_wire(self) -> float:
        return min(self.tester.next_end(), self.unit.next_end(), self._ecu_due())

    def _ecu_due(self) -> float:
        due = self.ecu.next_transmission()
        if due < inf:
            # D2: the unit does not begin while either end sends: a response that a fault
            # delayed or doubled is on the wire longer than the unit knows.
            due = self.tester.idle_from(max(due, self.unit.free_at, self._at))
        return min(due, self.ecu.next_change())

    def _deliver(self, transmitter: Transmitter, other: Transmitter) -> None:
        byte = transmitter.queue.popleft()
        value = byte.value & other.overlapping(byte)
        transmitter.last = byte
        self.bytes_carried += 1
        if transmitter is self.tester:
            if heard := bytes(seen(value, self.baud, self.ecu.baud)):
                self.ecu.receive(heard, byte.end)
            if self.adapter.kind.echo:
                self.adapter.receive(self.fault_injector.echo(value), byte.end)
        elif self.adapter.kind.supplied:
            for each in seen(value, self.ecu.baud, self.baud):
                self.adapter.receive(each, byte.end)

    def _deliver_rest(self, until: float) -> None:
        """Deliver the unit's bytes that end by `until`, the tester's last one having ended.

        The same as `_deliver` for each: until then nothing but the supply changes.
        """
        unit, queue = self.unit, self.unit.queue
        while queue and queue[0].end <= until:
            unit.last = byte = queue.popleft()
            self._at = byte.end
            self.bytes_carried += 1
            if self.adapter.kind.supplied:
                for each in seen(byte.value, self.ecu.baud, self.baud):
                    self.adapter.receive(each, byte.end)


VERSION = b"ELM327 v1.5"
LONGEST_LINE = 64  # bytes; the rest of a line is dropped
_RETURN = 0x0D
_END = b"\r\r>"


class Elm327(Bus):
    """A wire with an ELM327 instead of an adapter: the wrong tool, which the tester must recognize.

    An ELM327 reads bytes as lines of text; none reaches the unit. Factory settings: 9600 baud,
    every character echoed, `?` to an unknown line. Not simulated: OBD requests, which no Mikas
    understands, and all settings but the echo.
    """

    def __init__(self, ecu: VirtualEcu) -> None:
        super().__init__(ecu)
        self._line = bytearray()
        self._echoes = True
        self._out: deque[tuple[float, int]] = deque()
        self._received_at = -inf  # the end of the last byte from the tester
        self._free_at = -inf  # the end of its own last byte

    def send(self, data: bytes, now: float) -> None:
        for value in data:
            self._received_at = max(now, self._received_at) + self.byte_time
            self._receive(value)

    def send_break(self, seconds: float, now: float) -> None:
        """Discard pending bytes: the ELM327 does not know a break."""
        self._out = deque(byte for byte in self._out if byte[0] <= now)
        self._received_at = self._free_at = now + seconds
        self._line.clear()

    @property
    def sending_until(self) -> float:
        return self._received_at

    def drop_unsent(self, now: float) -> None:
        self.send_break(0.0, now)

    def advance(self, now: float) -> None:
        """Do nothing: the wire is not driven."""

    def collect_received(self, now: float) -> tuple[bytes, float]:
        data, time = bytearray(), now
        while self._out and self._out[0][0] <= now:
            time, value = self._out.popleft()
            data.append(value)
        return bytes(data), time

    def next_event(self) -> float:
        return self._out[0][0] if self._out else inf

    def _receive(self, value: int) -> None:
        if value == 0:
            return  # an ELM327 ignores zeros as noise
        if self._echoes:
            self._transmit(bytes([value]))
        if value == _RETURN:
            self._transmit(self._execute(bytes(self._line)) + _END)
            self._line.clear()
        elif len(self._line) < LONGEST_LINE:
            self._line.append(value)

    def _execute(self, line: bytes) -> bytes:
        match line.replace(b" ", b"").upper():
            case b"ATZ":
                self._echoes = True
                return b"\r\r" + VERSION
            case b"ATI":
                return VERSION
            case b"ATE0" | b"ATE1" as switch:
                self._echoes = switch == b"ATE1"
                return b"OK"
        return b"?"

    def _transmit(self, text: bytes) -> None:
        for value in text:
            self._free_at = max(self._received_at, self._free_at) + self.byte_time
            self._out.append((self._free_at, value))
