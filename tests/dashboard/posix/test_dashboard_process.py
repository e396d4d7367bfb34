"""`mikas demo` as a process: its address, its end by Ctrl-C, what is left on the disk."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
from contextlib import contextmanager
from urllib.parse import urlsplit

import httpx
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

import mikas
from dashboard.rig import ME

pytestmark = pytest.mark.realtime


PATIENT = """\
from mikas.cli.main import main
from mikas.dashboard import server

server._GRACE = 3600
main()
"""
"""`mikas`, which gives those an hour whom it has not answered yet when it is to end."""


@contextmanager
def running(folder, *program):
    environment = {**os.environ, "HOME": str(folder), "XDG_STATE_HOME": str(folder / "state")}
    argv = ["demo", "--scenario", "warm-idle", "--no-browser", "--json", "--record", str(folder)]
    process = subprocess.Popen(
        [sys.executable, *program, *argv],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment,
    )
    try:
        process.url = json.loads(process.stdout.readline())["url"]
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.fixture
def demo(tmp_path):
    with running(tmp_path, "-m", "mikas") as process:
        yield process


@pytest.fixture
def patient(tmp_path):
    with running(tmp_path, "-c", PATIENT) as process:
        yield process


def live(process, **headers):
    url = f"{process.url.replace('http', 'ws')}api/live?client=watcher-0001"
    return connect(url, additional_headers=headers, open_timeout=60)


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
        start = f"{demo.url}api/recording/start"
        assert httpx.post(start, json={"name": "a"}, headers=ME, timeout=60).status_code == 200
        until(watching, lambda it: recorded(it) > 9)
        demo.send_signal(signal.SIGINT)
        with pytest.raises(ConnectionClosed):
            until(watching, lambda _: False)
    assert demo.wait(60) == 130
    err = demo.stderr.read().decode()
    assert "Traceback" not in err
    assert f"saved: {tmp_path / 'a.pcapng'}" in err
    assert len(mikas.open(tmp_path / "a.pcapng").to_pandas()) > 9


def test_a_second_ctrl_c_does_not_wait(patient):
    address = urlsplit(patient.url)
    with socket.create_connection((address.hostname, address.port)) as half:
        half.sendall(
            f"POST /api/connect HTTP/1.1\r\nHost: {address.netloc}\r\nContent-Length: 9\r\n"
            "Content-Type: application/json\r\nX-Mikas-Client: half-0001\r\n"
            "Expect: 100-continue\r\n\r\n".encode()
        )
        assert half.recv(12) == b"HTTP/1.1 100"  # it waits for the body, which never comes
        with live(patient) as watching:
            until(watching, lambda it: it.get("data"))
            patient.send_signal(signal.SIGINT)
            with pytest.raises(ConnectionClosed):
                until(watching, lambda _: False)
            patient.send_signal(signal.SIGINT)
            assert patient.wait(60) == 130
    assert "Traceback" not in patient.stderr.read().decode()


def test_many_interrupts_end_it_as_one_does(demo):
    while demo.poll() is None:
        demo.send_signal(signal.SIGINT)
    assert demo.returncode == 130
    assert "Traceback" not in demo.stderr.read().decode()


def test_a_refused_socket_is_nothing_for_the_terminal(demo):
    with pytest.raises(InvalidStatus):
        live(demo, Origin="http://elsewhere")
    demo.send_signal(signal.SIGINT)
    assert demo.wait(60) == 130
    assert "ASGI" not in demo.stderr.read().decode()
