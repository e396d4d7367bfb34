"""Prolific's chips, by `pl2303` of Linux: PL2303H (“01”), HX, HXD, TA, TB, HXN.

A host tells them apart by the descriptors, and by whether an old request is answered: an HXN
refuses it. The rate is a number where the chip knows that rate, else a divisor with bit 31 set, in
one of two forms; an HXN takes any number. An HX that gets a number which it does not know goes to
9600.

`clone` is the copy of an HXD that knows neither “get line” nor a break, `unknown` a chip
whose release no driver knows: Linux refuses it.
"""

from __future__ import annotations

import struct
from collections import deque
from dataclasses import dataclass

from usb.chips.cdc_acm import CODING, coding
from usb.chips.device import (
    BULK,
    IN,
    INTERRUPT,
    Device,
    Endpoint,
    Handshake,
    Identity,
    Interface,
    Setup,
)
from usb.chips.uart import Damage, Form, Line, Uart

KNOWN_RATES = {
    75, 150, 300, 600, 1200, 1800, 2400, 3600, 4800, 7200, 9600, 14400, 19200, 28800, 38400, 57600,
    115200, 230400, 460800, 614400, 921600, 1228800, 2457600, 3000000, 6000000,
}  # fmt: skip
NOTICE = IN | 1
_BASE = 12e6 * 32
_FLAGS = {
    Damage.BREAK: 0x04, Damage.FRAMING: 0x10, Damage.PARITY: 0x20, Damage.OVERRUN: 0x40,
}  # fmt: skip
_CLEAR_TO_SEND = 0x80


@dataclass(frozen=True, slots=True)
class Kind:
    """`divisors`: "", "old" (HX) or "new" (TA, TB); `start`: what register 2 must get, if any."""

    pid: int
    usb: int
    release: int
    divisors: str = "old"
    is_hxn: bool = False
    start: int | None = 0x44
    size: int = 64
    has_break: bool = True
    product: str = "USB-Serial Controller"


KINDS = {
    "PL2303 01": Kind(0x2303, 0x0110, 0x0300, start=0x24, size=8),
    "PL2303HX": Kind(0x2303, 0x0110, 0x0300),
    "PL2303HXD": Kind(0x2303, 0x0110, 0x0400, product="USB-Serial Controller D"),
    "PL2303TA": Kind(0x2303, 0x0200, 0x0300, "new"),
    "PL2303TB": Kind(0x2303, 0x0200, 0x0500, "new"),
    "PL2303GC": Kind(0x23A3, 0x0200, 0x0100, "", is_hxn=True, start=None),
    "PL2303GT": Kind(0x23C3, 0x0200, 0x0305, "", is_hxn=True, start=None),
    "PL2303 clone": Kind(0x2303, 0x0110, 0x0400, has_break=False),
    "PL2303 unknown": Kind(0x2303, 0x0200, 0x0999),
}


class Pl2303(Device):
    def __init__(self, kind: Kind, line: Line, serial: str = "") -> None:
        self.kind = kind
        ends = (
            Endpoint(NOTICE, INTERRUPT, 10, interval=1),
            Endpoint(2, BULK, 64),
            Endpoint(IN | 3, BULK, 64),
        )
        identity = Identity(
            0x067B, kind.pid, kind.release, kind.product, "Prolific Technology Inc.", serial,
            usb=kind.usb, classes=(0, 0, 0), size=kind.size,
        )  # fmt: skip
        super().__init__(identity, [Interface(ends)], [Uart(line, 256)])
        self.notices[NOTICE] = deque()
        self.registers: dict[int, int] = {}
        self._coding = CODING.pack(9600, 0, 0, 8)
        self.uart.set(9600, Form())
        self.uart.heard = self._notice

    @property
    def is_started(self) -> bool:
        """Whether the driver's start-up was that of this type.

        Else nothing comes through: stricter than what is known of silicon.
        """
        return self.kind.start is None or self.registers.get(2) == self.kind.start

    def _answer(self, setup: Setup, data: bytes) -> bytes | Handshake:
        kind, request, value, index, _ = setup
        read, write = (0x81, 0x80) if self.kind.is_hxn else (0x01, 0x01)
        match kind, request:
            case 0xC0, number if number == read:
                return bytes((self._register(value),))
            case 0x40, number if number == write:
                self._write(value, index)
            case 0xA1, 0x21 if self.kind.has_break:
                return self._coding
            case 0x21, 0x20 if len(data) == CODING.size:
                self._coding = data
                rate, form = coding(data)
                self.uart.set(self._real_rate(rate), form)
            case 0x21, 0x22:
                self.uart.set_modem(dtr=bool(value & 1), rts=bool(value & 2))
            case 0x21, 0x23 if self.kind.has_break:
                self.uart.hold(bool(value))
            case _:
                return Handshake.STALL
        return b""

    def _register(self, value: int) -> int:
        if self.kind.is_hxn:
            return self.registers.get(value, 0)
        return {0x8484: 0x02, 0x8383: 0x00}.get(value, self.registers.get(value & 0x7F, 0))

    def _write(self, number: int, value: int) -> None:
        self.registers[number & 0xFF] = value & 0xFF
        resets = {0x07} if self.kind.is_hxn else {8, 9}  # of the pipes
        if number in resets:
            self.uart.purge()

    def _real_rate(self, rate: int) -> float:
        """Return the rate that the chip makes of the number in a line coding."""
        if not rate & 1 << 31:
            is_known = not self.kind.divisors or rate in KNOWN_RATES
            return float(rate if is_known else 9600)
        low = rate & 0xFFFF
        if self.kind.divisors == "new":
            exponent = (low >> 12 & 0b1110) | rate >> 16 & 1
            return _BASE / ((low & 0x7FF) * 2**exponent)
        if self.kind.divisors == "old":
            return _BASE / ((low & 0x1FF) * 4 ** (low >> 9 & 7))
        return 9600.0

    def _notice(self, damage: Damage) -> None:
        if flags := sum(flag for kind, flag in _FLAGS.items() if kind in damage):
            state = struct.pack("<BBHHH", 0xA1, 0x20, 0, 0, 2) + bytes((_CLEAR_TO_SEND | flags, 0))
            self.notices[NOTICE].append(state)
        self.ready()

    def _take(self, address: int, data: bytes) -> None:
        if self.is_started:
            self.uart.send(data)

    def _give(self, address: int, now: float) -> bytes | Handshake:
        if not self.is_started:
            self.uart.purge()
        return super()._give(address, now)
