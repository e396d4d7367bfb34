"""A link of your own over any stream socket: a Bluetooth adapter's, a VPN's, one of a test.

    wire = socket.socket(socket.AF_BLUETOOTH, socket.SOCK_STREAM, socket.BTPROTO_RFCOMM)
    wire.connect(("00:11:22:33:44:55", 1))
    ecu = mikas.connect(link=SocketLink("rfcomm:00:11:22:33:44:55", wire))

`test_socket_link.py` beside it runs the contract of links over it.
"""

from __future__ import annotations

import select
import socket
from contextlib import suppress

from mikas.errors import LinkClosed, LinkLost
from mikas.link import Chunk, Link, PortKind, WallClock


class SocketLink(Link):
    """The bytes of `wire`; `url` is its name in messages."""

    kind = PortKind.NETWORK  # for the words of errors: no USB plug
    granularity = 0.05  # s by which this radio may deliver bytes late and together

    def __init__(self, url: str, wire: socket.socket) -> None:
        self.url = url
        self._wire = wire
        self._clock = WallClock()  # UNIX time that never runs back
        self._can_break = False
        self._lost = False

    def write(self, data: bytes) -> None:
        self._check()
        try:
            self._wire.sendall(data)
        except OSError as error:
            raise self._gone(str(error)) from error

    def read(self, deadline: float) -> Chunk:
        self._check()
        try:
            waited = max(0.0, deadline - self.now())
            if not select.select([self._wire], [], [], waited)[0]:
                return Chunk(b"", self.now())
            data = self._wire.recv(4096)
        except OSError as error:
            raise self._gone(str(error)) from error
        if not data:
            raise self._gone("closed by the other end")
        return Chunk(data, self.now())

    def now(self) -> float:
        return self._clock.now()

    def send_break(self, seconds: float) -> None:
        until = self.now() + seconds  # a socket can't; the time has to pass all the same
        while (left := until - self.now()) > 0:
            self._check()
            select.select([], [], [], left)
        self._check()

    def close(self) -> None:
        with suppress(OSError):
            self._wire.shutdown(socket.SHUT_RDWR)  # wakes a read in another thread
        self._wire.close()

    def _check(self) -> None:
        if self._wire.fileno() < 0:
            raise LinkClosed(url=self.url)
        if self._lost:
            raise self._gone("closed by the other end")

    def _gone(self, problem: str) -> LinkLost:
        self._lost = True
        return LinkLost(url=self.url, problem=problem)
