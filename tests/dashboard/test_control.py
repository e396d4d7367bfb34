"""The control lease: its holder, its duration, taking it over."""

from __future__ import annotations

import pytest

from dashboard.rig import OTHER as SOMEBODY
from mikas.dashboard.errors import NotAllowed, NotController
from mikas.dashboard.security.control import AFTER_REQUEST, AFTER_SOCKET, Client, ControlLease

ME, OTHER, VIEWER = Client("me", "Me", True), Client("it", "", True), Client("v", "", False)


@pytest.fixture
def lease():
    now = [0.0]
    it = ControlLease(lambda: now[0])
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
    lease.socket_opened(ME)
    lease.socket_opened(ME)
    lease.demand(ME)
    lease.passes(9999)
    lease.socket_closed(ME)
    lease.passes(9999)
    assert lease.holder == ME
    lease.socket_closed(ME)
    lease.passes(AFTER_SOCKET - 0.1)
    assert lease.holder == ME
    lease.socket_opened(ME)
    lease.passes(9999)
    assert lease.holder == ME
    lease.socket_closed(ME)
    lease.passes(AFTER_SOCKET)
    assert lease.holder is None


def test_a_late_request_of_a_closed_page_does_not_keep_control(lease):
    lease.socket_opened(ME)
    lease.socket_closed(ME)
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
        lease.socket_opened(client)
    assert lease.viewers == 2
    lease.socket_closed(ME)
    assert lease.viewers == 2


def test_every_change_of_control_is_reported(lease):
    hands = []
    lease._changed = lambda: hands.append(lease._holder and lease._holder.id)
    lease.demand(ME)
    lease.demand(ME)
    lease.demand(OTHER, force=True)
    lease.release(OTHER)
    lease.demand(ME)
    lease.passes(AFTER_REQUEST)
    assert lease.holder is None
    assert hands == ["me", "it", None, "me", None]


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
    off.post("/disconnect", headers=SOMEBODY)
    assert off.get("/state")["controller"]["id"] == "tester-0002"
    off.post("/connect", {"port": 5}, 409)


def test_who_only_looks_does_not_take_the_seat(idle):
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
