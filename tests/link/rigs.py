"""Links with something at their other end, that work on every system."""

from __future__ import annotations

import queue
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import serial
from serial import rfc2217
from serial.urlhandler import protocol_loop

from mikas.link import Link, LinkWrapper, open_link
from mikas.link.serial import TICK, SerialLink
from mikas.testing.links import FAR, Rig


def port_of(link: Link) -> Any:
    """The port inside all that is around its link."""
    while isinstance(link, LinkWrapper):
        link = link.link
    return link.port


class TcpPeer:
    """The far end of a TCP connection."""

    def __init__(self, connection: socket.socket) -> None:
        self.connection = connection
        self.connection.settimeout(FAR)

    def send(self, data: bytes) -> None:
        self.connection.sendall(data)

    def received(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            data += self.connection.recv(4096)
        return data

    def vanish(self) -> None:
        self.connection.close()


@contextmanager
def tcp_rig() -> Iterator[Rig]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        link = open_link(f"socket://127.0.0.1:{server.getsockname()[1]}")
        connection, _ = server.accept()
        with link, connection:
            yield Rig(link, TcpPeer(connection))


class Rfc2217Peer:
    """A terminal server with one port, whose line is this object."""

    def __init__(self, server: socket.socket) -> None:
        self.connection: socket.socket | None = None
        self.line = serial.serial_for_url("loop://")
        self._came: queue.Queue[bytes] = queue.Queue()
        self._lock = threading.Lock()
        server.settimeout(FAR)
        self._thread = threading.Thread(target=self._serve, args=(server,))
        self._thread.start()

    def write(self, data: bytes) -> None:  # what the port manager calls
        with self._lock, suppress(OSError):  # the link may have hung up
            self.connection.sendall(data)

    def send(self, data: bytes) -> None:
        self.write(data.replace(b"\xff", b"\xff\xff"))

    def wait_for_line(self, **wanted: object) -> None:
        """Wait until the line has these settings: the link does not wait for all answers."""
        deadline = time.monotonic() + FAR
        while time.monotonic() < deadline:
            if all(getattr(self.line, name) == value for name, value in wanted.items()):
                return
            time.sleep(0.001)
        raise AssertionError(f"the line never had {wanted}")

    def received(self, count: int) -> bytes:
        return b"".join(self._came.get(timeout=FAR) for _ in range(count))

    def vanish(self) -> None:
        if self.connection is not None:
            with suppress(OSError):  # the link may have hung up first
                self.connection.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self.connection.close()

    def _serve(self, server: socket.socket) -> None:
        self.connection, _ = server.accept()
        manager = rfc2217.PortManager(self.line, self)
        while data := self._receive():
            for byte in manager.filter(data):
                self._came.put(byte)

    def _receive(self) -> bytes:
        try:
            return self.connection.recv(4096)
        except ConnectionError:
            return b""


@contextmanager
def rfc2217_rig(options: str = "") -> Iterator[Rig]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        peer = Rfc2217Peer(server)
        try:
            with open_link(f"rfc2217://127.0.0.1:{server.getsockname()[1]}{options}") as link:
                yield Rig(link, peer)
        finally:
            peer.vanish()


class AskedPort(protocol_loop.Serial):
    """A port that the system can't wait on, as on Windows; each end has its own queue."""

    far_end: queue.Queue[bytes]
    unplugged = False

    @property
    def in_waiting(self) -> int:
        self._check("ClearCommError")
        return super().in_waiting

    def read(self, size: int = 1) -> bytes:
        self._check("ReadFile")
        return super().read(size)

    def write(self, data: bytes) -> int:
        self._check("WriteFile")
        for value in data:
            self.far_end.put(bytes([value]))
        return len(data)

    def _check(self, call: str) -> None:
        if self.unplugged:
            reason = PermissionError(13, "The device does not recognize the command.", None, 22)
            raise serial.SerialException(f"{call} failed ({reason!r})")


class AskedPeer:
    def __init__(self, port: AskedPort) -> None:
        self.port = port
        self.port.far_end = queue.Queue()

    def send(self, data: bytes) -> None:
        for value in data:
            self.port.queue.put(bytes([value]))

    def received(self, count: int) -> bytes:
        return b"".join(self.port.far_end.get(timeout=FAR) for _ in range(count))

    def vanish(self) -> None:
        self.port.unplugged = True


@contextmanager
def asked_rig() -> Iterator[Rig]:
    port = AskedPort("loop://", timeout=TICK)
    with SerialLink("COM3", port) as link:
        yield Rig(link, AskedPeer(port))
