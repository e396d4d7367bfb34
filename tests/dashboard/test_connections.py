"""The bounds of connections: half-open ones, slow ones, many of one address; no descriptor left."""

from __future__ import annotations

import asyncio
import errno
import socket

import pytest

from mikas.dashboard.connections import (
    GOODBYE_SECONDS,
    HEAD_SECONDS,
    LONGEST_TURN,
    MAX_NEW,
    STALL_SECONDS,
    AcceptedSocket,
    TcpConnections,
    TcpLimits,
    TcpPhase,
    TurnClock,
)
from mikas.dashboard.entrance import Entrance
from mikas.dashboard.network.listening import listen


class Clock:
    def __init__(self):
        self.now = 0.0

    def __call__(self):
        return self.now


class Accepted:
    """A socket that is not there."""

    count = 0

    def __init__(self):
        Accepted.count += 1
        self.number, self.ended, self.unsent = Accepted.count, False, 0

    def getsockname(self):
        return "127.0.0.1", self.number

    def shutdown(self, _):
        self.ended = True
        raise OSError(errno.ENOTCONN, "it has gone already")


class Transport:
    def __init__(self, accepted):
        self.accepted, self.unsent = accepted, 0

        self.closing = False

    def get_protocol(self):
        return None

    def is_closing(self):
        return self.closing

    def get_write_buffer_size(self):
        return self.unsent

    def abort(self):
        self.accepted.ended = True


def peer(address):
    """The other end: an address in the network, or None for this computer."""
    return address or "127.0.0.1", 50_000


@pytest.fixture
def guard():
    return TcpConnections(TcpLimits(64), Clock())  # 16 kept for this computer, 8 for each address


def come(guard, address, count=1):
    """The sockets of `count` new connections that came in; the clock moves on with each."""
    came = []
    for _ in range(count):
        guard.clock.now += 1
        accepted = Accepted()
        if guard.admit(accepted, peer(address)):
            came.append(accepted)
    return came


def work(guard, accepted):
    """It has sent its request."""
    return enter(guard, accepted, TcpPhase.NOTHING)


def enter(guard, accepted, phase):
    transport = Transport(accepted)
    accepted.connection.attach(transport, None)
    accepted.connection.enter(phase, guard.clock())
    return transport


def test_half_open_connections_make_room_for_the_next_one(guard):
    came = come(guard, None, 400)
    assert len(came) == 400
    assert [it.ended for it in came] == [True] * 336 + [False] * 64


def test_one_address_in_the_network_takes_places_from_itself_only(guard):
    (other,) = come(guard, "10.0.0.9")
    many = come(guard, "10.0.0.1", 400)
    assert sum(not it.ended for it in many) == guard.limits.each
    assert not other.ended


def test_an_address_whose_places_are_all_at_work_gets_no_more(guard):
    came = come(guard, "10.0.0.1", guard.limits.each)
    for it in came:
        work(guard, it)
    assert come(guard, "10.0.0.1") == []
    assert come(guard, "10.0.0.2")
    came[0].left()  # its socket was closed
    assert come(guard, "10.0.0.1")


def test_the_network_at_work_leaves_places_for_this_computer(guard):
    came = [it for host in range(20) for it in come(guard, f"10.0.0.{host}", 8)]
    for it in came:
        if not it.ended:
            work(guard, it)
    assert sum(not it.ended for it in came) == 48
    assert come(guard, "10.0.1.1") == []
    here = come(guard, None, 40)
    assert len(here) == 40
    assert not here[-1].ended


def test_an_address_opens_no_more_than_so_many_a_second(guard):
    came = [guard.admit(Accepted(), peer("10.0.0.1")) for _ in range(MAX_NEW + 5)]
    assert came == [True] * MAX_NEW + [False] * 5
    assert guard.admit(Accepted(), peer(None))
    guard.clock.now += 1
    assert guard.admit(Accepted(), peer("10.0.0.1"))


@pytest.mark.parametrize("phase", TcpPhase)
def test_a_client_has_so_long_for_each_phase(guard, phase):
    (it,) = come(guard, None)
    enter(guard, it, phase)
    for _ in range(50):
        guard.clock.now += (phase.value or 1e6) / 51
        guard.sweep()
    assert not it.ended
    guard.clock.now += (phase.value or 1e6) / 50
    guard.sweep()
    assert it.ended is (phase is not TcpPhase.NOTHING)


@pytest.mark.parametrize("phase", TcpPhase)
def test_who_takes_nothing_of_what_was_sent_is_dropped_and_a_slow_one_is_not(guard, phase):
    (it,) = come(guard, None)
    transport = enter(guard, it, phase)
    for transport.unsent in range(9000, 0, -100):
        guard.clock.now += STALL_SECONDS - 1
        guard.sweep()
    assert not it.ended
    assert come(guard, None, 400)
    assert not it.ended  # nor to make room
    transport.unsent += 1000  # more was sent to it
    guard.clock.now += STALL_SECONDS
    guard.sweep()
    assert it.ended


def test_a_connection_that_can_t_be_checked_ends_no_sweep(guard, caplog):
    broken, both, late = come(guard, None, 3)
    for it in (broken, both):
        enter(guard, it, TcpPhase.NOTHING).get_write_buffer_size = lambda: 1 // 0
    both.connection._transport.abort = lambda: 1 // 0  # noqa: SLF001
    guard.clock.now += HEAD_SECONDS
    guard.sweep()
    assert late.ended
    assert broken.ended
    assert "could not be checked" in caplog.text
    assert "could not be closed" in caplog.text
    caplog.clear()
    guard.sweep()
    assert not caplog.records


@pytest.mark.parametrize("phase", [TcpPhase.REQUEST, TcpPhase.BODY, TcpPhase.NOTHING])
def test_who_does_not_say_goodbye_is_dropped_once_all_is_sent(guard, phase):
    (it,) = come(guard, None)
    transport = enter(guard, it, phase)
    transport.closing = True
    for it.unsent in range(9000, 0, -1000):  # of the transport below TLS
        guard.clock.now += STALL_SECONDS - 1
        guard.sweep()
    it.unsent = 0
    guard.clock.now += GOODBYE_SECONDS
    guard.sweep()
    assert not it.ended
    guard.clock.now += GOODBYE_SECONDS
    guard.sweep()
    assert it.ended


def test_a_stall_of_the_program_is_no_time_of_a_client():
    time = Clock()
    guard = TcpConnections(TcpLimits(64), TurnClock(time))
    it = Accepted()
    assert guard.admit(it, peer(None))

    def turns(seconds):
        for _ in range(int(seconds / 0.25)):
            time.now += 0.25
            guard.sweep()

    turns(HEAD_SECONDS - 0.5)
    time.now += 3600  # it was stopped, or the computer slept
    guard.sweep()
    turns(0.25)
    assert not it.ended
    time.now += LONGEST_TURN + 0.25  # starved
    guard.sweep()
    assert not it.ended
    turns(0.25)
    assert it.ended


def test_bytes_that_the_system_did_not_take_are_counted():
    ours, theirs = socket.socketpair()
    with theirs, AcceptedSocket(fileno=ours.detach()) as own:
        own.setblocking(False)
        for send in (own.send, lambda data: own.sendmsg([data[:5], memoryview(data)[5:]])):
            data, sent = bytes(1 << 24), 0
            while (taken := send(data[sent:])) and taken < len(data) - sent:
                sent += taken
                assert own.unsent == len(data) - sent
                with pytest.raises(BlockingIOError):
                    own.send(b"more")
                assert own.unsent == 4
                assert theirs.recv(1 << 24)
            assert own.unsent == 0
            while own.unsent == 0:
                assert theirs.recv(1 << 24)
                break


class NoFileLeft:
    """A listening socket where the system accepts only with the spare descriptor free."""

    def __init__(self, guard, waiting):
        self.guard, self.waiting, self.closed, self.asked = guard, waiting, 0, 0

    def accept(self):
        self.asked += 1
        if self.guard._spare is not None:  # noqa: SLF001
            raise OSError(errno.EMFILE, "no file left")
        if not self.waiting:
            raise BlockingIOError
        self.waiting -= 1
        return self, None

    def close(self):
        self.closed += 1


def test_without_a_descriptor_connections_are_closed_and_nothing_spins(guard, caplog):
    came = come(guard, None, 3)
    listening = NoFileLeft(guard, 2)
    with pytest.raises(BlockingIOError):
        guard.accept(listening)
    assert (listening.closed, listening.asked) == (2, 6)
    assert all(it.ended for it in came)  # half-open ones, whose descriptors are free now
    guard._spare = -1  # noqa: SLF001
    endless = NoFileLeft(guard, 10**9)
    endless.accept = lambda: (_ for _ in ()).throw(ConnectionAbortedError())
    with pytest.raises(ConnectionAbortedError):  # which the entrance takes for the end
        guard.accept(endless)


def test_without_a_descriptor_the_entrance_says_so_and_tries_again(guard, caplog, monkeypatch):
    monkeypatch.setattr("mikas.dashboard.connections._spare", lambda: None)
    monkeypatch.setattr("mikas.dashboard.entrance._OUT_OF_DESCRIPTORS", 0.01)
    tried = []

    def full(_):
        tried.append(1)
        if len(tried) == 2:
            over.set()
        raise OSError(errno.EMFILE, "no file left")

    async def main():
        with listen(0, lan=False) as own, socket.create_connection(own.getsockname()):
            entrance = Entrance(own, asyncio.Protocol, guard, None)
            entrance.open()
            await asyncio.wait_for(over.wait(), 60)
            await entrance.close()

    monkeypatch.setattr(guard, "accept", full)
    over = asyncio.Event()
    asyncio.run(main())
    assert {record.exc_info for record in caplog.records} == {None}
    assert "no files left" in caplog.text


def test_what_is_sent_does_not_wait_for_an_acknowledgement(guard):
    class Made(asyncio.Protocol):
        def connection_made(self, transport):
            own = transport.get_extra_info("socket")
            sends_at_once.set_result(own.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))

    async def main():
        nonlocal sends_at_once
        sends_at_once = asyncio.get_running_loop().create_future()
        with listen(0, lan=False) as own, socket.create_connection(own.getsockname()):
            entrance = Entrance(own, Made, guard, None)
            entrance.open()
            assert await asyncio.wait_for(sends_at_once, 60)
            await entrance.close()

    sends_at_once = None
    asyncio.run(main())
