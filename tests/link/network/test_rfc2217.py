"""Terminal servers that leave an option unanswered, set another rate, or write data in odd ways."""

from __future__ import annotations

import socket

import pytest

from mikas import tester
from mikas.errors import LinkLost, PortFailed
from mikas.link import open_link
from mikas.link.network import rfc2217

from .terminal_server import BINARY, COM_PORT, ECHO, TerminalServer, served, unit

pytestmark = pytest.mark.realtime

BAUD, DATA_SIZE, PARITY, STOP_SIZE, CONTROL, PURGE = 1, 2, 3, 4, 5, 12


@pytest.fixture(autouse=True)
def short_waits(monkeypatch):
    monkeypatch.setattr(rfc2217, "ANSWERS", 0.05)


@pytest.mark.parametrize(
    "server",
    [
        TerminalServer(),
        TerminalServer(silent=(PURGE,)),
        TerminalServer(silent=(CONTROL,)),
        TerminalServer(silent=(BAUD,)),
        TerminalServer(silent=(DATA_SIZE, PARITY, STOP_SIZE)),
        TerminalServer(silent=(BAUD, DATA_SIZE, PARITY, STOP_SIZE, CONTROL, PURGE)),
        TerminalServer(rate=9615),  # what its divisor gives
        TerminalServer(rate=0),  # “I do not say”
        TerminalServer(doubles_ff=False),
        TerminalServer(adds_nul=True),
        TerminalServer(refuses=(BINARY,)),
        TerminalServer(refuses=(BINARY,), adds_nul=True),
        TerminalServer(refuses=(COM_PORT,)),
        TerminalServer(refuses=(COM_PORT, BINARY), adds_nul=True),
        TerminalServer(greets=bytes.fromhex("fffb03fffd03fffb01fffe01fffd00fffb00fffd2c")),
        TerminalServer(greets=b"\r\nser2net port 2001 device /dev/ttyUSB0 [9600N81]\r\n\r\n"),
        TerminalServer(greets=b"\xff\xfa\x2c\x00\xff\xf0" + b"\xff\xfa\x2c\x6b\x70\xff\xf0"),
    ],
    ids=str,
)
def test_a_unit_behind_it_is_found(server):
    with served(server) as place, open_link(f"rfc2217://{place}") as link:
        assert tester.Tester(link).connect() == 9


@pytest.mark.parametrize("rate", [115200, 1200, 9000])
def test_another_rate_than_asked_for_is_named_with_both(rate):
    with served(TerminalServer(rate=rate)) as place, pytest.raises(PortFailed) as caught:
        open_link(f"rfc2217://{place}")
    for words in caught.value.reason:
        assert str(rate) in words
        assert "9600" in words


def test_a_rate_that_is_answered_late_is_named_all_the_same():
    server = TerminalServer(silent=(BAUD,))
    with served(server) as place, open_link(f"rfc2217://{place}") as link:
        server.silent, server.rate = (), 115200
        port = link.link.link.port
        port._command(1, (9600).to_bytes(4, "big"))  # noqa: SLF001  (its answer is a late one)
        with pytest.raises(LinkLost, match="115200"):
            link.read(link.now() + 30)


def test_all_is_asked_for_once_and_nothing_is_purged():
    server = TerminalServer()
    with served(server) as place, open_link(f"rfc2217://{place}?baud=10400&rts=1&dtr=0") as link:
        assert tester.Tester(link).connect() == 9  # after which all has come
    assert server.settings == {
        BAUD: [(10400).to_bytes(4, "big")],
        DATA_SIZE: [b"\x08"],
        PARITY: [b"\x01"],
        STOP_SIZE: [b"\x01"],
        CONTROL: [b"\x01", b"\x09", b"\x0b"],
    }


@pytest.mark.parametrize("option", ["baud=9600", "dtr=1", "rts=0"])
def test_telnet_alone_can_not_set_what_the_url_asks_for(option):
    server = TerminalServer(refuses=(COM_PORT, ECHO))
    with served(server) as place, pytest.raises(PortFailed, match="no RFC 2217"):
        open_link(f"rfc2217://{place}?{option}")


def test_telnet_alone_has_no_break():
    server = TerminalServer(refuses=(COM_PORT,))
    with served(server) as place, open_link(f"rfc2217://{place}") as link:
        assert not link.can_break
        link.send_break(0.001)


def test_a_plain_tcp_server_has_its_own_message(monkeypatch):
    monkeypatch.setattr(rfc2217, "FIRST_ANSWER", 0.05)
    for talk, words in ((silent, " (try socket://)"), (echo, ", and says “hello”")):
        with served(talk) as place, pytest.raises(PortFailed) as caught:
            open_link(f"rfc2217://{place}")
        assert f"does not speak RFC 2217{words}" in caught.value.reason.en
        assert "не поддерживает RFC 2217" in caught.value.reason.ru


def test_a_raw_port_with_a_line_that_echoes_is_named():
    with served(unit) as place, pytest.raises(PortFailed) as caught:
        open_link(f"rfc2217://{place}")
    assert "use socket://" in caught.value.reason.en
    assert "используйте socket://" in caught.value.reason.ru


def echo(client: socket.socket) -> None:
    client.recv(99)
    client.sendall(b"hello\r\n")
    silent(client)


def silent(client: socket.socket) -> None:
    while client.recv(99):
        pass


def test_no_thread_is_begun(begun):
    with served(TerminalServer()) as place:
        begun.clear()
        with open_link(f"rfc2217://{place}") as link:
            tester.Tester(link).connect()
        assert begun == []
