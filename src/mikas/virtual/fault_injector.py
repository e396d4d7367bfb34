"""Line faults on purpose: a bad ground, a second transmitter or a slow unit.

Each fault applies to a response by chance (seeded, so a run can be repeated to the byte) or when a
test queues it. The faults concern the ECU's transmissions and the line, never the tester.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from random import Random

from mikas.errors import usage_error
from mikas.framing import encode


class LineFault(Enum):
    """A fault of one response."""

    LOST = "lost"
    """Never sent."""
    LATE = "late"
    """Sent after the tester's time-out."""
    DAMAGED = "damaged"
    """One bit of one byte differs."""
    CUT = "cut"
    """The end is missing."""
    MISSING_BYTE = "missing-byte"
    """One byte in the middle is missing."""
    DOUBLED = "doubled"
    """Sent twice."""
    FOREIGN = "foreign"
    """Another transmitter's valid frame instead."""
    NOISE = "noise"
    """Stray bytes before the response."""
    ECHO = "bad-echo"
    """One byte of the next request's echo differs."""


LATE_BY = 0.7  # s, more than the 500 ms of D14


@dataclass(frozen=True, slots=True)
class Sent:
    """Bytes to put on the wire, `delay` seconds after the response is due."""

    data: bytes
    delay: float = 0.0


class FaultInjector:
    """Applies faults to responses: queued ones first, else by the `rates` of chance, 0 … 1."""

    def __init__(
        self,
        rates: Mapping[LineFault, float] | None = None,
        *,
        seed: int = 0,
        late_by: float = LATE_BY,
    ) -> None:
        self.rates: dict[LineFault, float] = dict(rates or {})
        self.late_by = late_by
        self.count: int = 0
        self._random = Random(seed)
        self.queued: deque[LineFault | None] = deque()
        self.spoils_next_echo: bool = False

    def next(self, *faults: LineFault | None) -> None:
        """Queue faults for the next responses, in order; None: no fault."""
        self.queued.extend(faults)

    def respond(self, wire: bytes) -> list[Sent]:
        """Return the bytes on the line instead of the response `wire`."""
        fault = self._choose()
        if fault is None:
            return [Sent(wire)]
        self.count += 1
        at = self._random.randrange(len(wire))
        match fault:
            case LineFault.LOST:
                return []
            case LineFault.LATE:
                return [Sent(wire, self.late_by)]
            case LineFault.DAMAGED:
                flipped = wire[at] ^ 1 << self._random.randrange(8)
                return [Sent(wire[:at] + bytes([flipped]) + wire[at + 1 :])]
            case LineFault.CUT:
                return [Sent(wire[: max(1, at)])]
            case LineFault.MISSING_BYTE:
                return [Sent(wire[:at] + wire[at + 1 :])]
            case LineFault.DOUBLED:
                return [Sent(wire), Sent(wire, 0.003)]
            case LineFault.FOREIGN:
                return [Sent(encode(bytes(len(wire))))]  # longer, so never this request's
            case LineFault.NOISE:
                return [Sent(self._random.randbytes(1 + at % 4)), Sent(wire)]
            case LineFault.ECHO:
                self.spoils_next_echo = True
                return [Sent(wire)]

    def echo(self, value: int) -> int:
        """Return the echo of the byte `value`."""
        if self.spoils_next_echo:
            self.spoils_next_echo = False
            return value ^ 0x10
        return value

    def _choose(self) -> LineFault | None:
        if self.queued:
            return self.queued.popleft()
        for fault, rate in self.rates.items():
            if self._random.random() < rate:
                return fault
        return None


def parse_rates(words: Mapping[str, str]) -> dict[LineFault, float]:
    """Return the rates of texts like `{"damaged": "0.01"}`. Raises `UsageError`."""
    rates = {}
    for name, value in words.items():
        try:
            rate = float(value)
            fault = LineFault(name)
        except ValueError:
            rate = -1.0
        if not 0 <= rate <= 1:
            kinds = ", ".join(t.value for t in LineFault)
            raise usage_error(
                f"“{name}={value}” is not a line fault: KIND=RATE, rate 0 … 1, kinds: {kinds}",
                f"«{name}={value}» — не помеха: ВИД=ДОЛЯ, доля 0 … 1, виды: {kinds}",
            )
        rates[fault] = rate
    return rates
