"""An ELM327 in place of a K-Line adapter: the wrong tool, which the tester has to recognize.

An ELM327 reads bytes as lines of text and puts none of them on the wire. Factory settings: 9600
baud, every character echoed, `?` to an unknown line. Not simulated: OBD requests, which no Mikas
understands, and all settings but the echo.
"""

from __future__ import annotations

from collections import deque
from math import inf

from mikas.virtual.bus import Bus
from mikas.virtual.ecu import VirtualEcu

VERSION = b"ELM327 v1.5"
LONGEST_LINE = 64  # bytes; the rest of a line is dropped
_RETURN = 0x0D
_END = b"\r\r>"


class Elm327(Bus):
    """A wire with an ELM327 at the tester's end; no byte of the tester reaches the unit."""

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

    def advance(self, now: float) -> None:
        """Do nothing: the wire is not driven."""

    def take(self, now: float) -> tuple[bytes, float]:
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
