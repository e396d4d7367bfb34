"""The connection to a broker (amqtt in this process): order, will, outages, refusals."""

from __future__ import annotations

import gc
import socket
import threading
from pathlib import Path

import pytest
from broker_rig import PATIENCE, InProcessBroker, Listener, Relay, free_port, is_

from mikas.errors import (
    BrokerLost,
    BrokerNotFound,
    BrokerRefused,
    BrokerUnreachable,
    MissingExtra,
    NoBroker,
)
from mikas.publish import connection as module
from mikas.publish.broker import Broker
from mikas.publish.connection import BrokerChange, BrokerConnection
from mikas.publish.outbox import Message, MessageKind, Outbox

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.filterwarnings("ignore::ResourceWarning"),  # the fixture `connect` says why
]

ONLINE = Message("car/availability", b"online", MessageKind.RETAINED)
OFFLINE = Message("car/availability", b"offline", MessageKind.RETAINED)


@pytest.fixture
def broker():
    broker = InProcessBroker()
    yield broker
    broker.close()


@pytest.fixture
def relay(broker):
    relay = Relay(broker.port)
    yield relay
    relay.close()


@pytest.fixture
def listener(broker):
    listener = Listener(broker.port)
    yield listener
    listener.close()


class Changes(list):
    """What a connection reports, to be waited for."""

    def __init__(self) -> None:
        super().__init__()
        self._changed = threading.Condition()

    def __call__(self, change: BrokerChange) -> None:
        with self._changed:
            self.append(change)
            self._changed.notify_all()

    def wait_for(self, count: int) -> BrokerChange:
        with self._changed:
            assert self._changed.wait_for(lambda: len(self) >= count, PATIENCE), self
        return self[count - 1]


@pytest.fixture
def connect(broker, monkeypatch):
    """Make a connection to the broker, and end it with the test."""
    monkeypatch.setattr(module, "_PAUSE", 0.05)
    made = []

    def connect(outbox=None, to=None, **settings):
        to = to or Broker("127.0.0.1", broker.port)
        settings = {"client_id": "mikas", "online": ONLINE, "offline": OFFLINE} | settings
        made.append(BrokerConnection(to, Outbox() if outbox is None else outbox, **settings))
        return made[-1]

    yield connect
    for each in made:
        each.close()
    made.clear()
    gc.collect()  # the library leaves the socket of an attempt that failed to the collector


def message(kind: MessageKind, number: int, topic: str = "car/t") -> Message:
    return Message(topic, str(number).encode(), kind, time=float(number), rows=1)


def test_online_comes_behind_what_is_kept_and_offline_last(connect, listener):
    outbox = Outbox()
    outbox.put([message(MessageKind.EVENT, 1), message(MessageKind.RETAINED, 2, "car/state")])
    connection = connect(outbox)
    connection.open()
    connection.send([message(MessageKind.SAMPLES, 3)])
    connection.close()
    listener.wait_for(is_("car/availability", b"offline"))
    assert [(it.topic, it.payload) for it in listener.got] == [
        ("car/state", b"2"),
        ("car/availability", b"online"),
        ("car/t", b"1"),
        ("car/t", b"3"),
        ("car/availability", b"offline"),
    ]
    assert connection.sent == 3


def test_after_an_outage_all_that_is_kept_is_sent_again_and_losses_are_reported(
    connect, relay, listener
):
    changes, outbox = Changes(), Outbox(most_events=2)
    connection = connect(outbox, Broker("127.0.0.1", relay.port), on_change=changes)
    connection.open()
    connection.send([message(MessageKind.RETAINED, 1, "car/state")])
    listener.wait_for(is_("car/state"))
    assert changes.wait_for(1) == BrokerChange()
    relay.cut()
    assert isinstance(changes.wait_for(2).error, BrokerLost)
    assert isinstance(changes.wait_for(3).error, BrokerUnreachable)
    listener.wait_for(is_("car/availability", b"offline"))  # the last will
    connection.send([message(MessageKind.EVENT, number, "car/event") for number in range(5)])
    connection.send([message(MessageKind.LIVE, 9, "car/values")])
    before = len(listener.got)
    relay.restore()
    back = changes.wait_for(4)
    assert back.is_connected
    assert (back.lost.events, back.lost.since, back.lost.until) == (3, 0.0, 2.0)
    connection.close()
    listener.wait_for(is_("car/availability", b"offline"), after=before)
    assert [(it.topic, it.payload) for it in listener.got[before:]] == [
        ("car/state", b"1"),
        ("car/availability", b"online"),
        ("car/event", b"3"),
        ("car/event", b"4"),
        ("car/availability", b"offline"),
    ]
    assert len(changes) == 4  # each failure once, however often it was tried


def test_losses_are_reported_though_the_connection_breaks_off_before_it_is_online(
    connect, relay, listener
):
    changes, outbox = Changes(), Outbox(most_events=2)
    outbox.put([message(MessageKind.RETAINED, 1, "car/state")])
    outbox.put(message(MessageKind.EVENT, number, "car/event") for number in range(5))
    relay.breaks = True
    connection = connect(outbox, Broker("127.0.0.1", relay.port), on_change=changes)
    connection.open(patient=True)
    assert isinstance(changes.wait_for(1).error, BrokerLost)
    relay.breaks = False
    back = next(it for it in map(changes.wait_for, range(2, 9)) if it.is_connected)
    assert back.lost.events == 3


def test_a_broker_that_answers_too_late_makes_no_noise_on_the_terminal(
    connect, monkeypatch, caplog
):
    """The client library has given up by then, and leaves an error that asyncio would print."""
    monkeypatch.setattr(module, "_ANSWER", 0.2)
    changes = Changes()
    with socket.create_server(("127.0.0.1", 0)) as server:
        to = Broker("127.0.0.1", server.getsockname()[1])
        connection = connect(to=to, on_change=changes)
        connection.open(patient=True)
        for number in range(3):
            peer, _ = server.accept()
            with peer:
                peer.recv(4096)
                if number == 0:
                    changes.wait_for(1)
                    peer.sendall(b"\x20\x02\x00\x00")  # the connection is accepted
    connection.close()
    gc.collect()
    assert [it.getMessage() for it in caplog.records if it.name == "asyncio"] == []


def test_a_call_that_was_given_up_ends_without_a_traceback(monkeypatch, begun):
    """As with Ctrl-C while the name is resolved, or the port opened."""
    raised, started, go = [], threading.Event(), threading.Event()
    monkeypatch.setattr(threading, "excepthook", raised.append)

    def call() -> None:
        started.set()
        assert go.wait(PATIENCE)

    future = module._DaemonThreads().submit(call)  # noqa: SLF001
    assert started.wait(PATIENCE)
    (thread,) = begun
    future.cancel()
    go.set()
    thread.join(PATIENCE)
    assert raised == []


def test_a_bug_in_the_thread_is_seen_by_the_caller(connect):
    ended = threading.Event()

    def fail(_: BrokerChange) -> None:
        ended.set()
        raise ZeroDivisionError

    connection = connect(on_change=fail)
    connection.open()
    assert ended.wait(PATIENCE)
    connection.close()
    with pytest.raises(ZeroDivisionError):
        connection.send([])


def failure(connect, to: Broker) -> NoBroker:
    with pytest.raises(NoBroker) as caught:
        connect(to=to).open()
    return caught.value


def test_a_port_where_nobody_listens_is_an_unreachable_broker(connect):
    error = failure(connect, Broker("127.0.0.1", free_port()))
    assert isinstance(error, BrokerUnreachable)
    assert "nothing listens" in error.text.en
    assert "listener 1883" in error.text.ru


@pytest.mark.skipif(not Path("/proc/net/if_inet6").exists(), reason="needs IPv6 of Linux")
def test_a_link_local_address_needs_its_interface(connect):
    assert "%eth0" in failure(connect, Broker("fe80::1", 1883)).reason.en


@pytest.mark.parametrize("name", ["no-such-host.invalid", "a..b", f"{'x' * 70}.local"])
def test_a_name_that_nobody_has_is_a_broker_not_found(connect, name):
    assert isinstance(failure(connect, Broker(name, 1883)), BrokerNotFound)


def test_another_program_at_that_port_is_an_unreachable_broker(connect, monkeypatch):
    """It closes the connection, or never answers."""
    monkeypatch.setattr(module, "_ANSWER", 0.2)
    with socket.create_server(("127.0.0.1", 0)) as server:
        error = failure(connect, Broker("127.0.0.1", server.getsockname()[1]))
    assert isinstance(error, BrokerUnreachable)
    assert "mqtts://" in error.text.en


OTHER_PROGRAMS = {
    b"SSH-2.0-OpenSSH_9.2p1\r\n": "SSH-2.0-OpenSSH_9.2p1",
    b"-ERR unknown command\r\n": "-ERR unknown command",
    b"HTTP/1.0 400 Bad request syntax ('\\x10 secret')\r\n\r\n": "HTTP/1.0 400 Bad request syntax",
    b"\x10\x20\x00\x04MQTT secret": None,
    b"\x15\x03\x01\x00\x02\x02\x0a": None,
    b"": None,
}


@pytest.mark.parametrize("said", OTHER_PROGRAMS)
def test_another_program_is_quoted_and_not_waited_for(connect, monkeypatch, said):
    """Without what it repeats of the client's own words, where the password is."""
    monkeypatch.setattr(module, "_ANSWER", 600.0)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer() -> None:
            peer, _ = server.accept()
            peer.recv(4096)
            peer.sendall(said)
            if not said:
                peer.close()
            peers.append(peer)

        peers = []
        threading.Thread(target=answer, daemon=True).start()
        error = failure(connect, Broker("127.0.0.1", server.getsockname()[1]))
        for peer in peers:
            peer.close()
    assert isinstance(error, BrokerUnreachable)
    words = OTHER_PROGRAMS[said]
    assert (f"“{words}" if words else "mqtts://") in error.reason.en
    assert "secret" not in error.reason.en


@pytest.mark.parametrize(("code", "concerns_user"), [(3, False), (2, False), (5, True)])
def test_a_refusal_sends_to_the_password_only_where_that_may_be_it(connect, code, concerns_user):
    with socket.create_server(("127.0.0.1", 0)) as server:

        def refuse() -> None:
            peer, _ = server.accept()
            with peer:
                peer.recv(4096)
                peer.sendall(bytes([0x20, 2, 0, code]))

        threading.Thread(target=refuse, daemon=True).start()
        error = failure(connect, Broker("127.0.0.1", server.getsockname()[1]))
    assert isinstance(error, BrokerRefused)
    assert ("password" in error.advice.en) == concerns_user


def received(peer: socket.socket) -> bytes:
    """What a client has sent; nothing when it has gone, with or without a word."""
    try:
        return peer.recv(4096)
    except OSError:
        return b""


def silent_broker(server: socket.socket, served: threading.Semaphore, *, answers: int) -> None:
    """Acknowledge `answers` packets of each client, from its CONNECT on, and then nothing."""

    def serve(peer: socket.socket) -> None:
        said, left = b"", answers
        while data := received(peer):
            said += data
            while len(said) > 1 and len(said) >= 2 + said[1]:  # short packets only
                packet, said = said[: 2 + said[1]], said[2 + said[1] :]
                if left > 0 and packet[0] >> 4 == 1:
                    peer.sendall(b"\x20\x02\x00\x00")
                    left -= 1
                elif left > 0 and packet[0] & 6:
                    at = 4 + int.from_bytes(packet[2:4], "big")
                    peer.sendall(b"\x40\x02" + packet[at : at + 2])
                    left -= 1
        peer.close()

    while True:
        try:
            peer, _ = server.accept()
        except OSError:
            return
        served.release()
        threading.Thread(target=serve, args=(peer,), daemon=True).start()


@pytest.fixture
def silent(monkeypatch):
    """Begin brokers that fall silent; nothing but the silence itself may end their connections."""
    monkeypatch.setattr(module, "KEEP_ALIVE", 600)
    monkeypatch.setattr(module, "_LOOK", 0.1)
    servers = []

    def begin(answers: int) -> tuple[Broker, threading.Semaphore]:
        servers.append(server := socket.create_server(("127.0.0.1", 0)))
        served = threading.Semaphore(0)
        threading.Thread(
            target=silent_broker, args=(server, served), kwargs={"answers": answers}, daemon=True
        ).start()
        return Broker("127.0.0.1", server.getsockname()[1]), served

    yield begin
    for server in servers:
        server.shutdown(socket.SHUT_RDWR)
        server.close()


def test_a_broker_that_welcomes_and_says_nothing_more_is_reported_once(connect, silent):
    """However often it is tried; and no other client is suspected, for it closes nothing."""
    to, served = silent(answers=1)
    changes = Changes()
    connect(to=to, on_change=changes).open(patient=True)
    for _ in range(3):
        assert served.acquire(timeout=PATIENCE)
    (change,) = changes
    assert isinstance(change.error, BrokerLost)
    assert "no answer" in change.error.reason.en
    assert "another program" not in change.error.text.en


def test_a_silent_broker_is_lost_and_what_it_has_not_acknowledged_was_not_published(
    connect, silent
):
    to, _ = silent(answers=2)  # its welcome, and “online”
    changes = Changes()
    connection = connect(to=to, on_change=changes)
    connection.open(patient=True)
    reached = next(it for it in range(1, 9) if changes.wait_for(it).is_connected)
    connection.send([Message("car/values", b"1", MessageKind.LIVE, qos=0)])
    lost = changes.wait_for(reached + 1).error
    assert isinstance(lost, BrokerLost)
    assert "no answer" in lost.reason.en
    assert connection.sent == 0


def test_a_patient_connection_waits_for_its_broker(connect, relay):
    changes = Changes()
    relay.cut()
    connect(to=Broker("127.0.0.1", relay.port), on_change=changes).open(patient=True)
    assert isinstance(changes.wait_for(1).error, BrokerUnreachable)
    relay.restore()
    assert changes.wait_for(2).is_connected


def test_without_the_library_the_extra_is_named(connect, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "aiomqtt", None)
    with pytest.raises(MissingExtra, match=r'pip install "mikas\[mqtt\]"'):
        connect()
