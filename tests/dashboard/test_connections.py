"""The bounds of connections: half-open ones, slow ones, many of one address; no descriptor left."""

from __future__ import annotations

import asyncio
import errno
import json
import logging
import socket

import httpx
import pytest

from dashboard.rig import ME, rig
from mikas.dashboard.connections import (
    BODY_SECONDS,
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
from mikas.dashboard.listening import listen


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


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A real server with places for 16 connections, whose clock stands still."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("mikas.dashboard.server._TICKS", 1)
        patch.setattr("mikas.dashboard.listening._SEND_BUFFER", 1 << 12)
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
    assert small.client.get("/api/state").status_code == 200
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
