"""A bridge whose network goes without a word, and comes back: a real one, in its own namespace.

The bridge serves one client at a time and waits for it without end, as many do, so a second
connection gets nothing while the dead one counts there.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

import netns_rig
from mikas import tester
from mikas.errors import ConnectionSilent, LineError, NoConnection
from mikas.link import Link
from mikas.link.reconnecting import ReconnectingPort
from netns_rig import IP, run

pytestmark = netns_rig.marks

HERE, BRIDGE, AWAY = "10.78.0.1", "10.78.0.2", "10.78.0.99"
LONG = 60.0
ONE_CLIENT = f"""
import socket
server = socket.create_server(("{BRIDGE}", 7777))
print("ready", flush=True)
while True:
    client, place = server.accept()
    print(place[1], flush=True)
    try:
        while data := client.recv(4096):
            client.sendall(data + b"\\x09\\xf7\\r" * data.count(b"\\x01\\xff\\r"))
    except OSError:
        pass
    client.close()
"""


class Bridge:
    """A bridge at the other end of a cable between two namespaces."""

    def __init__(self, name: str) -> None:
        command = [IP, "netns", "exec", name, sys.executable, "-u", "-c", ONE_CLIENT]
        self.name = name
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self.line() == "ready"

    def line(self) -> str:
        assert self.process.stdout is not None
        return self.process.stdout.readline().strip()

    def moves(self, before: str, after: str) -> None:
        """Exchange its address: no packet reaches it, and none says so."""
        run(IP, "-n", self.name, "addr", "del", f"{before}/24", "dev", "far")
        run(IP, "-n", self.name, "addr", "add", f"{after}/24", "dev", "far")


@pytest.fixture
def bridge() -> Iterator[Bridge]:
    name, near = f"mikas-bridge-{os.getpid()}", f"mk{os.getpid()}"
    try:
        run(IP, "netns", "add", name)
        run(IP, "link", "add", near, "type", "veth", "peer", "far", "netns", name)
        run(IP, "addr", "add", f"{HERE}/24", "dev", near)
        run(IP, "link", "set", near, "up")
        run(IP, "-n", name, "addr", "add", f"{BRIDGE}/24", "dev", "far")
        run(IP, "-n", name, "link", "set", "far", "up")
        with ended(Bridge(name)) as bridge:
            yield bridge
    finally:
        run(IP, "link", "del", near, check=False)
        run(IP, "netns", "del", name, check=False)


@contextmanager
def ended(bridge: Bridge) -> Iterator[Bridge]:
    try:
        yield bridge
    finally:
        bridge.process.kill()
        bridge.process.communicate()


def ask_until_silent(link: Link) -> None:
    while True:
        try:
            tester.Tester(link).connect()
        except ConnectionSilent:
            raise
        except (NoConnection, LineError):
            pass


def connected_again(port: ReconnectingPort) -> int:
    deadline = time.monotonic() + LONG
    while True:
        try:
            with port.open() as link:
                return tester.Tester(link).connect()
        except NoConnection:
            assert time.monotonic() < deadline


def test_a_bridge_of_one_client_is_back_after_its_network_was_away(bridge: Bridge) -> None:
    port = ReconnectingPort(f"socket://{BRIDGE}:7777")
    link = port.open()
    assert tester.Tester(link).connect() == 9
    before = bridge.line()
    bridge.moves(BRIDGE, AWAY)
    with pytest.raises(ConnectionSilent):
        ask_until_silent(link)
    with pytest.raises(NoConnection):
        port.open()
    bridge.moves(AWAY, BRIDGE)
    assert connected_again(port) == 9
    assert bridge.line() == before  # from the same port, which ended the dead one
