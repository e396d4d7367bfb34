"""TLS for the network over real sockets; what does not shake hands is closed."""

from __future__ import annotations

import asyncio
import json
import socket
import ssl
from contextlib import ExitStack, contextmanager, suppress
from datetime import UTC, datetime
from hashlib import sha256
from time import monotonic

import httpx
import pytest

from dashboard.rig import ME, rig
from dashboard.server_rig import watching
from mikas.dashboard import entrance
from mikas.dashboard.connections import (
    GOODBYE_SECONDS,
    HEAD_SECONDS,
    STALL_SECONDS,
    TcpLimits,
)
from mikas.dashboard.security.certificate import own_certificate

TOKEN = "a-token-of-the-test"


@pytest.fixture(scope="module")
def certificate(tmp_path_factory):
    file = tmp_path_factory.mktemp("state") / "dashboard.pem"
    made = own_certificate(file, ("127.0.0.1", "garage"), datetime.now(UTC))
    trusting = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)  # checks the names, too
    trusting.load_verify_locations(file)
    return made, trusting


@contextmanager
def served(folder, made):
    settings = {"lan": True, "hosts": ("127.0.0.1",), "token": TOKEN}
    with rig(folder, None, tls=made.context, fingerprint=made.fingerprint, **settings) as it:
        yield it


@pytest.fixture
def lan(certificate, tmp_path, monkeypatch):
    """A dashboard to which every address is one of the network."""
    monkeypatch.setattr(entrance, "PLAIN", "")
    with served(tmp_path, certificate[0]) as it:
        yield it


def raw(lan):
    return socket.create_connection(("127.0.0.1", lan.port), 60)


def end_of(connection):
    """What comes until the connection is closed from there."""
    data = b""
    try:
        while piece := connection.recv(100):
            data += piece
    except ConnectionResetError:
        pass
    return data


def test_the_certificate_is_the_one_of_the_fingerprint(lan, certificate):
    blind = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    blind.check_hostname, blind.verify_mode = False, ssl.CERT_NONE
    with raw(lan) as plain, blind.wrap_socket(plain) as connection:
        shown = sha256(connection.getpeercert(binary_form=True)).digest().hex(":").upper()
        assert connection.version() in ("TLSv1.2", "TLSv1.3")
    assert shown == certificate[0].fingerprint
    assert lan.access.lan_url.endswith(f"/?token={TOKEN}#sha256={shown[:23]}")


def test_page_api_and_live_data_are_encrypted(lan, certificate):
    url = f"https://127.0.0.1:{lan.port}"
    with httpx.Client(base_url=url, verify=certificate[1], timeout=60) as phone:
        network = {"Host": f"127.0.0.1:{lan.port}", "Authorization": f"Bearer {TOKEN}"}
        opened = phone.get(f"/?token={TOKEN}")
        assert "strict-transport-security" not in opened.headers
        assert opened.headers["cross-origin-opener-policy"] == "same-origin"
        about = phone.get("/api/about", headers=network).json()
        assert about["fingerprint"] == certificate[0].fingerprint
        for origin, status in ((url, 200), (url.replace("https", "http"), 403)):
            headers = {**ME, **network, "Origin": origin}
            assert phone.post("/api/disconnect", json={}, headers=headers).status_code == status
    live = f"wss://127.0.0.1:{lan.port}/api/live?client=watcher-0001&token={TOKEN}"
    with watching(live, certificate[1], origin=url) as following:
        assert "state" in json.loads(following())
    upgrade = {
        "Connection": "Upgrade",
        "Upgrade": "websocket",
        "Sec-WebSocket-Version": "13",
        "Sec-WebSocket-Key": 22 * "A" + "==",
        "Origin": url.replace("https", "http"),
    }
    refused = httpx.get(live.replace("wss", "https"), headers=upgrade, verify=certificate[1])
    assert refused.status_code == 403


def test_the_cookie_of_the_link_is_sent_encrypted_only(certificate, tmp_path, monkeypatch):
    monkeypatch.setattr(entrance, "PLAIN", "")
    made, trusting = certificate
    settings = {"lan": True, "hosts": ("garage",), "token": TOKEN}
    with rig(tmp_path, None, tls=made.context, fingerprint=made.fingerprint, **settings) as it:
        host = {"Host": f"garage:{it.port}"}
        with httpx.Client(base_url=f"https://127.0.0.1:{it.port}", verify=trusting) as phone:
            cookie = phone.get(f"/?token={TOKEN}", headers=host).headers["set-cookie"]
            assert "Secure" in cookie
            kept = {**host, "Cookie": cookie.partition(";")[0]}
            assert phone.get("/api/about", headers=kept).json()["rights"] == "view"


def test_this_computer_needs_no_certificate(certificate, tmp_path):
    with served(tmp_path, certificate[0]) as it:
        assert it.get("/about")["rights"] == "control"
        assert it.get("/about")["lan_url"].startswith("https://")
        with it.live() as live:
            assert live.next()["state"]


def test_what_does_not_shake_hands_is_closed_without_a_word(lan, certificate, caplog):
    with raw(lan) as browser:  # which was given http://
        browser.sendall(f"GET /?token={TOKEN} HTTP/1.1\r\nHost: a\r\n\r\n".encode())
        answer = end_of(browser)
        assert b"HTTP" not in answer
        assert TOKEN.encode() not in answer
    with raw(lan) as silent:
        lan.server.guard.clock = lambda: monotonic() + HEAD_SECONDS
        assert end_of(silent) == b""
    with raw(lan) as short:
        short.sendall(b"\x16\x03\x01")
    context = certificate[1]
    with raw(lan) as plain, context.wrap_socket(plain, server_hostname="garage"):
        pass  # the others go on
    assert caplog.records == []


def test_half_open_handshakes_make_room_for_the_next_one(certificate, tmp_path, monkeypatch):
    monkeypatch.setattr(entrance, "PLAIN", "")
    monkeypatch.setattr(TcpLimits, "of_this_process", lambda: TcpLimits(4))
    made, trusting = certificate
    with served(tmp_path, made) as it, ExitStack() as kept:
        silent = [kept.enter_context(raw(it)) for _ in range(8)]
        with raw(it) as plain, trusting.wrap_socket(plain, server_hostname="garage"):
            assert end_of(silent[0]) == b""


def test_closed_to_the_network_it_ends_its_connections_and_takes_no_more(lan, certificate):
    entrance = lan.server._entrances[0]  # noqa: SLF001
    loop = lan.reached.loop
    with raw(lan) as plain, certificate[1].wrap_socket(plain, server_hostname="garage") as open_one:
        open_one.sendall(b"GET / HTTP/1.1\r\n")  # the handshake is over at both ends
        with raw(lan) as half_open:
            loop.call_soon_threadsafe(entrance.admit_network, None)
            assert end_of(open_one) == b""
            assert end_of(half_open) == b""
    with raw(lan) as late:
        assert end_of(late) == b""


UPGRADE = (
    "GET /api/live?client=watcher-0001 HTTP/1.1\r\nHost: garage:{port}\r\nUpgrade: websocket\r\n"
    "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA"
    "==\r\n\r\n"
)


def in_loop(lan, function):
    """What `function` returns in the loop of the server."""

    async def called():
        return function()

    return asyncio.run_coroutine_threadsafe(called(), lan.reached.loop).result(60)


def test_a_slow_client_gets_the_end_of_a_response_that_was_closed_long_ago(
    lan, certificate, tmp_path
):
    page, guard, now = tmp_path / "page", lan.server.guard, [0.0]
    guard.clock = lambda: now[0]
    page.mkdir()
    (page / "index.html").write_bytes(bytes(600_000))
    with socket.socket() as plain:
        plain.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 12)
        plain.connect(("127.0.0.1", lan.port))
        with certificate[1].wrap_socket(plain, server_hostname="garage") as client:
            host = f"Host: 127.0.0.1:{lan.port}\r\nConnection: close"
            client.sendall(f"GET / HTTP/1.1\r\n{host}\r\n\r\n".encode())
            data = client.recv(1 << 12)
            (connection,) = guard._open.values()  # noqa: SLF001
            while not in_loop(lan, lambda: connection.is_closing):
                data += client.recv(1 << 12)
            assert in_loop(lan, lambda: connection.unsent)
            for _ in range(3):
                in_loop(lan, guard.sweep)
                now[0] += STALL_SECONDS / 3
            data += end_of(client)
    assert len(data.partition(b"\r\n\r\n")[2]) == 600_000


def test_a_refused_client_that_does_not_end_tls_ends_no_sweep_and_keeps_no_place(lan, certificate):
    guard, now = lan.server.guard, [0.0]
    guard.clock = lambda: now[0]

    with raw(lan) as plain, certificate[1].wrap_socket(plain, server_hostname="garage") as client:
        client.sendall(UPGRADE.format(port=lan.port).encode())
        assert client.recv(12) == b"HTTP/1.1 403"
        (connection,) = guard._open.values()  # noqa: SLF001
        for _ in range(3):  # as uvicorn does; asyncio's own transport of TLS can bear only one
            in_loop(lan, connection._transport.close)  # noqa: SLF001
            assert in_loop(lan, lambda: (connection.is_closing, connection.unsent)) == (True, 0)
        for _ in range(2):
            in_loop(lan, guard.sweep)
            now[0] += GOODBYE_SECONDS
        with suppress(ssl.SSLError):
            end_of(client)
        while in_loop(lan, lambda: len(guard)):
            pass


class Dropped:
    dropped = True


@pytest.mark.parametrize(("connection", "context"), [(Dropped(), None), (None, "of before")])
def test_a_connection_that_was_ended_while_it_shook_hands_gets_no_protocol(connection, context):
    class Transport:
        aborted = False

        def abort(self):
            self.aborted = True

    made, transport = [], Transport()
    it = entrance.Entrance(None, lambda: made.append(1), None, None)
    it.begin(connection, transport, context)
    assert transport.aborted
    assert not made


def test_a_websocket_whose_client_takes_no_answers_is_aborted():
    class Full:
        aborted, written, closing, size = 0, 0, False, 0

        def get_write_buffer_size(self):
            return self.size

        def is_closing(self):
            return self.closing

        def abort(self):
            self.aborted, self.closing = self.aborted + 1, True

        def write(self, data):
            self.written += len(data)

        def set_protocol(self, _):
            pass

    transport = Full()
    served = entrance.ServedTransport(transport)
    transport.size = 1 << 30  # a response, which waits by itself
    served.write(b"a")
    served.set_protocol(None)
    transport.size = 1 << 16
    served.write(b"b")
    assert (transport.written, transport.aborted) == (2, 0)
    transport.size = 1 << 23
    for _ in range(3):
        served.write(b"c")
    assert (transport.written, transport.aborted) == (2, 1)
