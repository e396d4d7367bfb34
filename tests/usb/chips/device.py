"""A USB device at the level of requests and packets (USB 2.0, chapter 9).

A transport gives the requests and the data of a host, and asks for packets whenever the host waits
for one; `ready` is called when there may be one. A packet of an endpoint's size is followed by
another one of the same transfer; a shorter one, also an empty one, ends the transfer.
"""

from __future__ import annotations

import struct
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from math import inf
from typing import NamedTuple

from usb.chips.faults import Faults
from usb.chips.uart import Uart

IN = 0x80
BULK, INTERRUPT = 2, 3
_DEVICE, _CONFIGURATION, _STRING, _INTERFACE, _ENDPOINT = 1, 2, 3, 4, 5
_GET_STATUS, _CLEAR_FEATURE, _GET_DESCRIPTOR, _GET_CONFIGURATION = 0, 1, 6, 8
_SET_CONFIGURATION = 9
ENGLISH = b"\x04\x03\x09\x04"


class Handshake(Enum):
    """Instead of data."""

    NAK = "nothing now: ask again"
    STALL = "refused"


class Setup(NamedTuple):
    """The head of a control transfer."""

    kind: int
    request: int
    value: int = 0
    index: int = 0
    length: int = 0

    @property
    def name(self) -> tuple[int, int]:
        """`kind` and `request`, by which a chip tells its requests apart."""
        return self.kind, self.request


@dataclass(frozen=True, slots=True)
class Endpoint:
    address: int
    kind: int
    size: int
    interval: int = 0

    def descriptor(self) -> bytes:
        return struct.pack(
            "<BBBBHB", 7, _ENDPOINT, self.address, self.kind, self.size, self.interval
        )


@dataclass(frozen=True, slots=True)
class Interface:
    """`classes`: class, subclass, protocol; `extra`: descriptors of the class."""

    endpoints: tuple[Endpoint, ...]
    classes: tuple[int, int, int] = (0xFF, 0, 0)
    extra: bytes = b""


@dataclass(frozen=True, slots=True)
class Identity:
    """`release` is bcdDevice, `usb` bcdUSB, `size` that of endpoint 0."""

    vid: int
    pid: int
    release: int
    product: str
    maker: str = ""
    serial: str = ""
    usb: int = 0x0110
    classes: tuple[int, int, int] = (0xFF, 0, 0)
    size: int = 8


class Device(ABC):
    """A plugged chip; each kind of chip answers `_answer`, takes `_take` and gives `_give`."""

    def __init__(
        self, identity: Identity, interfaces: Sequence[Interface], uarts: Sequence[Uart]
    ) -> None:
        self.identity, self.interfaces, self.uarts = identity, tuple(interfaces), tuple(uarts)
        self.ready: Callable[[], None] = lambda: None
        self.faults = Faults()
        self.requests: list[tuple[Setup, bytes]] = []
        """The requests to the chip itself, without those of chapter 9."""
        self.notices: dict[int, deque[bytes]] = {}
        """What waits for the host at each interrupt endpoint."""
        self._halted: set[int] = set()
        for uart in self.uarts:
            uart.heard = lambda damage: self.ready()

    @property
    def uart(self) -> Uart:
        """The first port, or the only one."""
        return self.uarts[0]

    @property
    def backlog(self) -> int:
        """The bytes that wait for the host at the first port."""
        return len(self.uart)

    @property
    def endpoints(self) -> list[Endpoint]:
        return [each for interface in self.interfaces for each in interface.endpoints]

    def endpoint(self, address: int) -> Endpoint:
        return next(each for each in self.endpoints if each.address == address)

    # -- descriptors -------------------------------------------------------------------------------

    def device_descriptor(self) -> bytes:
        it = self.identity
        return struct.pack(
            "<BBHBBBBHHHBBBB", 18, _DEVICE, it.usb, *it.classes, it.size, it.vid, it.pid,
            it.release, 1 if it.maker else 0, 2, 3 if it.serial else 0, 1,
        )  # fmt: skip

    def configuration(self) -> bytes:
        body = b""
        for number, interface in enumerate(self.interfaces):
            count = len(interface.endpoints)
            body += struct.pack(
                "<BBBBBBBBB", 9, _INTERFACE, number, 0, count, *interface.classes, 0
            )
            body += interface.extra + b"".join(it.descriptor() for it in interface.endpoints)
        head = (9, _CONFIGURATION, 9 + len(body), len(self.interfaces), 1, 0, 0x80, 50)
        return struct.pack("<BBHBBBBB", *head) + body

    def _descriptor(self, value: int) -> bytes | Handshake:
        kind, number = value >> 8, value & 0xFF
        if kind == _DEVICE:
            return self.device_descriptor()
        if kind == _CONFIGURATION:
            return self.configuration()
        if kind == _STRING:
            texts = ("", self.identity.maker, self.identity.product, self.identity.serial)
            if number == 0:
                return ENGLISH
            if number < len(texts) and texts[number]:
                text = texts[number].encode("utf-16-le")
                return bytes((len(text) + 2, _STRING)) + text
        return Handshake.STALL

    # -- the transport's side ----------------------------------------------------------------------

    def control(self, setup: Setup, data: bytes = b"") -> bytes | Handshake:
        """Answer a control transfer; b"" where the host sends the data."""
        if not setup.kind & 0x60:
            return self._standard(setup)
        self.requests.append((setup, data))
        match self.faults.of_request(setup.request):
            case "hang":
                return Handshake.NAK
            case "stall":
                return Handshake.STALL
            case "ignore":
                return bytes(setup.length if setup.kind & IN else 0)
        answer = self._answer(setup, data)
        return answer[: setup.length] if isinstance(answer, bytes) else answer

    def out(self, address: int, data: bytes) -> Handshake | None:
        """Take `data` of the host; None is the acknowledgement."""
        if address in self._halted:
            return Handshake.STALL
        if self.faults.hangs_out:
            return Handshake.NAK
        self._take(address, data)
        return None

    def packet(self, address: int, now: float) -> bytes | Handshake:
        """Return the next packet of an IN endpoint."""
        if address in self._halted:
            return Handshake.STALL
        if waiting := self.notices.get(address):
            return waiting.popleft()
        endpoint = self.endpoint(address)
        if endpoint.kind == INTERRUPT:
            return Handshake.NAK
        if self.faults.takes_stall():
            self._halted.add(address)
            return Handshake.STALL
        if self.faults.takes_empty():
            return b""
        packet = Handshake.NAK if self.faults.hangs_in else self._give(address, now)
        return self.faults.of_in(packet, endpoint.size) if isinstance(packet, bytes) else packet

    def wake_at(self, now: float) -> float:
        """Return when there will be a packet though nothing more is received."""
        return inf

    def clear_halt(self, address: int) -> None:
        self._halted.discard(address)

    def reset(self) -> None:
        """A reset of the bus, or the configuration set anew."""
        self._halted.clear()

    def _standard(self, setup: Setup) -> bytes | Handshake:
        kind, request, value, index, length = setup
        answer: bytes | Handshake = b""
        if request == _GET_DESCRIPTOR and kind == IN:
            answer = self._descriptor(value)
        elif request == _GET_STATUS:
            answer = bytes((index & 0xFF in self._halted and kind == IN | 2, 0))
        elif request == _GET_CONFIGURATION:
            answer = b"\x01"
        elif request == _CLEAR_FEATURE and kind == 2:
            self.clear_halt(index & 0xFF)
        elif request == _SET_CONFIGURATION:
            self.reset()
        return answer[:length] if isinstance(answer, bytes) else answer

    # -- the chip's part ---------------------------------------------------------------------------

    @abstractmethod
    def _answer(self, setup: Setup, data: bytes) -> bytes | Handshake:
        """Answer a request of the class or the vendor."""

    def _take(self, address: int, data: bytes) -> None:
        """Take data of the host."""
        self.uart.send(data)

    def _give(self, address: int, now: float) -> bytes | Handshake:
        """Return the next packet of a bulk endpoint."""
        characters = self.uart.take(self.endpoint(address).size)
        return bytes(it.value for it in characters) or Handshake.NAK
