"""No command says a part of a password or of a signature in an address."""

from __future__ import annotations

import json
import logging
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import unquote

import pytest


@pytest.mark.parametrize(
    "arguments",
    [
        ("fleet", "sql", "{place}", "SELECT 1"),
        ("fleet", "report", "{place}"),
        ("fleet", "add", "{place}", "--to", "set"),
        ("fleet", "add", ".", "--to", "{place}"),
        ("fleet", "add", ".", "--to", "set", "--executor", "{place}"),
        ("info", "--port", "{place}"),
        ("log", "--port", "{place}", "-o", "x.pcapng"),
        ("doctor", "--port", "{place}"),
        ("publish", "{place}", "--port", "sim:"),
    ],
)
@pytest.mark.parametrize(
    "place",
    [
        "ftp://me:zq0000001/zq0000002@127.0.0.1:9/x",
        "ftp://me:zq0000001@zq0000002@127.0.0.1:9/x",
        "http://127.0.0.1:9/x.pcapng?X-Amz-Signature=zq0000001#zq0000002",
        "socket://me:zq0000001#zq0000002@127.0.0.1:9",
        "mqtt://me:zq0000001%zq0000002@127.0.0.1:9",
    ],
)
def test_a_command_says_no_part_of_it(mikas, arguments, place) -> None:
    for more in ((), ("--json",), ("-v",), ("--lang", "ru")):
        ran = mikas(*(it.format(place=place) for it in arguments), *more)
        assert ran.status
        assert "zq000" not in ran.out + ran.err
        if "--json" in more and ran.out:
            json.loads(ran.out.splitlines()[-1])


class Refusing(BaseHTTPRequestHandler):
    """Answers `/403/…` with 403, and tells the address again, unquoted."""

    def do_GET(self) -> None:
        self.send_error(int(self.path.split("/")[1]), f"no {unquote(self.path)}".replace("\n", ""))

    def do_HEAD(self) -> None:
        self.do_GET()

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def server() -> Iterator[str]:
    with ThreadingHTTPServer(("127.0.0.1", 0), Refusing) as serving:
        thread = threading.Thread(target=serving.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield f"http://127.0.0.1:{serving.server_port}"
        serving.shutdown()
        thread.join()


@pytest.mark.parametrize("words", [("-v",), ("-vv",), ("--json", "-v"), ("--lang", "ru", "-v")])
@pytest.mark.parametrize("status", [403, 500])
@pytest.mark.parametrize(
    "signature", ["zq0000001", "zq0000001%2Bzq0000002%2Fq8%3D", "zq0000001%2fzq%20zq0000002 ä"]
)
def test_a_server_that_refuses_a_signed_url(mikas, server, words, status, signature) -> None:
    pytest.importorskip("aiohttp")
    place = f"{server}/{status}/x.pcapng?sv=2022-11-02&sig={signature}"
    for arguments in (("fleet", "add", place, "--to", "set"), ("fleet", "sql", place, "SELECT 1")):
        ran = mikas(*arguments, *words)
        assert ran.status
        assert "zq" not in ran.out + ran.err
        assert f"{server}/{status}/x.pcapng" in ran.out + ran.err


def test_the_cause_that_v_names_is_there_without_a_password(mikas) -> None:
    pytest.importorskip("s3fs")
    place = "s3://K:zq0000001@bucket/x?sig=zq0000002"
    ran = mikas("-v", "fleet", "sql", place, "SELECT 1")
    assert "ParamValidationError" in ran.err
    assert "zq" not in ran.out + ran.err


@pytest.mark.parametrize("words", [(), ("-v",), ("--json",), ("--json", "-v"), ("--lang", "ru")])
@pytest.mark.parametrize("given", ["word", "option", "environment", "config"])
def test_a_bug_says_no_secret_of_an_address_that_the_program_was_given(
    mikas, monkeypatch, words, given
) -> None:
    port = "socket://me:zq0000001%2Bzq0000002@127.0.0.1:9"
    file = mikas.home / "config.toml"
    monkeypatch.setenv("MIKAS_CONFIG", str(file))
    more = {"word": ["--port", port], "option": [f"--port={port}"]}.get(given, [])
    if given == "config":
        monkeypatch.delenv("MIKAS_PORT")
        file.write_text(f'port = "{port}"', "utf-8")
    elif given == "environment":
        monkeypatch.setenv("MIKAS_PORT", port)

    def fail(url: str, **_: object) -> None:
        logging.getLogger("mikas.link").error("opening %s", url)
        raise RuntimeError(f"{unquote(url)} is odd") from ValueError(url)

    monkeypatch.setattr("mikas.cli.port_ahead.PortAhead.__init__", lambda _, url: fail(url))
    monkeypatch.setattr("mikas.client.connecting.open_link", fail)
    for arguments in (("info",), ("log", "-o", "x.pcapng"), ("watch",)):
        ran = mikas(*arguments, *more, *words)
        assert ran.status == 1
        assert "RuntimeError" in ran.out + ran.err
        assert "zq" not in ran.out + ran.err


def test_what_threads_and_libraries_print_has_no_secret_of_it(mikas, monkeypatch) -> None:
    monkeypatch.setenv("MIKAS_MQTT_PASSWORD", "zq0000003")
    monkeypatch.setattr("threading.excepthook", threading.__excepthook__)

    def fail() -> None:
        raise ValueError("socket://me:zq0000001%2b@127.0.0.1:9, zq0000003")

    def examine(*_: object, **__: object) -> Iterator[None]:
        thread = threading.Thread(target=fail)
        thread.start()
        thread.join()
        yield from ()

    monkeypatch.setattr("mikas.cli.commands.doctor.examine", examine, raising=False)
    ran = mikas("doctor", "--port", "socket://me:zq0000001+@127.0.0.1:9")
    assert "ValueError" in ran.err
    assert "zq" not in ran.out + ran.err


def test_a_wrong_command_line_says_no_password(mikas) -> None:
    for words in ((), ("--json",), ("-v",)):
        ran = mikas("doctor", "socket://me:zq0000001@127.0.0.1:9", *words)
        assert ran.status == 2
        assert "zq" not in ran.out + ran.err
