"""The control lease: its holder, its duration, taking it over."""

from __future__ import annotations

import json

import pytest

from dashboard.rig import OTHER as SOMEBODY
from mikas.dashboard.errors import Locked, NotAllowed, NotController
from mikas.dashboard.security.control import (
    AFTER_REQUEST,
    AFTER_SOCKET,
    Client,
    ControlLease,
    WriteLock,
)

ME, OTHER, VIEWER = Client("me", "Me", True), Client("it", "", True), Client("v", "", False)


@pytest.fixture
def lease():
    now, changes = [0.0], []
    it = ControlLease(lambda: now[0], changed=lambda: changes.append(now[0]))
    it.changes = changes
    it.passes = lambda seconds: now.__setitem__(0, now[0] + seconds)
    return it


def test_the_first_that_asks_has_it(lease):
    assert lease.holder is None
    lease.demand(ME)
    lease.demand(ME)
    assert lease.holder == ME
    with pytest.raises(NotController, match="Me has control"):
        lease.demand(OTHER)


def test_without_a_socket_it_is_free_a_minute_after_the_last_request(lease):
    lease.demand(ME)
    lease.passes(AFTER_REQUEST - 1)
    lease.demand(ME)
    lease.passes(AFTER_REQUEST - 1)
    assert lease.holder == ME
    lease.passes(1)
    assert lease.holder is None
    lease.demand(OTHER)
    assert lease.holder == OTHER


def test_with_a_socket_it_is_kept_and_a_reload_does_not_lose_it(lease):
    lease.socket_opened(ME, "a page")
    lease.socket_opened(ME, "a page")  # the page reconnected, and the lost socket is still counted
    lease.demand(ME)
    lease.passes(9999)
    lease.socket_closed(ME, "a page")
    lease.passes(9999)
    assert lease.holder == ME
    lease.socket_closed(ME, "a page")
    lease.passes(AFTER_SOCKET - 0.1)
    assert lease.holder == ME
    lease.socket_opened(ME, "it was loaded again")
    lease.passes(9999)
    assert lease.holder == ME
    lease.socket_closed(ME, "it was loaded again")
    lease.passes(AFTER_SOCKET)
    assert lease.holder is None


@pytest.mark.parametrize("seated", [0, 1, 2], ids=["before both", "between them", "after both"])
def test_a_second_socket_with_the_holders_id_does_not_keep_the_seat(lease, seated):
    for number, page in enumerate(("its own", "another's")):
        if number == seated:
            lease.demand(ME)
        lease.socket_opened(ME, page)
    if seated == 2:
        lease.demand(ME)
    lease.socket_closed(ME, "its own")
    lease.passes(AFTER_SOCKET - 0.1)
    assert lease.holder == ME
    lease.passes(0.1)
    assert lease.holder is None
    lease.socket_opened(ME, "a third")  # does not revive it
    assert lease.holder is None
    lease.socket_closed(ME, "another's")
    lease.demand(ME)  # the one that is left is its own
    lease.passes(9999)
    assert lease.holder == ME


def test_a_taken_seat_is_given_back_with_the_socket_that_kept_it(lease):
    lease.socket_opened(ME, "its own")
    lease.demand(ME)
    lease.demand(OTHER, force=True)()
    lease.passes(9999)
    assert lease.holder == ME
    undo = lease.demand(OTHER, force=True)
    lease.socket_closed(ME, "its own")
    undo()
    lease.passes(AFTER_SOCKET)
    assert lease.holder is None


def test_a_late_request_of_a_closed_page_does_not_keep_control(lease):
    lease.socket_opened(ME, "a page")
    lease.socket_closed(ME, "a page")
    lease.demand(ME)  # was under way when the page was closed
    lease.passes(AFTER_SOCKET - 0.1)
    assert lease.holder == ME  # it may be a reload, whose socket is not there yet
    lease.passes(0.1)
    assert lease.holder is None


def test_it_can_be_let_go_and_taken_over(lease):
    lease.demand(ME)
    lease.release(OTHER)
    assert lease.holder == ME
    lease.demand(OTHER, force=True)
    assert lease.holder == OTHER
    lease.release(OTHER)
    assert lease.holder is None


def test_a_viewer_never_gets_it(lease):
    with pytest.raises(NotAllowed):
        lease.demand(VIEWER)
    with pytest.raises(NotAllowed):
        lease.demand(VIEWER, force=True)


def test_viewers_are_clients_not_sockets(lease):
    for client in (ME, ME, VIEWER):
        lease.socket_opened(client, "a page")
    assert lease.viewers == 2
    lease.socket_closed(ME, "a page")
    assert lease.viewers == 2


def test_every_change_of_control_is_reported(lease):
    hands = []
    for step in (
        lambda: lease.demand(ME),
        lambda: lease.demand(ME),
        lambda: lease.demand(OTHER, force=True),
        lambda: lease.release(OTHER),
        lambda: lease.demand(ME),
        lambda: lease.passes(AFTER_REQUEST),
    ):
        step()
        hands.append((lease.holder and lease.holder.id, len(lease.changes)))
    assert hands == [("me", 1), ("me", 1), ("it", 2), (None, 3), ("me", 4), (None, 5)]


def test_a_failed_request_is_taken_back(lease):
    undo = lease.demand(ME)
    undo()
    assert lease.holder is None
    lease.demand(ME)
    lease.passes(AFTER_REQUEST - 1)
    lease.demand(ME)()
    lease.passes(1)
    assert lease.holder is None
    undo = lease.demand(ME)
    lease.demand(ME)  # a good one of the same client, at the same time
    undo()
    assert lease.holder == ME


def test_only_what_was_understood_and_allowed_takes_the_seat(off):
    for path, body, status in (
        ("/connect", {"port": 5}, 400),
        ("/connect", {"port": "nonsense://x"}, 400),
        ("/changes/unknown", {}, 410),
        ("/recording/note", {"text": "x" * (1 << 20)}, 413),
        ("/changes", {"kind": "delete_recording", "id": "none.pcapng"}, 404),
    ):
        off.post(path, body, status, SOMEBODY)
        assert off.get("/state")["controller"] is None, path
    assert off.post("/disconnect", headers=SOMEBODY)["controller"]["you"]
    assert not off.get("/state")["controller"]["you"]
    off.post("/connect", {"port": 5}, 409)


def faults_read(it):
    it.until(lambda message: message["state"]["fault_count"] is not None)


def test_who_only_looks_does_not_take_the_seat(idle):
    faults_read(idle)
    for headers in ({}, SOMEBODY):
        for path in ("/faults", "/state", "/history", "/catalog", "/ports"):
            idle.get(path, headers=headers)
            assert idle.get("/state")["controller"] is None, path
    idle.get("/passport", headers=SOMEBODY)
    idle.get("/memory/ram", headers=SOMEBODY, address="0", count=1)
    assert idle.get("/state")["controller"] is None
    idle.post("/relearn")
    assert idle.get("/passport", headers={})["version_code"]
    assert idle.get("/memory/ram", 409, SOMEBODY, address="0")["code"] == "NotController"
    assert idle.get("/state", headers={})["controller"]["you"] is False


def test_a_client_without_an_id_gets_known_data_and_no_new_request(idle):
    faults_read(idle)
    error = idle.get("/passport", 400, {})
    assert "X-Mikas-Client" in error["ru"]
    asked = []
    idle.dashboard.fault_history.read = asked.append
    assert idle.get("/faults", headers={})["count"] == 0
    assert asked == []


def test_looking_on_the_line_keeps_the_seat_for_who_has_it(lease):
    lease.demand(ME, take=False)
    assert lease.holder is None
    lease.demand(ME, take=False)()
    assert lease.holder is None
    lease.demand(ME)
    lease.passes(AFTER_REQUEST - 1)
    lease.demand(ME, take=False)
    lease.passes(AFTER_REQUEST - 1)
    assert lease.holder == ME
    with pytest.raises(NotController):
        lease.demand(OTHER, take=False)
    with pytest.raises(NotAllowed):
        lease.demand(VIEWER, take=False)


def test_an_unlock_is_not_handed_on(idle):
    idle.post("/unlock", {"minutes": 5})
    assert idle.get("/state")["unlocked_until"]
    state = idle.post("/control/take", {"force": True}, headers=SOMEBODY)
    assert state["unlocked_until"] is None
    wish = {"kind": "write_memory", "space": "ram", "address": 64, "data": "00"}
    assert idle.post("/changes", wish, 403, SOMEBODY)["code"] == "Locked"
    idle.post("/control/take", {"force": True})
    assert idle.post("/changes", wish, 403)["code"] == "Locked"


def test_what_is_shown_of_a_client_is_never_what_authorises(idle, capfd, caplog):
    """The second client reads everything that it may, and sends it back as its id."""
    owner, secret = {"X-Mikas-Client": "kept-secret-5f3a"}, "kept-secret-5f3a"  # and no name
    for ours in ("mikas", "uvicorn", "asyncio"):
        caplog.set_level("DEBUG", ours)
    idle.post("/recording/start", headers=owner)
    idle.post("/recording/note", {"text": "seen"}, headers=owner)
    idle.post("/unlock", {"minutes": 5}, headers=owner)
    refused = idle.post("/connect", {"port": "sim:"}, 409, SOMEBODY)
    seen = [json.dumps(idle.until(lambda it: it["state"]["controller"])), json.dumps(refused)]
    seen += [idle.client.get(f"/api{path}").text for path in READABLE]
    seen += [caplog.text, *capfd.readouterr()]
    files = idle.dashboard.settings.recordings.parent.rglob("*")
    seen += [file.read_bytes().decode("latin-1") for file in files if file.is_file()]
    assert not any(secret in text for text in seen)
    shown = idle.get("/state")["controller"]["id"]
    assert shown in refused["en"]
    wish = {"kind": "write_memory", "space": "ram", "address": 64, "data": "00"}
    for stolen in (shown, shown.upper(), f"{shown}-0000"):
        thief = {"X-Mikas-Client": stolen}
        assert not idle.get("/state", headers=thief)["controller"]["you"]
        assert idle.post("/changes", wish, 409, thief)["code"] == "NotController"
        assert idle.post("/lock", {}, 409, thief)["code"] == "NotController"
    assert idle.post("/changes", wish, headers=owner)["nonce"]


READABLE = ("/state", "/history", "/journal", "/recordings", "/dumps", "/about", "/faults")


def test_the_id_of_this_computer_is_another_client_in_the_network():
    here, there = (
        Client.with_secret("the-same-id", "", may_control=True, local=it) for it in (True, False)
    )
    assert here.id != there.id
    assert here.handle != there.handle
    assert here == Client.with_secret("the-same-id", "", may_control=True, local=True)
    assert "the-same-id" not in f"{here!r} {here.id} {here.handle}"
    assert here.id not in f"{here!r} {here.handle}"


def test_an_unlock_is_its_clients_alone():
    lock = WriteLock(lambda: 0.0)
    lock.open(ME, 60)
    lock.check(ME)
    with pytest.raises(Locked):
        lock.check(OTHER)
    lock.close()
    with pytest.raises(Locked):
        lock.check(ME)
