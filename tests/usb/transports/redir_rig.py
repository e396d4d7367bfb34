"""Chip models for QEMU: a "usb-host" of usbredir at the other end of its `usb-redir` device.

    qemu … -chardev socket,id=usb0,fd=N -device usb-redir,chardev=usb0,bus=usb.0,port=1

Protocol 0.7 of usbredir (docs/usb-redirection-protocol.md there): little endian, packed. Only what
a serial chip needs: no isochronous transfers, no streams of bulk endpoints. QEMU asks for one
packet or many with a transfer; it ends with a short packet, or when it is full.
"""

from __future__ import annotations

import asyncio
import struct
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf

from usb.chips.device import IN, Device, Handshake, Setup

HELLO, CONNECT, DISCONNECT, RESET, INTERFACES, ENDPOINTS = range(6)
SET_CONFIGURATION, GET_CONFIGURATION, CONFIGURATION, SET_ALTERNATE, GET_ALTERNATE = range(6, 11)
ALTERNATE, START_INTERRUPT, STOP_INTERRUPT, INTERRUPT_STATUS = 11, 15, 16, 17
CANCEL, DISCONNECTED = 21, 24
CONTROL_PACKET, BULK_PACKET, INTERRUPT_PACKET = 100, 101, 103
OK, CANCELLED, _, _, STALL, _, BABBLE = range(7)
_VERSION, _FILTER, _ACKNOWLEDGED, _SIZES, _WIDE, _LONG = (1 << bit for bit in range(1, 7))
CAPABILITIES = _VERSION | _FILTER | _ACKNOWLEDGED | _SIZES | _WIDE | _LONG
_FULL, _HIGH = 1, 2  # speeds
_NO_ENDPOINT = 0xFF
_SET_CONTROL = struct.Struct("<BBBBHHH")
_NAME = b"mikas chip model"


@dataclass(slots=True)
class _Transfer:
    """A bulk IN transfer that waits for packets."""

    number: int
    length: int
    data: bytearray = field(default_factory=bytearray)


class UsbRedir(asyncio.Protocol):
    """One USB socket of a guest. All methods run on the loop of its `Lines`."""

    def __init__(self) -> None:
        self.device: Device | None = None
        self._loop = asyncio.get_running_loop()
        self._transport: asyncio.WriteTransport | None = None
        self._data = b""
        self._capabilities = 0
        self._is_greeted = self._is_connected = False
        self._waiting: dict[int, deque[_Transfer]] = {}
        self._held: dict[int, Callable[[], None]] = {}
        """By number of a transfer that is never answered: what to do when it is cancelled."""
        self._receives: set[int] = set()  # interrupt endpoints
        self._numbers = 0
        self._timer: asyncio.TimerHandle | None = None
        self._left: asyncio.Future[None] | None = None

    # -- the test's side ---------------------------------------------------------------------------

    def plug(self, device: Device) -> None:
        device.ready = self._serve
        self.device = device
        if self._is_greeted:
            self._connect()

    async def pull(self) -> None:
        """Pull the device out; return when QEMU has let it go."""
        if self.device is None:
            return
        self.device.ready = lambda: None
        self.device = None
        self._forget()
        if self._is_connected:
            self._is_connected = False
            self._left = self._loop.create_future()
            self._send(DISCONNECT, 0)
            await self._left

    def close(self) -> None:
        """Leave QEMU's socket."""
        self._forget()
        if self._transport is not None:
            self._transport.close()

    def _forget(self) -> None:
        self._waiting.clear()
        self._held.clear()
        self._receives.clear()
        if self._timer is not None:
            self._timer.cancel()

    # -- the socket --------------------------------------------------------------------------------

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.WriteTransport)
        self._transport = transport

    def connection_lost(self, error: Exception | None) -> None:
        self._forget()
        self._transport = None
        if self._left is not None and not self._left.done():
            self._left.set_result(None)

    def data_received(self, data: bytes) -> None:
        self._data += data
        while True:
            form = "<IIQ" if self._has(_WIDE) else "<III"
            size = struct.calcsize(form)
            if len(self._data) < size:
                return
            kind, length, number = struct.unpack_from(form, self._data)
            if len(self._data) < size + length:
                return
            body, self._data = self._data[size : size + length], self._data[size + length :]
            self._receive(kind, number, body)
            self._serve()

    def _has(self, capability: int) -> bool:
        return bool(self._capabilities & capability)

    def _send(self, kind: int, number: int, body: bytes = b"") -> None:
        form = "<IIQ" if self._has(_WIDE) else "<III"
        if self._transport is not None:
            self._transport.write(struct.pack(form, kind, len(body), number) + body)

    # -- what QEMU says ----------------------------------------------------------------------------

    def _receive(self, kind: int, number: int, body: bytes) -> None:
        device = self.device
        if kind == HELLO:
            self._greet(body)
        elif kind == DISCONNECTED:
            if self._left is not None and not self._left.done():
                self._left.set_result(None)
        elif kind == CANCEL:
            self._cancel(number)
        elif device is None:
            return
        elif kind == CONTROL_PACKET:
            self._control(device, number, body)
        elif kind == BULK_PACKET:
            self._bulk(device, number, body)
        elif kind == RESET:
            device.reset()
        elif kind in {SET_CONFIGURATION, GET_CONFIGURATION}:
            if kind == SET_CONFIGURATION:
                device.reset()
                self._describe(device)
            self._send(CONFIGURATION, number, bytes((OK, 1)))
        elif kind in {SET_ALTERNATE, GET_ALTERNATE}:
            self._send(ALTERNATE, number, bytes((OK, body[0], 0)))
        elif kind in {START_INTERRUPT, STOP_INTERRUPT}:
            (self._receives.add if kind == START_INTERRUPT else self._receives.discard)(body[0])
            self._send(INTERRUPT_STATUS, number, bytes((OK, body[0])))

    def _greet(self, body: bytes) -> None:
        theirs = struct.unpack_from("<I", body, 64)[0] if len(body) >= 68 else 0
        self._send(HELLO, 0, _NAME.ljust(64, b"\0") + struct.pack("<I", CAPABILITIES))
        self._capabilities = theirs & CAPABILITIES
        self._is_greeted = True
        if self.device is not None:
            self._connect()

    def _connect(self) -> None:
        device = self.device
        assert device is not None
        self._describe(device)
        it = device.identity
        is_fast = any(end.size > 64 for end in device.endpoints)
        self._send(
            CONNECT, 0,
            struct.pack(
                "<BBBBHHH", _HIGH if is_fast else _FULL, *it.classes, it.vid, it.pid, it.release
            ),
        )  # fmt: skip
        self._is_connected = True

    def _describe(self, device: Device) -> None:
        columns = list(zip(*(it.classes for it in device.interfaces), strict=True))
        columns.insert(0, tuple(range(len(device.interfaces))))
        count = struct.pack("<I", len(device.interfaces))
        self._send(INTERFACES, 0, count + b"".join(bytes(it).ljust(32, b"\0") for it in columns))
        kinds, intervals = bytearray([_NO_ENDPOINT]) * 32, bytearray(32)
        interfaces, sizes = bytearray(32), [0] * 32
        for at in (0, 16):
            kinds[at], sizes[at] = 0, device.identity.size
        for number, interface in enumerate(device.interfaces):
            for end in interface.endpoints:
                at = (end.address & IN) >> 3 | end.address & 15
                kinds[at], intervals[at], sizes[at] = end.kind, end.interval, end.size
                interfaces[at] = number
        rows = bytes(kinds) + bytes(intervals) + bytes(interfaces)
        self._send(ENDPOINTS, 0, rows + struct.pack("<32H", *sizes))

    def _control(self, device: Device, number: int, body: bytes) -> None:
        end, request, kind, _, value, index, length = _SET_CONTROL.unpack_from(body)

        def answer(status: int, data: bytes = b"") -> None:
            size = len(data) if kind & IN else length if status == OK else 0
            head = _SET_CONTROL.pack(end, request, kind, status, value, index, size)
            self._send(CONTROL_PACKET, number, head + data)

        setup = Setup(kind, request, value, index, length)
        given = device.control(setup, body[_SET_CONTROL.size :])
        if given is Handshake.NAK:
            self._held[number] = lambda: answer(CANCELLED)
        elif isinstance(given, bytes):
            answer(OK, given)
        else:
            answer(STALL)

    def _bulk(self, device: Device, number: int, body: bytes) -> None:
        address, _, length, _ = struct.unpack_from("<BBHI", body)
        data = body[8:]
        if self._has(_LONG):
            length |= struct.unpack_from("<H", body, 8)[0] << 16
            data = body[10:]
        if address & IN:
            self._waiting.setdefault(address, deque()).append(_Transfer(number, length))
            return
        match device.out(address, data):
            case None:
                self._bulk_done(number, address, OK, length)
            case Handshake.NAK:
                self._held[number] = lambda: self._bulk_done(number, address, CANCELLED, 0)
            case Handshake.STALL:
                self._bulk_done(number, address, STALL, 0)

    def _bulk_done(
        self, number: int, address: int, status: int, length: int, data: bytes = b""
    ) -> None:
        head = struct.pack("<BBHI", address, status, length & 0xFFFF, 0)
        if self._has(_LONG):
            head += struct.pack("<H", length >> 16)
        self._send(BULK_PACKET, number, head + data)

    def _cancel(self, number: int) -> None:
        if held := self._held.pop(number, None):
            held()
        for address, transfers in self._waiting.items():
            for transfer in [it for it in transfers if it.number == number]:
                transfers.remove(transfer)
                data = bytes(transfer.data)
                self._bulk_done(number, address, CANCELLED, len(data), data)

    # -- packets -----------------------------------------------------------------------------------

    def _serve(self) -> None:
        """Give what the device has to the transfers that wait, and come back when it will have."""
        device = self.device
        if device is None:
            return
        for address in self._receives:
            while isinstance(notice := device.packet(address, self._loop.time()), bytes):
                self._numbers += 1
                head = struct.pack("<BBH", address, OK, len(notice))
                self._send(INTERRUPT_PACKET, self._numbers, head + notice)
        for address, transfers in self._waiting.items():
            self._fill(device, address, transfers)
        self._wake_later(device)

    def _fill(self, device: Device, address: int, transfers: deque[_Transfer]) -> None:
        size = device.endpoint(address).size
        while transfers:
            packet = device.packet(address, self._loop.time())
            if packet is Handshake.NAK:
                return
            transfer = transfers[0]
            status = STALL
            if isinstance(packet, bytes):
                transfer.data += packet
                is_over = len(packet) > size or len(transfer.data) > transfer.length
                status = BABBLE if is_over else OK
                if status == OK and len(packet) == size and len(transfer.data) < transfer.length:
                    continue
            transfers.popleft()
            data = bytes(transfer.data[: transfer.length])
            self._bulk_done(transfer.number, address, status, len(data), data)

    def _wake_later(self, device: Device) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if any(self._waiting.values()):
            at = device.wake_at(self._loop.time())
            if at < inf:
                self._timer = self._loop.call_at(at, self._serve)
