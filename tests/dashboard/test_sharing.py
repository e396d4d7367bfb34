"""The switch that opens the dashboard to the network and closes it, over real sockets."""

from __future__ import annotations

import socket
import ssl
from collections import deque
from contextlib import contextmanager

import httpx
import pytest
from websockets.exceptions import ConnectionClosed

from dashboard.rig import ME, OTHER, rig
from dashboard.server_rig import watching
from mikas.dashboard.network.listening import bound

PHONE = "127.0.0.2"


@pytest.fixture
def it(tmp_path):
    with rig(tmp_path, None) as it:
        it.server.guard.clock = lambda: 0.0  # on a busy computer ten seconds pass before a request
        yield it


def switch(it, on, status=200, headers=ME, **more):
    answer = it.client.put("/api/network", json={"on": on, **more}, headers=headers)
    assert answer.status_code == status, answer.text
    return answer.json() if status == 200 else answer.json()["error"]


def token_of(about):
    return about["lan_url"].partition("token=")[2].partition("#")[0]


def blind():
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    return context


@contextmanager
def phone(it, token):
    headers = {**OTHER, "Authorization": f"Bearer {token}"}
    url = f"https://{PHONE}:{it.port}/api"
    with httpx.Client(base_url=url, headers=headers, verify=blind(), timeout=60) as client:
        yield client


def listens(it):
    try:
        socket.create_connection((PHONE, it.port), 60).close()
    except ConnectionRefusedError:
        return False
    return True


def test_on_there_is_an_encrypted_way_in_and_off_everything_is_closed_at_once(it):
    assert not listens(it)
    about = switch(it, True)
    token = token_of(about)
    assert (about["lan"], about["lan_control"], about["fingerprint"] is None) == (
        True,
        False,
        False,
    )
    assert about["lan_url"].startswith(f"https://{PHONE}:{it.port}/")
    assert it.get("/state")["lan"] is True
    live = f"wss://{PHONE}:{it.port}/api/live?client=watcher-0001&token={token}"
    with phone(it, token) as client, watching(live, blind()) as following:
        assert client.get("/about").json()["rights"] == "view"
        assert client.put("/network", json={"on": False}).json()["error"]["code"] == "NotAllowed"
        following()
        assert switch(it, False)["lan_url"] is None
        with pytest.raises(ConnectionClosed):
            deque(iter(following, None), maxlen=0)
        with pytest.raises(httpx.TransportError):
            client.get("/about")
    assert not listens(it)
    assert it.get("/state")["lan"] is False
    assert token_of(switch(it, True)) != token
    with phone(it, token) as client:
        assert client.get("/about").status_code == 401


def test_a_certificate_that_can_not_be_kept_is_said_to_who_switches_not_to_the_network(
    it, tmp_path, said
):
    (tmp_path / "state").mkdir()
    (tmp_path / "state" / "dashboard.pem").mkdir()
    tokens = [token_of(switch(it, True)) for _ in range(2)]
    (problem,) = it.get("/about")["problems"]
    assert f"can't be kept, so the next start makes another one ({tmp_path}" in problem["en"]
    with phone(it, tokens[1]) as client:
        assert client.get("/state").json()["unkept"] == 1
        assert client.get("/about").json()["problems"] == []  # a path of this computer
    assert len(said) == 1


def test_who_may_control_from_the_network_may_not_switch_and_loses_control_with_it(it):
    about = switch(it, True, control=True)
    with phone(it, token_of(about)) as client:
        assert client.get("/about").json()["rights"] == "control"
        assert client.put("/network", json={"on": False}).json()["error"]["code"] == "OnlyHere"
        # As this computer, by a made-up Host: the address is not this one's.
        forged = {"Host": f"127.0.0.1:{it.port}", "Via": "x"}
        refused = client.put("/network", json={"on": False}, headers=forged)
        assert refused.status_code == 403
        assert client.post("/control/take", json={}).status_code == 200
        assert it.get("/state")["controller"]["you"] is False
        switch(it, True)
        assert it.get("/state")["controller"] is None


def test_a_client_without_an_id_may_not_switch(it):
    assert it.client.put("/api/network", json={"on": True}).json()["error"]["code"] == "BadRequest"
    assert not listens(it)


def test_no_network_and_a_taken_port_are_told_in_words(it, monkeypatch):
    with bound(PHONE, it.port):
        assert f"{PHONE}:{it.port}" in switch(it, True, 409)["en"]
    settings = it.dashboard.settings
    object.__setattr__(settings, "addresses", lambda: ("garage",))
    assert "no address in a network" in switch(it, True, 409)["en"]
    about = it.get("/about")
    assert (about["lan"], about["lan_url"]) == (False, None)
