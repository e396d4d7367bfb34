"""The controller's seat: who has it, for how long, who may take it."""

from __future__ import annotations

import pytest

from mikas.dashboard.refusals import NotAllowed, NotController
from mikas.dashboard.seat import AFTER_REQUEST, AFTER_SOCKET, Client, Seat

ME, OTHER, VIEWER = Client("me", "Me", True), Client("it", "", True), Client("v", "", False)


@pytest.fixture
def seat():
    now = [0.0]
    it = Seat(lambda: now[0])
    it.passes = lambda seconds: now.__setitem__(0, now[0] + seconds)
    return it


def test_the_first_that_asks_has_it(seat):
    assert seat.holder is None
    seat.demand(ME)
    seat.demand(ME)
    assert seat.holder == ME
    with pytest.raises(NotController, match="Me has control"):
        seat.demand(OTHER)


def test_without_a_socket_it_is_free_a_minute_after_the_last_request(seat):
    seat.demand(ME)
    seat.passes(AFTER_REQUEST - 1)
    seat.demand(ME)
    seat.passes(AFTER_REQUEST - 1)
    assert seat.holder == ME
    seat.passes(1)
    assert seat.holder is None
    seat.demand(OTHER)
    assert seat.holder == OTHER


def test_with_a_socket_it_is_kept_and_a_reload_does_not_lose_it(seat):
    seat.opened(ME)
    seat.opened(ME)
    seat.demand(ME)
    seat.passes(9999)
    seat.closed(ME)
    seat.passes(9999)
    assert seat.holder == ME
    seat.closed(ME)
    seat.passes(AFTER_SOCKET - 0.1)
    assert seat.holder == ME
    seat.opened(ME)
    seat.passes(9999)
    assert seat.holder == ME
    seat.closed(ME)
    seat.passes(AFTER_SOCKET)
    assert seat.holder is None


def test_it_can_be_let_go_and_taken_over(seat):
    seat.demand(ME)
    seat.release(OTHER)
    assert seat.holder == ME
    seat.demand(OTHER, force=True)
    assert seat.holder == OTHER
    seat.release(OTHER)
    assert seat.holder is None


def test_a_viewer_never_gets_it(seat):
    with pytest.raises(NotAllowed):
        seat.demand(VIEWER)
    with pytest.raises(NotAllowed):
        seat.demand(VIEWER, force=True)


def test_viewers_are_clients_not_sockets(seat):
    for client in (ME, ME, VIEWER):
        seat.opened(client)
    assert seat.viewers == 2
    seat.closed(ME)
    assert seat.viewers == 2
