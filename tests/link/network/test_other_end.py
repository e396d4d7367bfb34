"""What answers at a network port in the place of a bridge is named, with its words and a remedy."""

from __future__ import annotations

import re
import socket
import struct

import pytest

from mikas import tester
from mikas.errors import (
    LinkLost,
    MikasError,
    NoConnection,
    NoEcho,
    NotAKLineAdapter,
    OtherService,
    PortBusy,
)
from mikas.i18n import Text
from mikas.link import open_link
from mikas.link.network import other_end, rfc2217
from mikas.link.network.other_end import at_the_end, in_handshake, said_in
from mikas.testing.links import collect

from .terminal_server import REQUEST, TerminalServer, served, unit

realtime = pytest.mark.realtime
TELNET = bytes.fromhex("fffb03fffd03fffb01fffe01fffd00fffb00fffd2c")


@pytest.fixture(autouse=True)
def short_waits(monkeypatch):
    monkeypatch.setattr(rfc2217, "ANSWERS", 0.05)
    monkeypatch.setattr(rfc2217, "FIRST_ANSWER", 0.3)


def says(first: bytes, *, then: bytes = b"", stays: bool = False):
    """Return a server that sends `first`, answers the first bytes by `then`, and ends or stays."""

    def talk(client: socket.socket) -> None:
        client.sendall(first)
        if then or stays:
            client.recv(4096)
            client.sendall(then)
        while stays and client.recv(4096):
            pass

    return talk


def without_ff(client: socket.socket) -> None:
    """A Telnet server that says nothing of it: FF and the byte after it are a command."""
    while data := client.recv(4096):
        client.sendall(re.sub(rb"\xff.", b"", data, flags=re.DOTALL))


def reset(client: socket.socket) -> None:
    client.recv(4096)
    client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))


def connected(url: str) -> int:
    with open_link(url) as link:
        return tester.Tester(link).connect()


def failure(url: str) -> MikasError:
    with pytest.raises(NoConnection) as caught:
        connected(url)
    return caught.value


BUSY = [
    b"Port already in use\r\n",  # ser2net
    TELNET + b"Port already in use\r\n",
    b"Device is busy\n",
    b"Too many connections, try later",
    b"in use by 192.168.0.7:50123\r\n",
    b"Connection forced off by another client\r\n",
    b"** Port is in use. Connection rejected.\r\n",
    b"NPort 5110: this port is occupied by 192.168.1.5\r\n",
    b"Only one client allowed\r\n",
    "Порт занят другим клиентом\r\n".encode(),
    b"Port wird bereits verwendet\r\n",
]


@realtime
@pytest.mark.parametrize("scheme", ["socket", "rfc2217"])
@pytest.mark.parametrize("words", BUSY)
def test_a_port_that_another_client_has_is_busy_with_its_words(scheme, words):
    with served(says(words)) as place:
        for _ in range(5):  # whether the end comes before or after the first request
            error = failure(f"{scheme}://{place}")
            assert isinstance(error, PortBusy)
            assert said_in(words) in error.reason.en
            assert said_in(words) in error.reason.ru
            assert "bridge" in error.advice.en
            assert "USB" not in error.text.en


SERVICES = {
    "telnet, negotiating": (says(TELNET, stays=True), "rfc2217://", ""),
    "telnet, silent about it": (without_ff, "rfc2217://", ""),
    "http": (says(b"", then=b"HTTP/1.1 400 Bad Request\r\n\r\n"), "8899", "HTTP/1.1 400 Bad"),
    "http, old": (says(b"", then=b"<html><h1>400 Bad request</h1>", stays=True), "8899", ""),
    "tls": (says(b"", then=b"\x15\x03\x01\x00\x02\x02\x46"), "TLS", ""),
    "ssh": (says(b"SSH-2.0-OpenSSH_9.2p1 Debian\r\n", stays=True), "ser2net", "OpenSSH"),
    "login": (says(b"\r\nbridge login: ", stays=True), "login", "bridge login:"),
    "esp-link": (says(b"", then=b"esp-link v3.2\r\n", stays=True), "socket://HOST:23", "esp-link"),
    "esphome": (says(b"", then=b"\x01\x00\x13\x01Bad indicator byte"), "6638", "Bad indicator"),
    "elm327": (says(b"ELM327 v1.5\r\n\xff", stays=True), "KKL", ""),
    "mqtt": (says(b"", then=b"\x20\x02\x00\x01"), "MQTT", ""),
    "ftp": (says(b"220 ProFTPD ready\r\n", stays=True), "ser2net", "ProFTPD"),
}


@realtime
@pytest.mark.parametrize("name", SERVICES)
def test_another_service_is_named_with_its_words_and_what_to_set(name):
    talk, remedy, words = SERVICES[name]
    with served(talk) as place:
        error = failure(f"socket://{place}")
    assert isinstance(error, OtherService)
    assert remedy in error.advice.en
    assert words in error.reason.en
    assert error.advice.ru != error.advice.en
    assert place in error.reason.ru


def waits_for_a_line(client: socket.socket) -> None:
    """Answer as a web server that reads whole lines, as most do."""
    heard = b""
    while b"\r\n\r\n" not in heard:
        heard += client.recv(4096)
    client.sendall(b"<!DOCTYPE HTML><title>Error response</title>")


@realtime
@pytest.mark.parametrize("scheme", ["socket", "rfc2217"])
def test_a_web_server_that_waits_for_a_line_is_named(scheme):
    with served(waits_for_a_line) as place:
        error = failure(f"{scheme}://{place}")
    assert isinstance(error, OtherService)
    assert "HTTP" in error.reason.en


@realtime
def test_what_answers_in_words_is_another_program():
    def redis(client: socket.socket) -> None:
        while client.recv(4096):
            client.sendall(b"-ERR unknown command\r\n")

    with served(redis) as place:
        error = failure(f"socket://{place}")
    assert isinstance(error, OtherService)
    assert "another program (it says “-ERR unknown command”)" in error.reason.en


@realtime
def test_a_greeting_before_the_silence_is_quoted():
    with served(says(b"RFB 003.008\n", stays=True)) as place:
        error = failure(f"socket://{place}")
        other = failure(f"rfc2217://{place}")
    assert type(error) is NoEcho
    assert "said “RFB 003.008”" in error.reason.en
    assert "другая сторона сообщила: «RFB 003.008»" in error.reason.ru
    assert "port number. Otherwise: Likely, in order: the bridge" in error.advice.en
    assert "RFB 003.008" in other.reason.en


@realtime
def test_words_with_other_bytes_are_no_esphome():
    greeting = b"J\0\0\0\x0a8.0.36\0\x08\0\xff\xff"
    with served(says(greeting, then=b"\x1c\0\0\1\xff#08S01Bad handshake")) as place:
        error = failure(f"socket://{place}")
    assert isinstance(error, LinkLost)
    assert not isinstance(error, OtherService)
    assert "8.0.36" in error.reason.en
    assert "\ufffd\ufffd" not in error.reason.en


@realtime
@pytest.mark.parametrize("name", ["ssh", "login", "ftp"])
def test_through_rfc2217_too(name):
    talk, remedy, _ = SERVICES[name]
    with served(talk) as place:
        error = failure(f"rfc2217://{place}")
    assert isinstance(error, OtherService)
    assert remedy in error.advice.en


@realtime
@pytest.mark.parametrize("answer", [b"?\r\r>", b"ELM327 v1.5\r\r>"])
def test_an_elm327_keeps_its_own_error(answer):
    with served(says(b"", then=answer, stays=True)) as place:
        error = failure(f"socket://{place}")
    assert isinstance(error, NotAKLineAdapter | OtherService)
    assert "KKL" in error.advice.en


@realtime
def test_a_banner_before_a_port_that_works_is_ignored():
    def banner(client: socket.socket) -> None:
        client.sendall(b"\r\nser2net port 2001 device /dev/ttyUSB0 [9600N81] login: none\r\n\r\n")
        unit(client)

    with served(banner) as place:
        assert connected(f"socket://{place}") == 9
    with served(TerminalServer(greets=b"\r\nlogin: none needed\r\n")) as place:
        assert connected(f"rfc2217://{place}") == 9


@realtime
@pytest.mark.parametrize("talk", [lambda client: None, reset])
def test_an_end_without_a_word_is_no_plug(talk):
    with served(talk) as place:
        error = failure(f"socket://{place}")
    assert isinstance(error, LinkLost)
    assert "without a word" in error.reason.en
    assert error.advice.en.startswith("Likely, in order: another program or phone")
    assert "без объяснений" in error.reason.ru


@realtime
def test_other_words_are_quoted():
    with served(says(b"No route to serial module 3\r\n")) as place:
        error = failure(f"socket://{place}")
    assert "which said “No route to serial module 3”" in error.reason.en


@realtime
def test_a_bridge_that_ends_after_work_is_a_lost_connection():
    def work(client: socket.socket) -> None:
        client.sendall(client.recv(3) + b"\x09\xf7\r")

    with served(work) as place, open_link(f"socket://{place}") as link:
        link.write(REQUEST)
        with pytest.raises(LinkLost) as caught:
            collect(link, 100)
    assert caught.value.reason.en.endswith("is lost: closed by the other end")


@pytest.mark.parametrize(("number", "words"), [(80, "HTTP"), (443, "TLS"), (1883, "MQTT")])
def test_a_silent_service_is_named_by_its_number(number, words):
    for error in (
        at_the_end("socket://h:1", number, b"", b"", telnet=False),
        in_handshake("socket://h:1", number, b"", telnet=False),
    ):
        assert words in error.reason.en
        assert "by its number" in error.reason.en
        assert "судя по номеру" in error.reason.ru


@pytest.mark.parametrize("number", [23, 2001, 8899])
def test_usual_numbers_of_bridges_mean_nothing(number):
    assert in_handshake("socket://h:1", number, b"", telnet=False) is None
    assert type(at_the_end("socket://h:1", number, b"", b"", telnet=False)) is LinkLost


@pytest.mark.parametrize(
    "first",
    [
        b"\x15\x03\x01" + REQUEST,
        b"SSH-2.0" + REQUEST,
        TELNET + REQUEST,
        b"busy" + REQUEST,
        b"\x09\xf7\r",
    ],
)
def test_bytes_of_a_line_are_no_service(first):
    assert in_handshake("socket://h:1", 80, first, telnet=False) is None


def test_each_service_has_both_languages():
    services = [it for _, it in other_end._SERVICES] + [*other_end._BY_NUMBER.values()]  # noqa: SLF001
    for name, advice in services:
        for text in (name, advice):
            assert isinstance(text, Text)
            assert text.en
            assert re.search("[а-яё]|MQTT|ELM327|SSH", text.ru)


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (b"Port already in use\r\n", "Port already in use"),
        (TELNET + b"\x1b[31mbusy\x07\r\n", "\ufffd[31mbusy\ufffd"),
        ("Занято".encode(), "Занято"),
        (b"\x01\xff\r\x09\xf7\r", ""),
        (b"", ""),
        (b"x" * 1000, "x" * 100),
    ],
)
def test_its_words_are_cleaned_and_short(data, text):
    assert said_in(data) == text
