"""The contract of links, over the example's link: `pytest examples/socket_link`."""

from __future__ import annotations

import socket
from collections.abc import Iterator

import pytest
from socket_link import SocketLink

from mikas.testing import RealTimeContract, Rig


class FarEnd:
    """The other end of the wire."""

    def __init__(self, wire: socket.socket) -> None:
        self.wire = wire

    def send(self, data: bytes) -> None:
        self.wire.sendall(data)

    def received(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            data += self.wire.recv(count - len(data))
        return data

    def vanish(self) -> None:
        self.wire.close()


class TestSocketLink(RealTimeContract):
    """Every test of the contract; a class attribute says where this link differs."""

    can_break = False
    gathers = False  # `gather` is not overridden: it does not sleep

    @pytest.fixture
    def rig(self) -> Iterator[Rig]:
        here, there = socket.socketpair()
        with SocketLink("pair:", here) as link, there:
            yield Rig(link, FarEnd(there))
