"""Files whose `open`, `read`, `ioctl` and `poll` a test answers: FUSE, as the kernel speaks it.

A folder `001` with a file for each device, as `/dev/bus/usb`. The kernel passes an ioctl with the
caller's pid and its pointer, and `Memory` reads and writes behind that pointer. Needs root and
`/dev/fuse`. All methods run on the loop on which the files were mounted.
"""

from __future__ import annotations

import asyncio
import ctypes
import errno
import os
import stat
import struct
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Protocol

_LOOKUP, _FORGET, _GETATTR, _OPEN, _READ, _RELEASE = 1, 2, 3, 14, 15, 18
_FLUSH, _INIT, _OPENDIR, _READDIR, _RELEASEDIR, _ACCESS = 25, 26, 27, 28, 29, 34
_INTERRUPT, _DESTROY, _IOCTL, _POLL, _BATCH_FORGET = 36, 38, 39, 40, 42
_HEAD = struct.Struct("<IIQQIIII")
_ATTRIBUTES = struct.Struct("<6Q10I")
_MOST = 1 << 16  # bytes of a read and a write
_DIRECT = 1  # no cache
_NOTIFY_POLL = 1
_ROOT, _BUS, _FIRST = 1, 2, 100  # inodes: the mount, its folder 001, and from there the files
_CLONE_FS, _CLONE_NEWNS = 0x200, 0x20000
_libc = ctypes.CDLL(None, use_errno=True)
DEVICE = "/dev/fuse"


def missing() -> str:
    """Return what keeps files of FUSE from being mounted here; empty: nothing."""
    if not Path(DEVICE).exists():
        return f"no {DEVICE}: the kernel has no FUSE (modprobe fuse)"
    try:
        os.close(os.open(DEVICE, os.O_RDWR))
    except OSError as error:
        return f"{DEVICE}: {error.strerror}"
    return ""


class Opened(Protocol):
    """An open file."""

    def read(self, offset: int, size: int) -> bytes: ...

    def ioctl(self, pid: int, command: int, pointer: int) -> int:
        """Return the result of an ioctl; negative: minus the error's number."""

    def poll(self) -> int:
        """Return the events that are there now."""

    def close(self) -> None: ...


class _Span(ctypes.Structure):
    _fields_ = (("base", ctypes.c_void_p), ("length", ctypes.c_size_t))


class Memory:
    """The memory of another process."""

    @staticmethod
    def read(pid: int, address: int, size: int) -> bytes:
        buffer = ctypes.create_string_buffer(size)
        _pass(_libc.process_vm_readv, pid, address, buffer, size)
        return buffer.raw

    @staticmethod
    def write(pid: int, address: int, data: bytes) -> None:
        if data:
            buffer = ctypes.create_string_buffer(data, len(data))
            _pass(_libc.process_vm_writev, pid, address, buffer, len(data))


def _pass(call, pid: int, address: int, buffer, size: int) -> None:
    here, there = _Span(ctypes.cast(buffer, ctypes.c_void_p), size), _Span(address, size)
    if call(pid, ctypes.byref(here), 1, ctypes.byref(there), 1, 0) != size:
        raise OSError(ctypes.get_errno(), f"the memory of process {pid}")


class FuseFiles:
    """The mount. `open_file` opens the device of a number, or raises an `OSError`."""

    def __init__(self, open_file: Callable[[int], Opened], has_file: Callable[[int], bool]) -> None:
        self._open_file, self._has_file = open_file, has_file
        self._loop = asyncio.get_running_loop()
        self._fuse = os.open(DEVICE, os.O_RDWR)
        self._opened: dict[int, Opened] = {}
        self._polled: dict[int, int] = {}  # the kernel's number of a waiting poll, by handle
        self._last = 0

    def mount(self, target: str, pid: int) -> None:
        """Mount at `target` in the mount namespace of the process `pid`."""

        def work() -> None:
            if _libc.unshare(_CLONE_FS):
                raise OSError(ctypes.get_errno(), "unshare")
            with Path(f"/proc/{pid}/ns/mnt").open("rb") as namespace:
                if _libc.setns(namespace.fileno(), _CLONE_NEWNS):
                    raise OSError(ctypes.get_errno(), "setns")
            Path(target).mkdir(parents=True, exist_ok=True)
            options = f"fd={self._fuse},rootmode=40000,user_id=0,group_id=0,allow_other"
            if _libc.mount(b"usbfs", target.encode(), b"fuse", 0, options.encode()):
                raise OSError(ctypes.get_errno(), f"mount {target}")

        with ThreadPoolExecutor(1) as threads:  # a thread of its own goes into the namespace
            threads.submit(work).result()
        os.set_blocking(self._fuse, False)
        self._loop.add_reader(self._fuse, self._receive)

    def unmount(self) -> None:
        """Answer no more: the kernel ends all that waits."""
        self._loop.remove_reader(self._fuse)
        os.close(self._fuse)

    def notify(self, opened: Opened) -> None:
        """Tell the kernel that `opened` has events, if it polls for them."""
        for handle, each in self._opened.items():
            if each is opened and handle in self._polled:
                data = struct.pack("<IiQQ", 24, _NOTIFY_POLL, 0, self._polled[handle])
                self._write(data)

    # -- the kernel's requests ---------------------------------------------------------------------

    def _write(self, data: bytes) -> None:
        try:
            os.write(self._fuse, data)
        except OSError as error:
            if error.errno != errno.ENOENT:  # the caller has been interrupted meanwhile
                raise

    def _receive(self) -> None:
        try:
            data = os.read(self._fuse, 2 * _MOST)
        except OSError as error:
            if error.errno == errno.ENODEV:  # unmounted: its namespace has ended
                self._loop.remove_reader(self._fuse)
            elif error.errno not in {errno.ENOENT, errno.EINTR, errno.EAGAIN}:
                raise
            return
        length, operation, unique, node, _, _, pid, _ = _HEAD.unpack_from(data)
        try:
            answer = self._answer(operation, node, pid, data[_HEAD.size : length])
        except OSError as error:
            self._write(struct.pack("<IiQ", 16, -(error.errno or errno.EIO), unique))
            return
        if answer is not None:
            self._write(struct.pack("<IiQ", 16 + len(answer), 0, unique) + answer)

    def _answer(self, operation: int, node: int, pid: int, body: bytes) -> bytes | None:
        match operation:
            case _ if operation in {_FORGET, _BATCH_FORGET, _INTERRUPT}:
                return None
            case _ if operation == _INIT:
                _, minor, ahead, _ = struct.unpack_from("<IIII", body)
                return struct.pack(
                    "<IIIIHHIIHHI7I", 7, min(minor, 31), ahead, 0, 12, 10, _MOST, 1, 0, 0, 0,
                    *[0] * 7,
                )  # fmt: skip
            case _ if operation == _LOOKUP:
                child = self._child(node, body.rstrip(b"\0").decode())
                return struct.pack("<QQQQII", child, 0, 0, 0, 0, 0) + _attributes(child)
            case _ if operation == _GETATTR:
                return struct.pack("<QII", 0, 0, 0) + _attributes(node)
            case _ if operation == _OPEN:
                return self._open(node)
            case _ if operation == _OPENDIR:
                return struct.pack("<QII", 0, 0, 0)
            case _ if operation in {_READDIR, _RELEASEDIR, _FLUSH, _ACCESS, _DESTROY}:
                return b""
            case _ if operation in {_READ, _RELEASE, _POLL, _IOCTL}:
                return self._of_file(operation, pid, body)
        raise OSError(errno.ENOSYS, f"FUSE operation {operation}")

    def _child(self, node: int, name: str) -> int:
        if node == _ROOT and name == "001":
            return _BUS
        if node == _BUS and name.isdigit() and self._has_file(int(name)):
            return _FIRST + int(name)
        raise OSError(errno.ENOENT, name)

    def _open(self, node: int) -> bytes:
        opened = self._open_file(node - _FIRST)
        self._last += 1
        self._opened[self._last] = opened
        return struct.pack("<QII", self._last, _DIRECT, 0)

    def _of_file(self, operation: int, pid: int, body: bytes) -> bytes:
        (handle,) = struct.unpack_from("<Q", body)
        opened = self._opened[handle]
        if operation == _READ:
            _, offset, size = struct.unpack_from("<QQI", body)
            return opened.read(offset, size)
        if operation == _RELEASE:
            del self._opened[handle]
            self._polled.pop(handle, None)
            opened.close()
            return b""
        if operation == _POLL:
            _, self._polled[handle], _, _ = struct.unpack_from("<QQII", body)
            return struct.pack("<II", opened.poll(), 0)
        _, _, command, pointer = struct.unpack_from("<QIIQ", body)
        result = opened.ioctl(pid, command, pointer)
        if result < 0:
            raise OSError(-result, "ioctl")
        return struct.pack("<iIII", result, 0, 0, 0)


def _attributes(node: int) -> bytes:
    mode = stat.S_IFREG | 0o666 if node >= _FIRST else stat.S_IFDIR | 0o755
    return _ATTRIBUTES.pack(node, *[0] * 8, mode, 1, 0, 0, 0, 4096, 0)
