"""The class for modems (CDC ACM): the CH343 and CH9102 of WCH, and boards that follow the standard.

Two interfaces: one for the requests, with notices of errors at its interrupt endpoint, and one for
the data. A break has a length in ms, or goes on until it is ended (FFFF). Whether a device knows
it stands in its descriptors.
"""

from __future__ import annotations

import struct
from collections import deque
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
from usb.chips.uart import Damage, Form, Line, Uart

CODING = struct.Struct("<IBBB")  # rate, stop bits, parity, bits
STOPS, PARITIES = (1, 1.5, 2), "NOEMS"
_LINE_CODING, _SENDS_BREAK = 0x02, 0x04  # capabilities
NOTICE = 0x81
_FLAGS = {
    Damage.BREAK: 0x04, Damage.FRAMING: 0x10, Damage.PARITY: 0x20, Damage.OVERRUN: 0x40,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Kind:
    vid: int
    pid: int
    release: int
    product: str
    maker: str = ""
    has_break: bool = True
    size: int = 64


KINDS = {
    "CH343": Kind(0x1A86, 0x55D3, 0x0445, "USB Single Serial"),
    "CH9102": Kind(0x1A86, 0x55D4, 0x0444, "USB Single Serial"),
    "CDC ACM": Kind(0x04D8, 0x000A, 0x0100, "CDC RS-232 Emulation", "Microchip"),
    "CDC ACM without break": Kind(0x16C0, 0x0483, 0x0279, "USB Serial", "Tiny", has_break=False),
}


def coding(data: bytes) -> tuple[int, Form]:
    """Return the rate and the form in a line coding."""
    rate, stop, parity, bits = CODING.unpack(data)
    return rate, Form(bits, PARITIES[parity], STOPS[stop])


class CdcAcm(Device):
    def __init__(self, kind: Kind, line: Line, serial: str = "") -> None:
        self.kind = kind
        capabilities = _LINE_CODING | (_SENDS_BREAK if kind.has_break else 0)
        functional = bytes((
            5, 0x24, 0, 0x10, 0x01,  # header: 1.10
            5, 0x24, 1, 0, 1,  # call management: none
            4, 0x24, 2, capabilities,
            5, 0x24, 6, 0, 1,  # union: interface 1 belongs to 0
        ))  # fmt: skip
        requests = Interface((Endpoint(NOTICE, INTERRUPT, 16, interval=1),), (2, 2, 1), functional)
        data = (Endpoint(IN | 2, BULK, kind.size), Endpoint(2, BULK, kind.size))
        identity = Identity(
            kind.vid, kind.pid, kind.release, kind.product, kind.maker, serial,
            classes=(2, 0, 0), size=64,
        )  # fmt: skip
        interfaces = [requests, Interface(data, classes=(10, 0, 0))]
        super().__init__(identity, interfaces, [Uart(line, 1024)])
        self.notices[NOTICE] = deque()
        self.uart.set(115200, Form())
        self.uart.heard = self._notice
        self._coding = CODING.pack(115200, 0, 0, 8)

    def _answer(self, setup: Setup, data: bytes) -> bytes | Handshake:
        kind, request, value, _, _ = setup
        match kind, request:
            case 0x21, 0x20 if len(data) == CODING.size:
                self._coding = data
                rate, form = coding(data)
                self.uart.set(rate, form)
            case 0xA1, 0x21:
                return self._coding
            case 0x21, 0x22:
                self.uart.set_modem(dtr=bool(value & 1), rts=bool(value & 2))
            case 0x21, 0x23 if self.kind.has_break:
                self.uart.hold(bool(value))
                if value not in {0, 0xFFFF}:  # it ends by itself; a model has no clock
                    self.uart.hold(False)
            case _:
                return Handshake.STALL
        return b""

    def _notice(self, damage: Damage) -> None:
        """Tell the host of errors by a notice of the serial state."""
        if flags := sum(flag for kind, flag in _FLAGS.items() if kind in damage):
            notice = struct.pack("<BBHHHH", 0xA1, 0x20, 0, 0, 2, flags)
            self.notices[NOTICE].append(notice)
        self.ready()
