"""Real ser2net in front of a unit on a pty, in the ways people configure it.

Skipped where there is no ser2net, unless `MIKAS_REQUIRE_SER2NET` is set: then it is a failure.
"""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from mikas import tester
from mikas.errors import NoConnection, OtherService, PortBusy, PortFailed
from mikas.link import open_link

from .terminal_server import ANSWER, PATIENCE, REQUEST

SER2NET = shutil.which("ser2net", path=f"{os.environ.get('PATH', '')}:/usr/sbin")
pytestmark = [
    pytest.mark.realtime,
    pytest.mark.skipif(
        SER2NET is None and not os.environ.get("MIKAS_REQUIRE_SER2NET"), reason="no ser2net here"
    ),
]

RAW, TELNET, RFC2217 = "tcp", "telnet,tcp", "telnet(rfc2217),tcp"
BANNER = "    banner: '\\r\\nser2net port \\p device \\d [\\B] (Debian GNU/Linux)\\r\\n\\r\\n'\n"
ONE, KICK = "    max-connections: 1\n", "    max-connections: 1\n    kickolduser: true\n"


@contextmanager
def unit_on_pty() -> Iterator[str]:
    master, slave = os.openpty()
    tty.setraw(slave)

    def answer() -> None:
        with suppress(OSError):
            while data := os.read(master, 4096):
                os.write(master, data + ANSWER * data.count(REQUEST))

    thread = threading.Thread(target=answer)
    thread.start()
    try:
        yield os.ttyname(slave)
    finally:
        os.write(slave, b"\0")  # ends the wait of `read`, whose next one fails
        os.close(slave)
        thread.join(0.2)
        os.close(master)
        thread.join(PATIENCE)


@pytest.fixture
def serve(tmp_path: Path) -> Iterator[Callable[[str, str], str]]:
    """What starts ser2net with an accepter and options, and gives `host:port`."""
    running: list[subprocess.Popen[bytes]] = []

    def start(accepter: str, options: str = ONE) -> str:
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        config = tmp_path / "ser2net.yaml"
        config.write_text(
            f"%YAML 1.1\n---\nconnection: &c\n  accepter: {accepter},127.0.0.1,{port}\n"
            f"  enable: on\n  options:\n{options}"
            f"  connector: 'serialdev(nouucplock),{pty},9600n81,local'\n"
        )
        command = [SER2NET or "ser2net", "-n", "-u", "-c", config, "-P", tmp_path / "pid"]
        running.append(subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT))
        wait_for(port)
        return f"127.0.0.1:{port}"

    with unit_on_pty() as pty:
        yield start
        for each in running:
            each.kill()
            each.communicate()


def wait_for(port: int) -> None:
    """Wait until the system lists the port: a connection would be the only client."""
    deadline = time.monotonic() + PATIENCE
    while f":{port:04X} 00000000:0000 0A" not in Path("/proc/net/tcp").read_text():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def connected(url: str) -> int:
    with open_link(url) as link:
        return tester.Tester(link).connect()


@pytest.mark.parametrize(
    ("scheme", "accepter", "options"),
    [
        ("socket", RAW, ONE),
        ("socket", RAW, ONE + BANNER),
        ("socket", RAW, KICK),
        ("rfc2217", TELNET, ONE),
        ("rfc2217", RFC2217, ONE),
        ("rfc2217", RFC2217, ONE + BANNER),
        ("rfc2217", RFC2217, KICK),
    ],
)
def test_a_unit_behind_it_is_found_and_again(serve, scheme, accepter, options):
    place = serve(accepter, options)
    assert connected(f"{scheme}://{place}") == 9
    assert connected(f"{scheme}://{place}") == 9


@pytest.mark.parametrize("accepter", [TELNET, RFC2217])
def test_a_telnet_port_behind_socket_is_named(serve, accepter):
    with pytest.raises(OtherService, match="rfc2217://"):
        connected(f"socket://{serve(accepter)}")


def test_a_raw_port_behind_rfc2217_is_named(serve):
    with pytest.raises(PortFailed, match="socket://"):
        connected(f"rfc2217://{serve(RAW)}")


@pytest.mark.parametrize(("scheme", "accepter"), [("socket", RAW), ("rfc2217", RFC2217)])
def test_a_second_client_is_shown_that_the_port_is_in_use(serve, scheme, accepter):
    place = serve(accepter)
    with open_link(f"{scheme}://{place}") as link:
        tester.Tester(link).connect()
        for _ in range(5):
            with pytest.raises(PortBusy, match="Port already in use"):
                connected(f"{scheme}://{place}")


@pytest.mark.parametrize(("scheme", "accepter"), [("socket", RAW), ("rfc2217", RFC2217)])
def test_a_client_that_another_one_displaces_has_lost_its_connection(serve, scheme, accepter):
    place = serve(accepter, KICK)
    with open_link(f"{scheme}://{place}") as link:
        client = tester.Tester(link)
        client.connect()
        assert connected(f"{scheme}://{place}") == 9
        with pytest.raises(NoConnection) as caught:
            client.connect()
    assert "USB" not in str(caught.value)
