"""Chip models for programs that use `/dev/bus/usb`: Chromium's WebUSB, libusb.

The ioctls of Linux' usbfs (uapi/linux/usbdevice_fs.h) on files of `FuseFiles`. A transfer is
submitted, and reaped when it is done; the file is writable for `poll` while one waits to be reaped.
"""

from __future__ import annotations

import asyncio
import errno
import struct
from collections import deque
from dataclasses import dataclass, field
from math import inf

from usb.chips.device import IN, Device, Handshake, Setup
from usb.transports.fuse_rig import FuseFiles, Memory

_SET_INTERFACE, _SET_CONFIGURATION, _GET_DRIVER, _SUBMIT, _DISCARD = 4, 5, 8, 10, 11
_REAP, _REAP_NOW, _CLAIM, _RELEASE, _IOCTL, _RESET, _CLEAR_HALT = 12, 13, 15, 16, 18, 20, 21
_CAPABILITIES, _DISCONNECT_CLAIM = 26, 27
_DISCONNECT, _CONNECT = 22, 23  # within _IOCTL
_NAMES = {
    _SET_INTERFACE: "set interface", _SET_CONFIGURATION: "set configuration", _CLAIM: "claim",
    _RELEASE: "release", _RESET: "reset", _CLEAR_HALT: "clear halt",
}  # fmt: skip
_CONTROL = 2
_ZERO_PACKET, _REAP_AFTER_DISCONNECT = 0x01, 0x10
_POLLOUT, _POLLERR, _POLLHUP = 0x04, 0x08, 0x10
_STATUS, _ACTUAL = 4, 28  # offsets in a transfer


class Urb:
    """A submitted transfer: `struct usbdevfs_urb` in the memory of a process."""

    def __init__(self, pid: int, address: int) -> None:
        raw = Memory.read(pid, address, 56)
        self.pid, self.address = pid, address
        self.type, self.end = raw[0], raw[1]
        self.buffer, self.length = struct.unpack_from("<QI", raw, 16)
        self.data = bytearray()
        self.status = self.actual = 0


@dataclass(slots=True)
class Plugged:
    """A device in a USB socket.

    `driver`: the kernel's, if one is bound: then a claim is refused until it is detached.
    `is_detachable`: whether that is allowed. `may_open`: False is a file without rights.
    `keeps_discarded`: cancelled transfers end only when it is False again, so late ones of a
    session end in the next one. `calls` has what programs did with the file.
    """

    device: Device
    driver: str = ""
    is_detachable: bool = True
    may_open: bool = True
    keeps_discarded: bool = False
    is_gone: bool = False
    calls: list[str] = field(default_factory=list)
    detached: str = ""


class OpenDevice:
    """A program's open file of a device."""

    def __init__(self, usbfs: Usbfs, plugged: Plugged) -> None:
        self._usbfs, self.plugged = usbfs, plugged
        self.waiting: deque[Urb] = deque()
        self.done: deque[Urb] = deque()
        self._kept: list[Urb] = []
        plugged.calls.append("open")

    # -- the file ----------------------------------------------------------------------------------

    def read(self, offset: int, size: int) -> bytes:
        device = self.plugged.device
        return (device.device_descriptor() + device.configuration())[offset : offset + size]

    def poll(self) -> int:
        if self.plugged.is_gone:
            return _POLLOUT | _POLLERR | _POLLHUP
        return _POLLOUT if self.done else 0

    def close(self) -> None:
        self.plugged.calls.append("close")
        self.waiting.clear()
        self._usbfs.closed(self)

    def ioctl(self, pid: int, command: int, pointer: int) -> int:
        number, plugged = command & 0xFF, self.plugged
        if number in {_REAP, _REAP_NOW}:
            return self._reap(pid, pointer)
        if number == _DISCARD:
            return self._discard(pointer)
        if plugged.is_gone:
            return -errno.ENODEV
        if number == _SUBMIT:
            return self._submit(Urb(pid, pointer))
        if number == _CAPABILITIES:
            word = struct.pack("<I", _ZERO_PACKET | _REAP_AFTER_DISCONNECT)
            Memory.write(pid, pointer, word)
            return 0
        if number == _GET_DRIVER:
            if not plugged.driver:
                return -errno.ENODATA
            Memory.write(pid, pointer + 4, plugged.driver.encode() + b"\0")
            return 0
        if number == _IOCTL:
            return self._of_driver(pid, pointer)
        return self._manage(number, pid, pointer)

    def _manage(self, number: int, pid: int, pointer: int) -> int:
        plugged = self.plugged
        if number not in _NAMES:
            plugged.calls.append(f"ioctl {number}")
            return -errno.ENOTTY
        plugged.calls.append(_NAMES[number])
        if number == _CLAIM and plugged.driver:
            return -errno.EBUSY
        if number == _CLEAR_HALT:
            (end,) = struct.unpack("<I", Memory.read(pid, pointer, 4))
            plugged.device.clear_halt(end)
        elif number in {_RESET, _SET_CONFIGURATION}:
            plugged.device.reset()
        return 0

    def _of_driver(self, pid: int, pointer: int) -> int:
        """Detach the kernel's driver from an interface, or attach it again."""
        _, code = struct.unpack_from("<iI", Memory.read(pid, pointer, 16))
        plugged = self.plugged
        if code & 0xFF == _DISCONNECT:
            plugged.calls.append("detach")
            if not plugged.driver:
                return -errno.ENODATA
            if not plugged.is_detachable:
                return -errno.EPERM
            plugged.detached, plugged.driver = plugged.driver, ""
        elif code & 0xFF == _CONNECT:
            plugged.calls.append("attach")
            plugged.driver, plugged.detached = plugged.detached, ""
        return 0

    # -- transfers ---------------------------------------------------------------------------------

    def _submit(self, urb: Urb) -> int:
        device = self.plugged.device
        if urb.type != _CONTROL and urb.end not in {end.address for end in device.endpoints}:
            return -errno.ENOENT
        if urb.type == _CONTROL:
            self._control(device, urb)
        elif urb.end & IN:
            self.waiting.append(urb)
        else:
            data = Memory.read(urb.pid, urb.buffer, urb.length) if urb.length else b""
            answer = device.out(urb.end, data)
            if answer is Handshake.NAK:
                self.waiting.append(urb)
            elif answer is Handshake.STALL:
                self.finish(urb, -errno.EPIPE)
            else:
                self.finish(urb, 0, actual=urb.length)
        self._usbfs.serve()
        return 0

    def _control(self, device: Device, urb: Urb) -> None:
        head = Memory.read(urb.pid, urb.buffer, 8)
        setup = Setup(*struct.unpack("<BBHHH", head))
        data = b""
        if not setup.kind & IN and setup.length:
            data = Memory.read(urb.pid, urb.buffer + 8, setup.length)
        answer = device.control(setup, data)
        if answer is Handshake.NAK:
            self.waiting.append(urb)
        elif not isinstance(answer, bytes):
            self.finish(urb, -errno.EPIPE)
        elif setup.kind & IN:
            Memory.write(urb.pid, urb.buffer + 8, answer)
            self.finish(urb, 0, actual=len(answer))
        else:
            self.finish(urb, 0, actual=setup.length)

    def fill(self, now: float) -> None:
        """Give what the device has to the transfers that wait."""
        device = self.plugged.device
        for end in {urb.end for urb in self.waiting if urb.type != _CONTROL and urb.end & IN}:
            size = device.endpoint(end).size
            while urb := next((it for it in self.waiting if it.end == end), None):
                packet = device.packet(end, now)
                if packet is Handshake.NAK:
                    break
                status = -errno.EPIPE
                if isinstance(packet, bytes):
                    urb.data += packet
                    is_over = len(packet) > size or len(urb.data) > urb.length
                    status = -errno.EOVERFLOW if is_over else 0
                    if not status and len(packet) == size and len(urb.data) < urb.length:
                        continue
                self.waiting.remove(urb)
                self._finish_with_data(urb, status)

    def _finish_with_data(self, urb: Urb, status: int) -> None:
        data = bytes(urb.data[: urb.length])
        Memory.write(urb.pid, urb.buffer, data)
        self.finish(urb, status, actual=len(data))

    def finish(self, urb: Urb, status: int, actual: int = 0) -> None:
        urb.status, urb.actual = status, actual
        self.done.append(urb)
        self._usbfs.files.notify(self)

    def _reap(self, pid: int, pointer: int) -> int:
        if not self.done:
            return -errno.ENODEV if self.plugged.is_gone else -errno.EAGAIN
        urb = self.done.popleft()
        Memory.write(pid, urb.address + _STATUS, struct.pack("<i", urb.status))
        Memory.write(pid, urb.address + _ACTUAL, struct.pack("<i", urb.actual))
        Memory.write(pid, pointer, struct.pack("<Q", urb.address))
        return 0

    def _discard(self, address: int) -> int:
        urb = next((it for it in self.waiting if it.address == address), None)
        if urb is None:
            return -errno.EINVAL
        self.waiting.remove(urb)
        if self.plugged.keeps_discarded:
            self._kept.append(urb)
        else:
            self._finish_with_data(urb, -errno.ENOENT)
        return 0

    def end_kept(self) -> None:
        """End the cancelled transfers that were kept."""
        for urb in self._kept:
            self._finish_with_data(urb, -errno.ENOENT)
        self._kept.clear()

    def pulled(self) -> None:
        while self.waiting:
            self.finish(self.waiting.popleft(), -errno.ESHUTDOWN)
        self._usbfs.files.notify(self)


class Usbfs:
    """The bus. All methods run on the loop of its `Lines`."""

    def __init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self.files = FuseFiles(self._open, lambda number: number in self.plugged)
        self.plugged: dict[int, Plugged] = {}
        self._opened: list[OpenDevice] = []
        self._timer: asyncio.TimerHandle | None = None

    def plug(self, number: int, plugged: Plugged) -> None:
        self.plugged[number] = plugged
        plugged.device.ready = self.serve

    def pull(self, number: int) -> None:
        plugged = self.plugged.pop(number)
        plugged.is_gone = True
        plugged.device.ready = lambda: None
        for opened in self._opened:
            if opened.plugged is plugged:
                opened.pulled()

    def opened(self, plugged: Plugged) -> list[OpenDevice]:
        return [each for each in self._opened if each.plugged is plugged]

    def closed(self, opened: OpenDevice) -> None:
        self._opened.remove(opened)

    def _open(self, number: int) -> OpenDevice:
        plugged = self.plugged.get(number)
        if plugged is None:
            raise OSError(errno.ENODEV, f"no device {number}")
        if not plugged.may_open:
            plugged.calls.append("open refused")
            raise OSError(errno.EACCES, f"device {number}")
        opened = OpenDevice(self, plugged)
        self._opened.append(opened)
        return opened

    def serve(self) -> None:
        """Give what the devices have, and come back when they will have more."""
        wake = inf
        for opened in self._opened:
            device = opened.plugged.device
            if opened.plugged.is_gone:
                continue
            try:
                opened.fill(self._loop.time())
            except ProcessLookupError:  # the program has ended
                opened.waiting.clear()
            if any(urb.end & IN and urb.type != _CONTROL for urb in opened.waiting):
                wake = min(wake, device.wake_at(self._loop.time()))
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if wake < inf:
            self._timer = self._loop.call_at(wake, self.serve)

    def close(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self.files.unmount()
