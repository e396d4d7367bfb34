"""A unit that speaks KWP2000 (ISO 14230) at 10400 baud in the place of a Mikas: a later one.

It shows what a tester of the Mikas protocol meets there: silence, until it is woken up. It keeps
to the standard's times, so a wake-up that it takes is one. After the fast wake-up (25 ms
low, 25 ms high) it answers StartCommunication; after the slow one (an address at 5 baud) it sends
55 and its key bytes. Then it answers TesterPresent and StopCommunication, and refuses all else.

Pure: the bus gives it low pulses and bytes with their times, and asks when it transmits next.
"""

from __future__ import annotations

from collections import deque
from enum import Enum
from math import inf

from mikas import kwp2000
from mikas.virtual.bus import AdapterKind, Bus
from mikas.virtual.ecu import VirtualEcu
from mikas.virtual.rates import seen

KEY_BYTES = b"\xef\x8f"
_BYTE = 10 / kwp2000.BAUD
_LOW, _FAST = 0.025, 0.05  # s of the fast wake-up: low, and from its begin to the request
_EXACT = 0.004  # s by which both may be wrong: the standard's 1 ms, and what a busy computer adds
_BIT = 0.2  # s, at 5 baud
_ADDRESS_BITS = 10
_W1, _W2, _W4 = 0.1, 0.01, 0.03  # s before 55, before each key byte, before an inverted one
_W4_LEAST, _W4_MOST = 0.025, 0.05  # s that a tester may wait with the inverted key byte
_P2 = 0.03  # s from a request to its response
_BETWEEN = 0.02  # s after which the next byte begins another request


class Wake(Enum):
    """The wake-ups that a unit takes."""

    BOTH = "kwp2000"
    FAST = "kwp2000-fast"
    SLOW = "kwp2000-slow"


class Kwp2000Unit:
    """One unit; it is asleep until a wake-up that it takes."""

    def __init__(self, wake: Wake = Wake.BOTH) -> None:
        self.wake = wake
        self.awake: bool = False
        self._answers: deque[tuple[float, bytes]] = deque()
        self._woken_at = -inf  # when the request of a fast wake-up has to begin
        self._slow: list[tuple[float, float]] = []  # low pulses since the start bit of an address
        self._address = 0
        self._key_sent = -inf  # when the second key byte ended
        self._request = bytearray()
        self._heard = -inf

    def low(self, begin: float, end: float) -> None:
        """Receive a low pulse, longer than a byte's."""
        if abs(end - begin - _LOW) <= _EXACT and not self._slow:
            self._woken_at = begin + _FAST
        else:
            self._slow.append((begin, end))

    def receive(self, value: int, end: float) -> None:
        """Receive a byte at 10400 baud, whose last bit ended at `end`."""
        begin = end - _BYTE
        if _W4_LEAST <= begin - self._key_sent <= _W4_MOST:
            self._key_sent = -inf
            if value == KEY_BYTES[1] ^ 0xFF:
                self.awake = True
                self._answers.append((end + _W4, bytes([self._address ^ 0xFF])))
            return
        if begin - self._heard > _BETWEEN:
            self._request.clear()
        fresh, self._heard = not self._request, end
        if not self.awake and fresh and abs(begin - self._woken_at) > _EXACT:
            return  # asleep
        self._request.append(value)
        message = kwp2000.decode(bytes(self._request))
        if message is not None:
            self._request.clear()
            self._answer(message, end)

    def due(self) -> float:
        """Return when it transmits next."""
        wake = self._slow[0][0] + _ADDRESS_BITS * _BIT if self._slow else inf
        return min(self._answers[0][0] if self._answers else inf, wake)

    def transmit(self, now: float) -> bytes:
        """Return the bytes whose first one begins now; empty: none is due."""
        if self._slow and now >= self._slow[0][0] + _ADDRESS_BITS * _BIT:
            self._wake_slowly()
        if not self._answers or now < self._answers[0][0]:
            return b""
        data = self._answers.popleft()[1]
        if data == KEY_BYTES[1:]:
            self._key_sent = now + _BYTE
        return data

    def _wake_slowly(self) -> None:
        """Read the address that was sent at 5 baud; answer, if it is this unit's."""
        start = self._slow[0][0]
        middles = [start + (number + 0.5) * _BIT for number in range(_ADDRESS_BITS)]
        bits = [int(not any(low <= at < high for low, high in self._slow)) for at in middles]
        self._slow.clear()
        self._address = sum(bit << place for place, bit in enumerate(bits[1:9]))
        whole = not bits[0] and bits[9]
        known = self._address in (kwp2000.OBD, kwp2000.ENGINE)
        if self.wake is not Wake.FAST and whole and known:
            at = start + _ADDRESS_BITS * _BIT + _W1
            for value in (kwp2000.SYNC, *KEY_BYTES):
                self._answers.append((at, bytes([value])))
                at += _BYTE + _W2

    def _answer(self, message: kwp2000.KwpMessage, end: float) -> None:
        if message.target not in (None, kwp2000.ENGINE, kwp2000.OBD):
            return
        service = message.data[:1]
        starts = service == kwp2000.START and not self.awake and self.wake is not Wake.SLOW
        if starts:
            data, self.awake = bytes([service[0] + kwp2000.POSITIVE]) + KEY_BYTES, True
        elif not self.awake:
            return
        elif service in (kwp2000.PRESENT, kwp2000.STOP):
            data, self.awake = bytes([service[0] + kwp2000.POSITIVE]), service != kwp2000.STOP
        else:
            data = bytes([kwp2000.REFUSED]) + service + b"\x11"  # the service is not supported
        target = kwp2000.TESTER if message.source is None else message.source
        self._answers.append((end + _P2, kwp2000.encode(data, target, kwp2000.ENGINE)))


class Kwp2000Bus(Bus):
    """A wire with a `Kwp2000Unit` in the place of the Mikas. Not simulated: collisions, stalls."""

    def __init__(
        self, ecu: VirtualEcu, unit: Kwp2000Unit, *, adapter: AdapterKind | None = None
    ) -> None:
        super().__init__(ecu, adapter=adapter)
        self.kwp2000 = unit
        self._coming: deque[tuple[float, int]] = deque()  # bytes for the unit, by their ends
        self._going: deque[tuple[float, int]] = deque()
        self._free_at = -inf

    def send(self, data: bytes, now: float) -> None:
        self.advance(now)
        at = max(now, self._free_at)
        for value in data:
            at += self.byte_time
            self._coming.append((at, value))
        self._free_at = at

    def send_break(self, seconds: float, now: float) -> None:
        self.advance(now)
        self.kwp2000.low(now, now + seconds)
        if self.adapter.kind.echo:
            self.adapter.receive(0x00, now + seconds)

    @property
    def sending_until(self) -> float:
        return self._free_at

    def drop_unsent(self, now: float) -> None:
        self.advance(now)
        self._coming.clear()
        self._free_at = now

    def advance(self, now: float) -> None:
        while (time := self._next_here()) <= now:
            if self._coming and self._coming[0][0] <= time:
                end, value = self._coming.popleft()
                for each in seen(value, self.baud, kwp2000.BAUD):
                    self.kwp2000.receive(each, end)
                if self.adapter.kind.echo:
                    self.adapter.receive(value, end)
            elif self._going and self._going[0][0] <= time:
                end, value = self._going.popleft()
                for each in seen(value, kwp2000.BAUD, self.baud):
                    self.adapter.receive(each, end)
            else:
                for place, value in enumerate(self.kwp2000.transmit(time), 1):
                    self._going.append((time + place * _BYTE, value))
        self.adapter.tick(now)

    def _next_here(self) -> float:
        ends = (queue[0][0] for queue in (self._coming, self._going) if queue)
        return min((*ends, self.kwp2000.due()), default=inf)

    def next_event(self) -> float:
        return min(self._next_here(), self.adapter.next_event())
