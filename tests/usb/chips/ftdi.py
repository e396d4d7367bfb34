"""FTDI's chips, from the FT8U232AM to the FT-X, by `ftdi_sio` of Linux.

Every packet to the host begins with two bytes of status, and comes when it is full, with the event
character, or when the latency timer runs out, even with nothing in it. The divisor of a rate has a
fraction of eighths, in bits that lie apart: the third is in the index, for the chips whose requests
name a port in its high byte.

Not modelled: bit banging, the EEPROM's contents, flow control, a receiver that is shut off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

from usb.chips.device import BULK, IN, Device, Endpoint, Handshake, Identity, Interface, Setup
from usb.chips.uart import Damage, Form, Line, Uart

_RESET, _MODEM, _FLOW, _RATE, _DATA, _STATUS, _EVENT, _ERROR = range(8)
_SET_LATENCY, _GET_LATENCY, _READ_EEPROM = 0x09, 0x0A, 0x90
_BREAK = 1 << 14
_CLEAR_TO_SEND, _TRANSMITTER_EMPTY = 0x10, 0x60
_EIGHTHS = (0, 4, 2, 1, 3, 5, 6, 7)
"""What the three bits of the fraction stand for."""
_FLAGS = {
    Damage.OVERRUN: 0x02, Damage.PARITY: 0x04, Damage.FRAMING: 0x08, Damage.BREAK: 0x10,
}  # fmt: skip
STATUS = 2  # bytes at the head of each packet
LATENCY = 0.016  # s, of a chip that was plugged in


@dataclass(frozen=True, slots=True)
class Kind:
    """`ports`: how many a chip has. `names_port`: its requests have the port in the index.

    `fractions`: how many of the three bits it knows. `is_fast`: high speed, with a second clock of
    120 MHz.
    """

    pid: int
    release: int
    product: str
    fractions: int = 3
    has_latency: bool = True
    names_port: bool = False
    is_fast: bool = False
    ports: int = 1
    buffer: int = 256


KINDS = {
    "FT232AM": Kind(0x6001, 0x0200, "FT8U232AM", fractions=2, has_latency=False, buffer=384),
    "FT232BM": Kind(0x6001, 0x0400, "USB <-> Serial", buffer=384),
    "FT232R": Kind(0x6001, 0x0600, "FT232R USB UART"),
    "FT231X": Kind(0x6015, 0x1000, "FT230X Basic UART", names_port=True, buffer=512),
    "FT232H": Kind(0x6014, 0x0900, "Single RS232-HS", names_port=True, is_fast=True, buffer=1024),
    "FT2232C": Kind(0x6010, 0x0500, "Dual RS232", names_port=True, ports=2, buffer=384),
}


class Ftdi(Device):
    """`idles`: send packets of status alone; a guest under emulation drowns in them."""

    def __init__(self, kind: Kind, lines: Sequence[Line], serial: str = "") -> None:
        self.kind = kind
        size = 512 if kind.is_fast else 64
        interfaces = [
            Interface(
                (Endpoint(IN | 2 * n + 1, BULK, size), Endpoint(2 * n + 2, BULK, size)),
                classes=(0xFF, 0xFF, 0xFF),
            )
            for n in range(kind.ports)
        ]
        identity = Identity(
            0x0403, kind.pid, kind.release, kind.product, "FTDI", serial,
            usb=0x0200, classes=(0, 0, 0), size=64 if kind.is_fast else 8,
        )  # fmt: skip
        uarts = [Uart(line, kind.buffer) for line in lines]
        super().__init__(identity, interfaces, uarts)
        self.latency = [LATENCY] * kind.ports
        self.idles = True
        self._expires = [0.0] * kind.ports
        self._events: list[int | None] = [None] * kind.ports  # what ends the wait for more bytes
        for uart in uarts:
            uart.set(form=Form())

    def _port(self, index: int) -> int:
        """Return the port that a request names, from 0."""
        named = index & 0xFF if self.kind.names_port else 0
        return min(max(named, 1), self.kind.ports) - 1

    def _answer(self, setup: Setup, data: bytes) -> bytes | Handshake:
        kind, request, value, index, _ = setup
        number = self._port(index)
        uart = self.uarts[number]
        match kind, request:
            case 0x40, 0x00:
                if value in {0, 1}:
                    uart.purge()
            case 0x40, 0x01:
                uart.set_modem(
                    dtr=bool(value & 1) if value & 0x100 else None,
                    rts=bool(value & 2) if value & 0x200 else None,
                )
            case 0x40, 0x03:
                uart.set(rate=self.rate(value, index))
            case 0x40, 0x04:
                parity, stop = "NOEMS"[value >> 8 & 7], (1, 1.5, 2)[value >> 11 & 3]
                uart.set(form=Form(value & 0xFF, parity, stop))
                uart.hold(bool(value & _BREAK))
            case 0x40, 0x09 if self.kind.has_latency:
                self.latency[number] = max(1, value & 0xFF) / 1000
                uart.log.append(f"latency {value & 0xFF}")
            case 0x40, 0x06:
                self._events[number] = value & 0xFF if value & 0x100 else None
            case 0x40, 0x02 | 0x07:
                pass
            case 0xC0, 0x05:
                return bytes((_CLEAR_TO_SEND | 1, _TRANSMITTER_EMPTY))
            case 0xC0, 0x0A if self.kind.has_latency:
                return bytes((round(self.latency[number] * 1000),))
            case 0xC0, 0x90:
                return b"\xff\xff"
            case _:
                return Handshake.STALL
        return b""

    def rate(self, value: int, index: int) -> float:
        """Return the rate that a divisor in `value` and `index` stands for."""
        high = index >> 8 if self.kind.names_port else index
        known = (1 << self.kind.fractions) - 1
        eighths = _EIGHTHS[(value >> 14 | (high & 1) << 2) & known]
        whole = value & 0x3FFF
        divisor = whole + eighths / 8
        if divisor in {0, 1}:  # they stand for 1 and 1.5
            divisor = 1 + divisor / 2
        clock = 12e6 if self.kind.is_fast and high & 2 else 3e6
        return clock / divisor

    def _take(self, address: int, data: bytes) -> None:
        self.uarts[(address - 1) // 2].send(data)

    def _give(self, address: int, now: float) -> bytes | Handshake:
        number = (address & 15) // 2
        uart, size = self.uarts[number], self.endpoint(address).size
        is_due = now >= self._expires[number] and (self.idles or len(uart))
        is_due = is_due or self._events[number] in uart
        if len(uart) < size - STATUS and not is_due:
            return Handshake.NAK
        self._expires[number] = now + self.latency[number]
        characters = uart.take(size - STATUS)
        status = _TRANSMITTER_EMPTY
        for character in characters:
            for damage, flag in _FLAGS.items():
                status |= flag if damage in character.damage else 0
        return bytes((_CLEAR_TO_SEND | 1, status, *(it.value for it in characters)))

    def wake_at(self, now: float) -> float:
        if any(event in uart for event, uart in zip(self._events, self.uarts, strict=True)):
            return now
        waiting = [
            at
            for at, uart in zip(self._expires, self.uarts, strict=True)
            if self.idles or len(uart)
        ]
        return min(waiting, default=inf)
