"""Connecting, writing and closing with bounds, and the connection that replaces a dead one."""

from __future__ import annotations

import errno
import select
import socket
import time
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from mikas.errors import PortFailed
from mikas.link import open_link
from mikas.link.network import tcp
from mikas.link.network.tcp import RawTcpPort
from mikas.testing.links import FAR

from .terminal_server import served, unit

pytestmark = pytest.mark.realtime


def port_at(place: tuple[str, int]) -> RawTcpPort:
    port = RawTcpPort(patience=0.05)
    port.open(place)
    return port


class Listening:
    """A server that accepts, and keeps each connection open."""

    def __init__(self, server: socket.socket) -> None:
        server.settimeout(FAR)
        self.server = server
        self.place = server.getsockname()
        self.connections: list[socket.socket] = []

    def accept(self) -> tuple[str, int]:
        """Return the address of the other end."""
        connection, address = self.server.accept()
        self.connections.append(connection)
        return address


@pytest.fixture
def listening():
    with socket.create_server(("127.0.0.1", 0)) as server:
        listening = Listening(server)
        yield listening
        for connection in listening.connections:
            connection.close()


@pytest.fixture
def names(monkeypatch):
    """Names of this test, which no resolver knows."""
    known = {}
    real = socket.getaddrinfo

    def resolve(host, port, **options):
        if host not in known or options.get("flags"):
            return real(host, port, **options)
        found = known[host]
        if isinstance(found, Exception):
            raise found
        return [info for each in found for info in real(each, port, **options)]

    monkeypatch.setattr(socket, "getaddrinfo", resolve)
    return known


@pytest.mark.parametrize("host", ["127.0.0.1", "::1"])
def test_both_kinds_of_addresses_are_reached(host):
    with served(unit, host) as place, open_link(f"socket://{place}") as link:
        assert place in link.description
        link.write(b"\x01\xff\r")
        assert link.read(link.now() + FAR).data


@pytest.mark.parametrize("others", [["::1"], ["127.0.0.2"], ["::1", "127.0.0.2"]])
def test_a_name_is_reached_by_any_of_its_addresses(listening, names, others):
    names["bridge.test"] = [*others, "127.0.0.1"]
    with closing(port_at(("bridge.test", listening.place[1]))):
        listening.accept()


def test_a_name_that_is_not_resolved_any_more_has_its_latest_addresses(listening, names):
    names["bridge.test"] = ["127.0.0.1"]
    place = ("bridge.test", listening.place[1])
    port_at(place).close()
    names["bridge.test"] = socket.gaierror(socket.EAI_AGAIN, "no network")
    with closing(port_at(place)):
        pass


def test_a_name_that_was_never_resolved_is_not_known(names):
    names["bridge.test"] = socket.gaierror(socket.EAI_NONAME, "unknown")
    with pytest.raises(PortFailed, match="host is not known"):
        open_link("socket://bridge.test:1")


def test_an_address_that_answers_nothing_ends_the_attempt(listening, monkeypatch):
    monkeypatch.setattr(tcp, "CONNECTING", 0.05)
    with ExitStack() as stack:

        def fill() -> None:
            for _ in range(1000):  # until the system's queue of the server is full
                stack.callback(port_at(listening.place).close)

        with pytest.raises(TimeoutError):
            fill()


def test_an_end_that_never_reads_hangs_neither_a_write_nor_the_closing(listening):
    port = port_at(listening.place)
    with pytest.raises(tcp.WriteTimeout):
        port.write(bytes(100_000_000))
    began = time.monotonic()
    port.close()
    assert time.monotonic() - began < FAR


@pytest.mark.parametrize("end", [RawTcpPort.close, RawTcpPort.give_up])
def test_only_a_connection_that_was_given_up_is_replaced_from_its_own_port(listening, end):
    first = port_at(listening.place)
    before = listening.accept()
    end(first)
    with closing(port_at(listening.place)):
        assert (listening.accept() == before) is (end is RawTcpPort.give_up)


def test_one_that_the_other_end_has_closed_is_not_replaced(listening):
    port = port_at(listening.place)
    listening.accept()
    listening.connections[0].close()
    select.select([port.fileno()], [], [], FAR)
    with pytest.raises(ConnectionError):
        port.read(1)
    port.give_up()
    assert listening.place not in tcp._given_up  # noqa: SLF001


def test_a_port_that_another_program_has_taken_meanwhile_is_left_to_it(listening, monkeypatch):
    # The other program first, and no `give_up`: after it another connection of this computer may
    # have the port, so that the other program can't take it.
    with socket.create_server(("127.0.0.1", 0)) as other:
        local = other.getsockname()
        monkeypatch.setitem(tcp._given_up, listening.place, local)  # noqa: SLF001
        with closing(port_at(listening.place)):
            assert listening.accept() != local


def test_a_connection_has_what_keeps_it_quick_and_ends_it(listening):
    with closing(port_at(listening.place)) as port:
        sock = port._socket  # noqa: SLF001
        assert sock.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
        assert sock.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)
        if hasattr(socket, "TCP_USER_TIMEOUT"):
            assert sock.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT) == 10_000


def test_a_system_without_a_kind_of_addresses_has_the_other(listening, names, monkeypatch):
    real = socket.socket

    def refuse(family=-1, *rest, **options):
        if family == socket.AF_INET6:
            raise OSError(errno.EAFNOSUPPORT, "Address family not supported by protocol")
        return real(family, *rest, **options)

    names["bridge.test"] = ["::1", "127.0.0.1"]
    monkeypatch.setattr(tcp.socket, "socket", refuse)
    with closing(port_at(("bridge.test", listening.place[1]))):
        pass


@pytest.mark.skipif(not Path("/proc/net/if_inet6").exists(), reason="needs IPv6 of Linux")
def test_a_link_local_address_without_its_interface_is_explained():
    """A real connection: the system's own refusal, for a bridge and for a broker."""
    with pytest.raises(PortFailed) as caught:
        open_link("socket://[fe80::1]:4001")
    for words in caught.value.reason:
        assert "%eth0" in words
