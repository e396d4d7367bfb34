"""CH340 and CH341 of WCH, by `ch341` of Linux; the CH343 and CH9102 are in `cdc_acm`.

A register of the prescaler, one of the divisor, one of the line. Bit 7 of the prescaler says
whether a packet is held back until it has 32 bytes; up to version 27 it says the opposite. Those
have no register of the line either, and send 8N1.

`CH340 without break` is the kind of which Linux says that reading register 05 stalls: it knows no
break, and its prescaler is limited. Not modelled: the parallel modes, flow control.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

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
from usb.chips.uart import Form, Line, Uart

CLOCK = 48e6
BREAK, PRESCALER, DIVISOR, LINE, LINE_2 = 0x05, 0x12, 0x13, 0x18, 0x25
_SENDS, _RECEIVES, _NO_BREAK, _AT_ONCE = 0x40, 0x80, 0x01, 0x80
PACKET = 32
OLD = 0x27  # the last version whose bit 7 means the opposite
_LINE_FROM = 0x30  # the first version with a register of the line


@dataclass(frozen=True, slots=True)
class Kind:
    vid: int
    pid: int
    version: int
    has_break: bool = True
    product: str = "USB Serial"


KINDS = {
    "CH340": Kind(0x1A86, 0x7523, 0x31),
    "CH340 old": Kind(0x1A86, 0x7523, OLD),
    "CH340 without break": Kind(0x1A86, 0x7523, 0x31, has_break=False),
    "CH340K": Kind(0x1A86, 0x7522, 0x31),
    "CH341": Kind(0x1A86, 0x5523, 0x30, product="USB2.0-Serial"),
    "CH341 old": Kind(0x4348, 0x5523, 0x25, product="USB2.0-Serial"),
}


class Ch34x(Device):
    def __init__(self, kind: Kind, line: Line, serial: str = "") -> None:
        self.kind = kind
        ends = (
            Endpoint(IN | 2, BULK, PACKET),
            Endpoint(2, BULK, PACKET),
            Endpoint(IN | 1, INTERRUPT, 8, interval=1),
        )
        identity = Identity(kind.vid, kind.pid, 0x0264, kind.product, serial=serial)
        super().__init__(identity, [Interface(ends, classes=(0xFF, 1, 2))], [Uart(line, 256)])
        self.registers = {BREAK: 1, PRESCALER: 0, DIVISOR: 0, LINE: 0xC3, LINE_2: 0}
        self.registers |= {0x06: 0xFF, 0x07: 0xEE}  # the inputs of the modem

    def _answer(self, setup: Setup, data: bytes) -> bytes | Handshake:
        kind, request, value, index, _ = setup
        numbers = value & 0xFF, value >> 8
        match kind, request:
            case 0xC0, 0x5F:
                return bytes((self.kind.version, 0))
            case 0xC0, 0x95:
                if not self.kind.has_break and BREAK in numbers:
                    return Handshake.STALL
                return bytes(self.registers.get(number, 0) for number in numbers)
            case 0x40, 0x9A:
                self._write(zip(numbers, (index & 0xFF, index >> 8), strict=True))
            case 0x40, 0xA1:
                if value & 0x80:  # the line and the rate in one request
                    names = LINE, PRESCALER, DIVISOR
                    self._write(zip(names, (value >> 8, index & 0xFF, index >> 8), strict=True))
            case 0x40, 0xA4:
                self.uart.set_modem(dtr=not value & 0x20, rts=not value & 0x40)
            case _:
                return Handshake.STALL
        return b""

    def _write(self, values: Iterable[tuple[int, int]]) -> None:
        self.registers.update(values)
        self.uart.set(rate=self.rate, form=self.form)
        if self.kind.has_break:
            self.uart.hold(not self.registers[BREAK] & _NO_BREAK)

    @property
    def rate(self) -> float:
        prescaler = self.registers[PRESCALER]
        exponent, halved = prescaler & 3, prescaler >> 2 & 1
        if not self.kind.has_break and exponent < 3:
            halved = 0  # "limited prescaler"
        return CLOCK / (2 ** (12 - 3 * exponent - halved) * (256 - self.registers[DIVISOR]))

    @property
    def form(self) -> Form:
        line = self._line
        parity = {0x00: "O", 0x10: "E", 0x20: "M", 0x30: "S"}[line & 0x30] if line & 8 else "N"
        return Form(5 + (line & 3), parity, 2 if line & 4 else 1)

    @property
    def _line(self) -> int:
        return self.registers[LINE] if self.kind.version >= _LINE_FROM else 0xC3

    @property
    def holds_back(self) -> bool:
        """Whether a packet waits until it is full."""
        is_set = bool(self.registers[PRESCALER] & _AT_ONCE)
        return is_set if self.kind.version <= OLD else not is_set

    def _take(self, address: int, data: bytes) -> None:
        if self._line & _SENDS:
            self.uart.send(data)

    def _give(self, address: int, now: float) -> bytes | Handshake:
        if not self._line & _RECEIVES:
            self.uart.purge()
        if self.holds_back and len(self.uart) < PACKET:
            return Handshake.NAK
        return super()._give(address, now)
