"""Connections of a real server: a slow, a half-open, a stalled client, and those that stay away."""

from __future__ import annotations

import json
import logging
import socket

import httpx
import pytest

from dashboard.rig import ME, rig
from mikas.dashboard.connections import (
    BODY_SECONDS,
    HEAD_SECONDS,
    STALL_SECONDS,
    TcpLimits,
)


class Clock:
    def __init__(self):
        self.now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A real server with places for 16 connections, whose clock stands still."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("mikas.dashboard.server._TICKS", 1)
        patch.setattr("mikas.dashboard.network.listening._SEND_BUFFER", 1 << 12)
        folder = tmp_path_factory.mktemp("small")
        (folder / "index.html").write_bytes(bytes(1 << 20))
        with rig(folder, None, page=folder) as it:
            it.server.guard.limits = TcpLimits(16)
            it.server.guard.clock = Clock()
            yield it


def opened(it, *parts):
    connection = socket.create_connection(("127.0.0.1", it.port), timeout=60)
    connection.sendall("\r\n".join(parts).encode())
    return connection


def is_closed(connection):
    with connection:
        try:
            while connection.recv(1 << 16):
                pass
        except ConnectionResetError:
            pass
    return True


HEAD = ("POST /api/connect HTTP/1.1", "Host: 127.0.0.1:{}", "X-Mikas-Client: tester-0001",
        "Content-Type: application/json", "Content-Length: 17")  # fmt: skip


def test_half_open_connections_shut_nobody_out(small, caplog, capfd):
    half = [opened(small, "GET / HTTP/1.1", "Ho") for _ in range(100)]
    assert small.client.get("/api/state").status_code == 200
    assert sum(is_closed(it) for it in half[:80]) == 80
    assert len(small.server.guard) <= small.server.guard.limits.total
    small.server.guard.clock.now += HEAD_SECONDS
    assert all(is_closed(it) for it in half[80:])
    # The client's own idle connection is closed in this moment, too: a new one has no race.
    kept = small.client
    with httpx.Client(base_url=kept.base_url, headers=kept.headers, cookies=kept.cookies) as new:
        assert new.get("/api/state").status_code == 200
    assert not [record for record in caplog.records if record.levelno >= logging.WARNING]
    assert capfd.readouterr().err == ""


def test_no_client_uses_a_connection_again_in_the_moment_of_its_end(small):
    reused = httpx.Limits().keepalive_expiry
    assert reused < small.server.config.timeout_keep_alive < HEAD_SECONDS


def test_a_request_and_its_body_have_their_time(small):
    clock = small.server.guard.clock
    head = [line.format(small.port) for line in HEAD]
    slow = opened(small, *head, "", '{"port":')
    refused = opened(small, *head[:2], "Host: evil.example", *head[3:], "", '{"port":')
    assert refused.recv(12) == b"HTTP/1.1 400"
    small.client.get("/api/state")
    clock.now += HEAD_SECONDS
    assert is_closed(refused)
    slow.sendall(b'"no:')
    clock.now += BODY_SECONDS - HEAD_SECONDS - 1
    small.client.get("/api/state")
    slow.sendall(b'//x"')
    clock.now += 1
    assert is_closed(slow)


@pytest.mark.parametrize("more", [["X: a"] * 200, ["X: " + "a" * 9000]], ids=["many", "long"])
def test_a_websocket_that_is_never_opened_keeps_no_place(small, more):
    asked = ("GET /api/live?client=tester-0001 HTTP/1.1", f"Host: 127.0.0.1:{small.port}",
             "Connection: Upgrade", "Upgrade: websocket")  # fmt: skip
    assert is_closed(opened(small, *asked, *more, "", ""))


def test_who_reads_nothing_of_a_response_gives_its_place_back(small):
    guard = small.server.guard

    def until(accepted):
        for _ in range(10_000):
            assert small.client.get("/api/ports").status_code == 200
            if accepted([it for it in list(guard._open.values()) if it.unsent]):  # noqa: SLF001
                return
        raise AssertionError("it never came")

    with socket.socket() as deaf:
        deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 12)
        deaf.connect(("127.0.0.1", small.port))
        deaf.sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{small.port}\r\n\r\n".encode())
        until(bool)
        until(lambda stalled: any(it._unsent for it in stalled))  # the server has noticed  # noqa: SLF001
        guard.clock.now += STALL_SECONDS
        until(lambda stalled: not stalled)


def test_a_page_that_reconnects_replaces_its_lost_connection(small):
    with small.live(page="one-page") as lost:
        lost.next()
        small.post("/control/release", headers={**ME, "X-Mikas-Client": "watcher-0001"})
        with small.live(page="one-page") as live, small.live(page="another") as other:
            assert is_over(lost) == 1001
            live.until(lambda it: it["state"]["viewers"] == 1)
            other.next()
            live.send({"ping": "still"})
            live.until(lambda it: it.get("pong") == "still")


def is_over(live):
    from websockets.exceptions import ConnectionClosed

    with pytest.raises(ConnectionClosed) as ended:
        live.until(lambda _: False)
    return ended.value.rcvd.code


def test_texts_that_no_message_can_carry_are_refused_and_kill_no_sender(small):
    with small.live() as other:
        for text in (r"\ud800", r"a\udfffb", r"\ude00\ud83d"):
            with small.live("watcher-0002") as live:
                live.socket.send(f'{{"ping":"{text}"}}')
                assert is_over(live) == 1008
            for path, name in (("/recording/marker", "label"), ("/recording/note", "text")):
                sent = {"content": f'{{"{name}":"{text}"}}'}
                kind = {**ME, "Content-Type": "application/json"}
                answer = small.client.post(f"/api{path}", headers=kind, **sent)
                assert answer.status_code == 400, path
                json.loads(answer.text)
        other.send({"ping": "\x1b[2J"})
        assert other.until(lambda it: "pong" in it)["pong"] == "\ufffd[2J"
