"""`mikas demo` as a process: its address, its end by Ctrl-C, what is left on the disk."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys

import httpx
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

import mikas
from dashboard.rig import ME

pytestmark = pytest.mark.realtime


@pytest.fixture
def demo(tmp_path):
    environment = {**os.environ, "HOME": str(tmp_path), "XDG_STATE_HOME": str(tmp_path / "state")}
    argv = ["demo", "--scenario", "warm-idle", "--no-browser", "--json", "--record", str(tmp_path)]
    process = subprocess.Popen(
        [sys.executable, "-m", "mikas", *argv],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment,
    )
    process.url = json.loads(process.stdout.readline())["url"]
    yield process
    process.kill()
    process.communicate()


def live(process):
    return connect(f"{process.url.replace('http', 'ws')}api/live?client=watcher-0001")


def until(socket, accepted):
    while True:
        message = json.loads(socket.recv(60))
        if accepted(message):
            return message


def recorded(message):
    return (message.get("state", {}).get("recording") or {"samples": 0})["samples"]


def test_ctrl_c_closes_the_recording_and_lets_everybody_go(demo, tmp_path):
    with live(demo) as watching:
        until(watching, lambda it: it.get("data"))
        started = httpx.post(f"{demo.url}api/recording/start", json={"name": "a"}, headers=ME)
        assert started.status_code == 200
        until(
            watching, lambda it: (it.get("state", {}).get("recording") or {}).get("samples", 0) > 9
        )
        demo.send_signal(signal.SIGINT)
        with pytest.raises(ConnectionClosed):
            until(watching, lambda _: False)
    assert demo.wait(60) == 130
    err = demo.stderr.read().decode()
    assert "Traceback" not in err
    assert f"is kept: {tmp_path / 'a.pcapng'}" in err
    assert len(mikas.open(tmp_path / "a.pcapng").to_pandas()) > 9


def test_a_second_ctrl_c_does_not_wait(demo):
    with socket.create_connection(("127.0.0.1", int(demo.url.rsplit(":", 1)[1][:-1]))) as half:
        half.sendall(b"POST /api/connect HTTP/1.1\r\nHost: x\r\n")  # and never the rest
        with live(demo) as watching:
            until(watching, lambda it: it.get("data"))
            demo.send_signal(signal.SIGINT)
            with pytest.raises(ConnectionClosed):
                until(watching, lambda _: False)
            demo.send_signal(signal.SIGINT)
            assert demo.wait(60) == 130
    assert "Traceback" not in demo.stderr.read().decode()


def test_many_are_no_trouble(demo):
    while demo.poll() is None:
        demo.send_signal(signal.SIGINT)
    assert demo.returncode == 130
    assert "Traceback" not in demo.stderr.read().decode()


def test_a_refused_socket_is_nothing_for_the_terminal(demo):
    with pytest.raises(InvalidStatus):
        connect(
            f"{demo.url.replace('http', 'ws')}api/live?client=watcher-0001",
            additional_headers={"Origin": "http://elsewhere"},
        )
    demo.send_signal(signal.SIGINT)
    assert demo.wait(60) == 130
    assert "ASGI" not in demo.stderr.read().decode()
