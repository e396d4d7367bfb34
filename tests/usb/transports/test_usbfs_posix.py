"""usbfs by FUSE, as a program sees it: real files, real ioctls, and a model behind them."""

from __future__ import annotations

import ctypes
import errno
import os
import select
import struct
import subprocess
from contextlib import ExitStack, contextmanager
from typing import NoReturn

import pytest

from usb.book_rig import Far
from usb.chips.named import plugged
from usb.chips.uart import Form, Settings
from usb.transports import fuse_rig
from usb.transports.usbfs_rig import Plugged, Usbfs
from usb.wire_rig import Lines

IN_END, OUT_END = 0x81, 0x01  # of a CP2102
SUBMIT, DISCARD, REAP_NOW = 0x8038550A, 0x550B, 0x4008550D
CLAIM, CLEAR_HALT, GET_DRIVER, IOCTL = 0x8004550F, 0x80045515, 0x41045508, 0xC0105512
DETACH = 0x5516
CONTROL, BULK = 2, 3
LIBC = ctypes.CDLL(None, use_errno=True)
UNTIL = 60.0  # s

pytestmark = pytest.mark.realtime


def missing() -> str:
    if not hasattr(os, "geteuid") or os.geteuid():
        return "not root: usbfs by FUSE needs a mount namespace"
    return fuse_rig.missing()


def miss(reason: str) -> NoReturn:
    """Skip the test; fail it where `.ci/run` has seen to what it needs."""
    if os.environ.get("MIKAS_REQUIRE_FUSE"):
        pytest.fail(reason)
    pytest.skip(reason)


@contextmanager
def namespace():
    """Yield the process of a mount namespace of its own."""
    command = ["unshare", "--mount", "sh", "-c", "mount -t tmpfs none /mnt && echo ready && cat"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as process:
        if process.stdout.readline() != "ready\n":
            miss("no mount namespace here")
        yield process.pid
        process.stdin.close()


@pytest.fixture(scope="module")
def mounted():
    """A usbfs in a namespace: the loop it runs on, the bus, and the folder of its files."""
    if reason := missing():
        miss(reason)
    with namespace() as pid:
        lines = Lines()
        usbfs = lines.call(Usbfs)
        lines.call(lambda: usbfs.files.mount("/mnt/bus", pid))
        yield lines, usbfs, f"/proc/{pid}/root/mnt/bus/001"
        lines.call(usbfs.close)
        lines.close()


class Program:
    """A program that has opened a device's file."""

    def __init__(self, path: str) -> None:
        self.file = os.open(path, os.O_RDWR)
        self._urbs = {}

    def submit(self, kind: int, end: int, data: bytes, length: int = 0) -> int:
        """Submit a transfer; return its address."""
        buffer = ctypes.create_string_buffer(data, max(len(data), length, 1))
        size = max(len(data), length)
        urb = ctypes.create_string_buffer(56)
        struct.pack_into("<BB", urb, 0, kind, end)
        struct.pack_into("<QI", urb, 16, ctypes.addressof(buffer), size)
        address = ctypes.addressof(urb)
        self.ioctl(SUBMIT, address)
        self._urbs[address] = urb, buffer
        return address

    def control(self, kind: int, request: int, value=0, index=0, data=b"", length=0) -> int:
        head = struct.pack("<BBHHH", kind, request, value, index, length or len(data))
        return self.submit(CONTROL, 0, head + data, 8 + length)

    def reap(self):
        """Wait for a transfer that is done; return its address, status and data."""
        poll = select.poll()
        poll.register(self.file, select.POLLOUT)
        assert poll.poll(UNTIL * 1000), "nothing came"
        return self.reap_now()

    def reap_now(self):
        pointer = ctypes.create_string_buffer(8)
        self.ioctl(REAP_NOW, ctypes.addressof(pointer))
        (address,) = struct.unpack("<Q", pointer.raw)
        urb, buffer = self._urbs.pop(address)
        (status,), (actual,) = (struct.unpack_from("<i", urb, at) for at in (4, 28))
        skip = 8 if urb.raw[0] == CONTROL else 0
        return address, status, buffer.raw[skip : skip + actual]

    def ioctl(self, command: int, pointer: int) -> None:
        if LIBC.ioctl(self.file, ctypes.c_ulong(command), ctypes.c_void_p(pointer)):
            raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))

    def manage(self, command: int, number: int = 0) -> None:
        word = ctypes.c_uint32(number)
        self.ioctl(command, ctypes.addressof(word))


@pytest.fixture
def far():
    return Far()


@pytest.fixture
def cp2102(mounted, far):
    lines, usbfs, _ = mounted
    device = plugged("CP2102", far)
    device.ports[0].enabled = True
    device.uart.set(9600, Form())
    entry = Plugged(device)
    lines.call(lambda: usbfs.plug(2, entry))
    yield entry
    if not entry.is_gone:
        lines.call(lambda: usbfs.pull(2))


@pytest.fixture
def program(mounted, cp2102):
    with ExitStack() as stack:
        opened = Program(f"{mounted[2]}/002")
        stack.callback(os.close, opened.file)
        yield opened


@pytest.fixture
def hear(mounted, cp2102):
    lines = mounted[0]
    return lambda data: lines.call(lambda: cp2102.device.uart.hear(data, Settings()))


def test_the_file_has_the_descriptors(program, cp2102):
    device = cp2102.device
    found = os.pread(program.file, 4096, 0)
    assert found == device.device_descriptor() + device.configuration()


def test_a_request_an_output_and_an_input_are_submitted_and_reaped(program, far, hear):
    one = program.control(0xC0, 0xFF, 0x370B, length=1)
    assert program.reap() == (one, 0, b"\x02")
    two = program.control(0x41, 0x1E, data=(4800).to_bytes(4, "little"))
    assert program.reap()[:2] == (two, 0)
    three = program.submit(BULK, OUT_END, b"\x01\xff\x0d")
    assert program.reap()[:2] == (three, 0)
    assert (far.data, far.settings.rate) == (b"\x01\xff\x0d", 4800)
    program.control(0x41, 0x1E, data=(9600).to_bytes(4, "little"))
    program.reap()
    four = program.submit(BULK, IN_END, b"", 64)
    with pytest.raises(BlockingIOError):
        program.reap_now()
    hear(b"abc")
    assert program.reap() == (four, 0, b"abc")


def test_an_input_of_several_packets_ends_with_a_short_one(program, hear):
    address = program.submit(BULK, IN_END, b"", 256)
    hear(bytes(range(70)))
    assert program.reap() == (address, 0, bytes(range(70)))


def test_stall_and_babble_are_statuses_of_the_transfer(program, cp2102, hear):
    one = program.control(0x40, 0x77)
    assert program.reap()[:2] == (one, -errno.EPIPE)
    cp2102.device.faults.babble()
    two = program.submit(BULK, IN_END, b"", 64)
    hear(b"1")
    assert program.reap()[:2] == (two, -errno.EOVERFLOW)
    cp2102.device.faults.stall_in()
    three = program.submit(BULK, IN_END, b"", 64)
    assert program.reap()[:2] == (three, -errno.EPIPE)
    program.manage(CLEAR_HALT, IN_END)
    four = program.submit(BULK, IN_END, b"", 64)
    hear(b"2")
    assert program.reap() == (four, 0, b"2")


def test_a_discarded_transfer_ends_at_once_or_late(mounted, program, cp2102):
    lines, usbfs, _ = mounted
    address = program.submit(BULK, IN_END, b"", 64)
    program.ioctl(DISCARD, address)
    assert program.reap()[:2] == (address, -errno.ENOENT)
    cp2102.keeps_discarded = True
    address = program.submit(BULK, IN_END, b"", 64)
    program.ioctl(DISCARD, address)
    with pytest.raises(BlockingIOError):
        program.reap_now()
    [opened] = lines.call(lambda: usbfs.opened(cp2102))
    lines.call(opened.end_kept)
    assert program.reap()[:2] == (address, -errno.ENOENT)


def test_a_request_that_hangs_is_ended_by_discarding_it(program, cp2102):
    cp2102.device.faults.hang(0x05)
    address = program.control(0x41, 0x05, 1)
    with pytest.raises(BlockingIOError):
        program.reap_now()
    program.ioctl(DISCARD, address)
    assert program.reap()[:2] == (address, -errno.ENOENT)


def test_a_bound_driver_refuses_a_claim_until_it_is_detached(program, cp2102):
    name = ctypes.create_string_buffer(260)
    with pytest.raises(OSError, match="No data available"):
        program.ioctl(GET_DRIVER, ctypes.addressof(name))
    cp2102.driver, cp2102.is_detachable = "cp210x", False
    program.ioctl(GET_DRIVER, ctypes.addressof(name))
    assert name.raw[4:].startswith(b"cp210x\0")
    with pytest.raises(OSError, match="busy"):
        program.manage(CLAIM)
    order = ctypes.create_string_buffer(struct.pack("<iIQ", 0, DETACH, 0), 16)
    with pytest.raises(PermissionError):
        program.ioctl(IOCTL, ctypes.addressof(order))
    cp2102.is_detachable = True
    program.ioctl(IOCTL, ctypes.addressof(order))
    program.manage(CLAIM)
    assert cp2102.calls == ["open", "claim", "detach", "detach", "claim"]


def test_a_pulled_device_ends_all_that_waits_and_its_file_is_gone(mounted, program, cp2102):
    lines, usbfs, folder = mounted
    address = program.submit(BULK, IN_END, b"", 64)
    lines.call(lambda: usbfs.pull(2))
    assert program.reap()[:2] == (address, -errno.ESHUTDOWN)
    with pytest.raises(OSError, match="No such device"):
        program.reap_now()
    with pytest.raises(OSError, match="No such device"):
        program.submit(BULK, OUT_END, b"x")
    with pytest.raises(FileNotFoundError):
        os.open(f"{folder}/002", os.O_RDWR)


def test_a_file_without_rights_does_not_open(mounted, cp2102):
    cp2102.may_open = False
    with pytest.raises(PermissionError):
        os.open(f"{mounted[2]}/002", os.O_RDWR)
