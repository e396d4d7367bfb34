"""A connection that brings nothing is dead; what is slow, stopped or not asked for is not."""

from __future__ import annotations

from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.errors import ConnectionSilent, PortKind, ReadingSuspended
from mikas.link import Chunk
from mikas.link.network.silence import SILENT, SilenceGuard
from mikas.link.suspension import LATE, SuspensionGuard

from ..test_suspension import Port


class Bridge(Port):
    """A connection on simulated time."""

    kind = PortKind.NETWORK
    url = "socket://bridge:1"
    given_up = False

    def give_up(self) -> None:
        self.given_up = True

    def read(self, deadline: float) -> Chunk:
        assert deadline < inf or self.arrivals
        return super().read(deadline)


def guarded(*arrivals: tuple[float, bytes], timeout: float = 0.5) -> tuple[Bridge, SilenceGuard]:
    bridge = Bridge(*arrivals)
    return bridge, SilenceGuard(SuspensionGuard(bridge), timeout=timeout)


def ask(guard: SilenceGuard, seconds: float = 0.5) -> bytes:
    """Send a request and wait for its echo."""
    guard.write(b"\x01\xff\r")
    return guard.read(guard.now() + seconds).data


def wait_for_ever(guard: SilenceGuard, seconds: float) -> None:
    while True:
        guard.read(guard.now() + seconds)


@pytest.mark.parametrize("wait", [0.001, 0.1, 0.5, 60.0])
def test_a_connection_that_brings_nothing_is_dead_after_two_seconds(wait):
    bridge, guard = guarded()
    began = bridge.time
    guard.write(b"\x01\xff\r")
    with pytest.raises(ConnectionSilent) as caught:
        wait_for_ever(guard, wait)
    assert bridge.time == pytest.approx(began + SILENT, abs=0.01)
    assert bridge.given_up
    assert caught.value.fields["seconds"] == SILENT
    assert "bridge" in caught.value.text.en
    assert "мост" in caught.value.text.ru


def test_all_calls_say_so_afterwards():
    _, guard = guarded()
    guard.write(b"x")
    for use in (lambda: guard.read(guard.now() + 60), lambda: guard.write(b"y")) * 2:
        with pytest.raises(ConnectionSilent):
            use()
    with pytest.raises(ConnectionSilent):
        guard.send_break(0.05)


def test_where_nothing_was_asked_nothing_is_missed():
    bridge, guard = guarded()
    for _ in range(1000):
        assert guard.read(guard.now() + 1.0).data == b""
    assert not bridge.given_up


def test_a_request_after_a_long_silence_has_time_for_its_echo():
    bridge, guard = guarded((60.5, b"\x01\xff\r"))
    guard.read(guard.now() + 60.0)
    assert ask(guard, 0.7) == b"\x01\xff\r"
    guard.read(guard.now() + 60.0)
    with pytest.raises(ConnectionSilent):
        ask(guard, 1.0)
    assert bridge.given_up


@pytest.mark.parametrize("timeout", [2.5, 4.0, 30.0])
def test_a_slow_network_has_the_time_that_a_request_has(timeout):
    delay = timeout - 0.1
    bridge, guard = guarded(*((delay * at, b"\x01\xff\r") for at in range(1, 9)), timeout=timeout)
    for _ in range(8):
        assert ask(guard, timeout) == b"\x01\xff\r"
    guard.write(b"\x01\xff\r")
    began = guard.now()
    with pytest.raises(ConnectionSilent):
        wait_for_ever(guard, timeout)
    assert bridge.time == pytest.approx(began + timeout + 0.3, abs=0.01)


def test_each_byte_begins_the_patience_anew():
    _, guard = guarded(*((1.9 * at, b"\x55") for at in range(1, 100)))
    for _ in range(1, 100):
        assert ask(guard, 3.0) == b"\x55"


@given(st.lists(st.floats(0.0, 1.9), min_size=1, max_size=40), st.floats(0.0, LATE - 0.01))
def test_a_busy_computer_and_a_slow_network_are_no_silence(delays, late):
    """Each wait ends late, and each echo comes late, for as long as it goes on."""
    bridge, guard = guarded()
    for delay in delays:
        guard.write(b"\x01\xff\r")
        bridge.arrivals.append((bridge.time + delay, b"\x01\xff\r"))
        data = b""
        while not data:
            bridge.late = late
            data = guard.read(guard.now() + 0.5).data


def test_the_time_in_which_the_program_did_not_run_does_not_count():
    bridge, guard = guarded()
    for _ in range(10):
        guard.write(b"\x01\xff\r")
        bridge.late = 30.0
        with pytest.raises(ReadingSuspended):
            guard.read(guard.now() + 0.5)
    assert not bridge.given_up
    bridge.arrivals.append((bridge.time + 0.1, b"\x01\xff\r"))
    assert ask(guard) == b"\x01\xff\r"


def test_a_stop_before_a_request_does_not_count():
    bridge, guard = guarded()
    ask(guard, 1.5)
    bridge.time += 60.0
    with pytest.raises(ReadingSuspended):
        guard.write(b"\x01\xff\r")
    assert ask(guard, 1.5) == b""
    assert not bridge.given_up


def test_time_that_passes_without_a_read_does_not_count():
    bridge, guard = guarded()
    ask(guard, 1.0)
    guard.gather(guard.now() + 30.0)
    assert guard.read(guard.now() + 0.5).data == b""
    assert not bridge.given_up
