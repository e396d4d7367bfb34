"""Silicon Labs' chips, by `cp210x` of Linux and their AN205: CP2101 to CP2105, CP2108, CP2102N.

The requests name the interface of a port. CP2101 to CP2103 know a list of rates, and take
the nearest by that list's limits: 10400 becomes 14400. The later ones divide 48 MHz.

Errors of single characters come in the data only after “embed events”, behind an escape; else as a
sum by “get comm status”. Until a port is enabled, nothing goes through. The CP2108 of one
release gives the line control with its bytes swapped.

Not modelled: flow control but that zeros can be stripped, GPIO, the EEPROM.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass, field

from usb.chips.device import BULK, IN, Device, Endpoint, Handshake, Identity, Interface, Setup
from usb.chips.uart import Character, Damage, Form, Line, Uart

LISTED = (
    (300, 300), (600, 600), (1200, 1200), (1800, 1800), (2400, 2400), (4000, 4000), (4803, 4800),
    (7207, 7200), (9612, 9600), (14428, 14400), (16062, 16000), (19250, 19200), (28912, 28800),
    (38601, 38400), (51558, 51200), (56280, 56000), (58053, 57600), (64111, 64000),
    (77608, 76800), (117028, 115200), (129347, 128000), (156868, 153600), (237832, 230400),
    (254234, 250000), (273066, 256000), (491520, 460800), (567138, 500000), (670254, 576000),
    (1 << 32, 921600),
)  # fmt: skip
"""The highest request for each rate of a CP2101, CP2102 or CP2103 (AN205, table 1)."""
_STRIPS_ZEROS = 0x08  # of the second word of the flow control
_PART, _VERSION_2N, _SETUP_2N = 0x370B, 0x0010, 0x000E
_ERRORS = {
    Damage.BREAK: 0x01, Damage.FRAMING: 0x02, Damage.OVERRUN: 0x04, Damage.PARITY: 0x10,
}  # fmt: skip
_LINE_STATUS = {
    Damage.OVERRUN: 0x02, Damage.PARITY: 0x04, Damage.FRAMING: 0x08, Damage.BREAK: 0x10,
}  # fmt: skip


def _flags(damage: Damage, by: dict[Damage, int]) -> int:
    return sum(flag for kind, flag in by.items() if kind in damage)


@dataclass(frozen=True, slots=True)
class Kind:
    pid: int
    part: int
    product: str
    ports: int = 1
    is_listed: bool = False
    swaps_line: bool = False
    buffer: int = 576


KINDS = {
    "CP2101": Kind(0xEA60, 0x01, "CP2101 USB to UART Bridge Controller", is_listed=True),
    "CP2102": Kind(0xEA60, 0x02, "CP2102 USB to UART Bridge Controller", is_listed=True),
    "CP2103": Kind(0xEA60, 0x03, "CP2103 USB to UART Bridge Controller", is_listed=True),
    "CP2104": Kind(0xEA60, 0x04, "CP2104 USB to UART Bridge Controller"),
    "CP2105": Kind(0xEA70, 0x05, "CP2105 Dual USB to UART Bridge Controller", ports=2),
    "CP2108": Kind(0xEA71, 0x08, "CP2108 Quad USB to UART Bridge Controller", 4, True, True),
    "CP2102N": Kind(0xEA60, 0x20, "CP2102N USB to UART Bridge Controller"),
}


@dataclass(slots=True)
class _Port:
    """What a port's driver has set and the UART does not know."""

    enabled: bool = False
    rate: int = 115200
    line: int = 0x0800
    flow: bytes = bytes(16)
    characters: bytes = bytes(6)
    escape: int = 0
    damage: Damage = Damage.NONE
    waiting: bytearray = field(default_factory=bytearray)
    """Data for the host, with the events in them."""


class Cp210x(Device):
    def __init__(self, kind: Kind, lines: Sequence[Line], serial: str = "") -> None:
        self.kind = kind
        interfaces = [
            Interface((Endpoint(IN | n + 1, BULK, 64), Endpoint(n + 1, BULK, 64)))
            for n in range(kind.ports)
        ]
        identity = Identity(
            0x10C4, kind.pid, 0x0100, kind.product, "Silicon Labs", serial,
            classes=(0, 0, 0), size=64,
        )  # fmt: skip
        super().__init__(identity, interfaces, [Uart(line, kind.buffer) for line in lines])
        self.ports = [_Port() for _ in range(kind.ports)]

    @property
    def backlog(self) -> int:
        return len(self.uart) + len(self.ports[0].waiting)

    def _answer(self, setup: Setup, data: bytes) -> bytes | Handshake:
        if setup.name == (0xC0, 0xFF):
            return self._vendor(setup.value)
        if setup.kind & 0x1F != 1 or setup.index & 0xFF >= self.kind.ports:
            return Handshake.STALL  # only an interface is asked
        number = setup.index & 0xFF
        if setup.kind & IN:
            return self._get(setup.request, self.uarts[number], self.ports[number])
        return self._set(setup, data, self.uarts[number], self.ports[number])

    def _vendor(self, value: int) -> bytes | Handshake:
        is_2n = self.kind.part == 0x20
        if value == _PART:
            return bytes((self.kind.part,))
        if value == _VERSION_2N and is_2n:
            return b"\x01\x00\x08"
        return bytes(677) if value == _SETUP_2N and is_2n else Handshake.STALL

    def _get(self, request: int, uart: Uart, port: _Port) -> bytes | Handshake:
        match request:
            case 0x04:
                order = ">H" if self.kind.swaps_line else "<H"
                return struct.pack(order, port.line)
            case 0x08:
                return bytes((0x30 | uart.dtr | uart.rts << 1,))
            case 0x0E:
                return port.characters
            case 0x0F:
                return bytes(66)
            case 0x10:
                errors, port.damage = _flags(port.damage, _ERRORS), Damage.NONE
                return struct.pack("<IIIIBBB", errors, 0, len(uart), 0, 0, 0, 0)
            case 0x14:
                return port.flow
            case 0x1D:
                return struct.pack("<I", round(uart.settings.rate))
        return Handshake.STALL

    def _set(self, setup: Setup, data: bytes, uart: Uart, port: _Port) -> bytes | Handshake:
        value = setup.value
        match setup.request:
            case 0x00:
                port.enabled = bool(value & 1)
                uart.log.append(f"enabled={port.enabled:d}")
                if not port.enabled:
                    uart.purge()
                    port.waiting.clear()
            case 0x03:
                port.line = value
                uart.set(form=_form(value))
            case 0x05:
                uart.hold(bool(value & 1))
            case 0x07:
                uart.set_modem(
                    dtr=bool(value & 1) if value & 0x100 else None,
                    rts=bool(value & 2) if value & 0x200 else None,
                )
            case 0x12:
                if value & 0x0A:
                    uart.purge()
                    port.waiting.clear()
            case 0x13 if len(data) == 16:
                port.flow = data
            case 0x15:
                port.escape = value & 0xFF
            case 0x19 if len(data) == 6:
                port.characters = data
            case 0x1E if len(data) == 4:
                port.rate = int.from_bytes(data, "little")
                uart.set(rate=self.real_rate(port.rate))
            case 0x06 | 0x09 | 0x0A | 0x0B | 0x0D:
                pass
            case _:
                return Handshake.STALL
        return b""

    def real_rate(self, asked: int) -> float:
        """Return the rate that the chip makes of `asked`."""
        if self.kind.is_listed:
            return float(next(rate for most, rate in LISTED if asked <= most))
        prescaler = 4 if asked <= 365 else 1
        return 48e6 / (2 * prescaler * round(48e6 / (2 * prescaler * max(asked, 1))))

    def _take(self, address: int, data: bytes) -> None:
        number = address - 1
        if self.ports[number].enabled:
            self.uarts[number].send(data)

    def _give(self, address: int, now: float) -> bytes | Handshake:
        number = (address & 15) - 1
        uart, port, size = self.uarts[number], self.ports[number], self.endpoint(address).size
        for character in uart.take(size):
            port.damage |= character.damage
            if port.enabled and not (character.value == 0 and port.flow[4] & _STRIPS_ZEROS):
                port.waiting += _embedded(character, port.escape)
        packet = bytes(port.waiting[:size])
        del port.waiting[:size]
        return packet or Handshake.NAK


def _form(line: int) -> Form:
    return Form(line >> 8, "NOEMS"[line >> 4 & 15], (1, 1.5, 2)[line & 15])


def _embedded(character: Character, escape: int) -> bytes:
    """Return `character` for the host, with its errors if there is an `escape`."""
    value, damage = character
    if escape and damage:
        return bytes((escape, 1, _flags(damage, _LINE_STATUS), value))
    if escape and value == escape:
        return bytes((escape, 0))
    return bytes((value,))
