"""What the drivers of Linux ask of a chip, as requests: the models have to understand them.

Each function opens a port at a rate with 8N1, as the driver of that name does in Debian 12's
kernel, in the same order. The numbers of a rate are calculated as that driver calculates them.
"""

from __future__ import annotations

import struct

from usb.chips.cdc_acm import CODING
from usb.chips.device import IN, Device, Handshake, Setup
from usb.chips.named import driver_of
from usb.chips.pl2303 import KNOWN_RATES
from usb.chips.uart import Line, Settings


class Far(Line):
    """The far end of the line: what came from the chip."""

    def __init__(self) -> None:
        self.data = b""
        self.settings: Settings | None = None
        self.breaks: list[bool] = []

    def send(self, data: bytes, settings: Settings) -> None:
        self.data += data
        self.settings = settings

    def hold(self, low: bool) -> None:
        self.breaks.append(low)


class Host:
    """The requests of a driver to a chip."""

    def __init__(self, device: Device) -> None:
        self.device = device

    def set(self, kind: int, request: int, value: int = 0, index: int = 0, data: bytes = b""):
        answer = self.device.control(Setup(kind, request, value, index, len(data)), data)
        assert answer == b"", f"{kind:02X} {request:02X} {value:04X} {index:04X}: {answer}"

    def get(self, kind: int, request: int, value: int = 0, index: int = 0, length: int = 64):
        answer = self.ask(kind, request, value, index, length)
        assert isinstance(answer, bytes), f"{kind:02X} {request:02X} {value:04X}: {answer}"
        return answer

    def ask(self, kind: int, request: int, value: int = 0, index: int = 0, length: int = 64):
        return self.device.control(Setup(kind, request, value, index, length))

    def bulk(self, direction: int, port: int = 0) -> int:
        """Return the address of a port's endpoint; `direction`: IN or 0."""
        ends = [it for it in self.device.endpoints if it.kind == 2 and it.address & IN == direction]
        return ends[port].address

    def write(self, data: bytes) -> None:
        assert self.device.out(self.bulk(0), data) is None

    def read(self, now: float = 0.0) -> bytes | Handshake:
        return self.device.packet(self.bulk(IN), now)

    def notice(self, address: int) -> bytes | Handshake:
        return self.device.packet(address, 0.0)


def opened(device: Device, name: str, rate: int = 9600) -> Host:
    """Open the first port of `device`, which is a `name`, as its driver does."""
    host = Host(device)
    {
        "ftdi_sio": _ftdi_sio, "ch341": _ch341, "cp210x": _cp210x, "pl2303": _pl2303,
        "cdc_acm": _cdc_acm,
    }[driver_of(name)](host, rate)  # fmt: skip
    return host


def set_break(host: Host, name: str, on: bool) -> None:
    """Begin or end a break as the driver does; a clone may refuse it."""
    match driver_of(name):
        case "ftdi_sio":
            port = 1 if host.device.kind.names_port else 0
            host.set(0x40, 0x04, 0x0008 | on << 14, port)
        case "ch341":
            low, line = host.get(0xC0, 0x95, 0x1805, 0, 2)
            pair = (line & ~0x40 if on else line | 0x40, low & ~1 if on else low | 1)
            host.set(0x40, 0x9A, 0x1805, pair[0] << 8 | pair[1])
        case "cp210x":
            host.set(0x41, 0x05, on)
        case _:
            host.set(0x21, 0x23, 0xFFFF if on else 0)


def _ftdi_sio(host: Host, rate: int) -> None:
    kind = host.device.kind
    port = 1 if kind.names_port else 0
    if kind.has_latency:
        host.get(0xC0, 0x0A, 0, port)
        host.set(0x40, 0x09, 1, port)
    host.set(0x40, 0x00, 0, port)
    host.set(0x40, 0x04, 0x0008, port)
    value, index = ftdi_divisor(rate, kind.fractions, fast=kind.is_fast)
    host.set(0x40, 0x03, value, index << 8 | port if kind.names_port else index)
    host.set(0x40, 0x02, 0, port)
    host.set(0x40, 0x01, 0x0303, port)


def ftdi_divisor(rate: int, fractions: int = 3, *, fast: bool = False) -> tuple[int, int]:
    """Return the low and the high half of the divisor for `rate`."""
    if fast and rate >= 1200:
        eighths = round(8 * 120e6 / (10 * rate))
        return _with_fraction(eighths, (0, 3, 2, 4, 1, 5, 6, 7), high=2)
    if fractions == 2:
        eighths = 24_000_000 // rate
        eighths += eighths & 7 == 7
        return _with_fraction(eighths, (0, 3, 2, 2, 1, 1, 1, 1))
    return _with_fraction(round(24e6 / rate), (0, 3, 2, 4, 1, 5, 6, 7))


def _with_fraction(eighths: int, codes: tuple[int, ...], high: int = 0) -> tuple[int, int]:
    divisor = eighths >> 3 | codes[eighths & 7] << 14
    divisor = {1: 0, 0x4001: 1}.get(divisor, divisor)
    return divisor & 0xFFFF, divisor >> 16 | high


def _ch341(host: Host, rate: int) -> None:
    version, _ = host.get(0xC0, 0x5F, 0, 0, 2)
    host.set(0x40, 0xA1)
    is_limited = host.ask(0xC0, 0x95, 0x0005, 0, 2) is Handshake.STALL
    for each in (9600, rate):
        value = ch341_divisor(each, is_limited) | (0x80 if version > 0x27 else 0)
        host.set(0x40, 0x9A, 0x1312, value)
        if version >= 0x30:
            host.set(0x40, 0x9A, 0x2518, 0x00C3)
        host.set(0x40, 0xA4, 0xFF9F)  # DTR and RTS, inverted


def ch341_divisor(rate: int, is_limited: bool) -> int:
    """Return what the registers of prescaler and divisor get."""
    exponent = next(it for it in (3, 2, 1, 0) if rate > 48e6 // (_clock_divisor(it, 1) * 512))
    halved = 1
    clock = _clock_divisor(exponent, halved)
    divisor = 48_000_000 // (clock * rate)
    if divisor < 9 or divisor > 255 or (exponent < 3 and is_limited):
        divisor, clock, halved = divisor // 2, clock * 2, 0
    exact = 48e6 / clock
    if exact / divisor - rate >= rate - exact / (divisor + 1):
        divisor += 1
    if halved and divisor % 2 == 0:
        divisor, halved = divisor // 2, 0
    return (0x100 - divisor) << 8 | halved << 2 | exponent


def _clock_divisor(exponent: int, halved: int) -> int:
    return 1 << (12 - 3 * exponent - halved)


def _cp210x(host: Host, rate: int) -> None:
    part = host.get(0xC0, 0xFF, 0x370B, 0, 1)[0]
    host.get(0xC1, 0x04, 0, 0, 2)
    host.set(0x41, 0x00, 1)
    asked = rate if part not in {1, 2, 3} else host.device.real_rate(rate)
    host.set(0x41, 0x1E, data=struct.pack("<I", int(asked)))
    host.set(0x41, 0x03, 0x0800)
    flow = bytearray(host.get(0xC1, 0x14, 0, 0, 16))
    host.set(0x41, 0x13, data=bytes(flow))
    host.set(0x41, 0x07, 0x0303)


def _pl2303(host: Host, rate: int) -> None:
    kind = host.device.kind
    if not kind.is_hxn:
        for value in (0x8484, (0x0404, 0), 0x8484, 0x8383, 0x8484, (0x0404, 1), 0x8484, 0x8383):
            if isinstance(value, tuple):
                host.set(0x40, 0x01, *value)
            else:
                host.get(0xC0, 0x01, value, 0, 1)
        is_old = kind.size != 64
        for number, value in ((0, 1), (1, 0), (2, 0x24 if is_old else 0x44)):
            host.set(0x40, 0x01, number, value)
        if not is_old:
            host.set(0x40, 0x01, 8)
            host.set(0x40, 0x01, 9)
    else:
        host.set(0x40, 0x80, 0x07, 0x03)
    host.ask(0xA1, 0x21, 0, 0, 7)  # a clone refuses it
    host.set(0x21, 0x20, data=CODING.pack(pl2303_rate(rate, kind.divisors), 0, 0, 8))
    host.set(0x21, 0x22, 3)


def pl2303_rate(rate: int, divisors: str) -> int:
    """Return the number that stands for `rate` in a line coding."""
    if rate in KNOWN_RATES or not divisors:
        return rate
    mantissa, exponent = int(12e6 * 32) // rate, 0
    if divisors == "new":
        while mantissa >= 2048:
            mantissa, exponent = mantissa >> 1, exponent + 1
        return 1 << 31 | (exponent & 1) << 16 | (exponent & ~1) << 12 | mantissa
    while mantissa >= 512:
        mantissa, exponent = mantissa >> 2, exponent + 1
    return 1 << 31 | exponent << 9 | mantissa


def _cdc_acm(host: Host, rate: int) -> None:
    host.get(0xA1, 0x21, 0, 0, 7)
    host.set(0x21, 0x20, data=CODING.pack(rate, 0, 0, 8))
    host.set(0x21, 0x22, 3)
