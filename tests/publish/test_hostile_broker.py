"""A broker that means harm: it is left at once, and costs neither memory nor the samples."""

from __future__ import annotations

import socket
import threading
import tracemalloc
from collections.abc import Callable
from contextlib import suppress

import pytest
from broker_rig import PATIENCE

from mikas.publish import client as bounded
from mikas.publish import connection as module
from mikas.publish.broker import Broker
from mikas.publish.client import ANSWER, BURST, LARGEST, PIECE, RATE, Allowance, BrokerTooLoud
from mikas.publish.connection import BrokerChange, BrokerConnection
from mikas.publish.outbox import Message, MessageKind, Outbox

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
]

ONLINE = Message("car/availability", b"online", MessageKind.RETAINED)
OFFLINE = Message("car/availability", b"offline", MessageKind.RETAINED)
WELCOME = b"\x20\x02\x00\x00"
HUGE = 100 << 20


def packet(first: int, body: bytes) -> bytes:
    length, size = len(body), b""
    while True:
        length, low = divmod(length, 128)
        size += bytes([low | (128 if length else 0)])
        if not length:
            return bytes([first]) + size + body


def published(topic: bytes, payload: bytes = b"", qos: int = 0) -> bytes:
    number = b"\x00\x01" if qos else b""
    return packet(0x30 | qos << 1, len(topic).to_bytes(2, "big") + topic + number + payload)


def then(*data: bytes) -> Callable[[socket.socket], None]:
    """Welcome the client, then send this, as often as it takes it."""

    def attack(sock: socket.socket) -> None:
        sock.sendall(WELCOME)
        for each in data:
            sock.sendall(each)
        sock.recv(1 << 16)
        sock.recv(1 << 16)

    return attack


def for_ever(data: bytes, before: bytes = WELCOME) -> Callable[[socket.socket], None]:
    def attack(sock: socket.socket) -> None:
        sock.sendall(before)
        while True:
            sock.sendall(data)

    return attack


def huge(sock: socket.socket) -> None:
    """A message of 100 MB on the topic that was subscribed to."""
    sock.sendall(WELCOME)
    sock.recv(1 << 16)
    sock.sendall(b"\x90\x03\x00\x01\x01")
    body = len(b"ha/config").to_bytes(2, "big") + b"ha/config"
    sock.sendall(b"\x31\x80\x80\x80\x32" + body)  # of 100 MiB
    for _ in range(HUGE >> 20):
        sock.sendall(bytes(1 << 20))


def hang_up(sock: socket.socket) -> None:
    sock.sendall(WELCOME)
    sock.recv(1)


def no_welcome(sock: socket.socket) -> None:
    sock.recv(1 << 16)
    sock.recv(1 << 16)


ATTACKS = {
    "a topic that is no text": then(published(b"\xff\xfe")),
    "an empty topic": then(published(b"")),
    "a topic with a wildcard": then(published(b"car/#/x")),
    "such topics for ever": for_ever(published(b"\xff\xfe", bytes(100))),
    "a huge retained message": huge,
    "a huge welcome": for_ever(bytes(1 << 16), b"\x20\xff\xff\xff\x7f"),
    "a length without end": then(b"\x30\xff\xff\xff\xff\xff\x7f"),
    "a welcome of one byte": for_ever(bytes(1), b"\x20\x01\x00"),
    "a message that is too short": then(b"\x30\x00"),
    "an acknowledgement that is too short": then(b"\x40\x01\x00"),
    "an empty acknowledgement of a subscription": then(b"\x90\x00"),
    "an unknown packet": then(b"\xf0\x00"),
    "a packet of the client": then(b"\x10\x00"),
    "messages for ever": for_ever(published(b"car/x", bytes(1000)) * 50),
    "messages that must be kept": for_ever(published(b"car/x", bytes(100_000), qos=2)),
    "answers to pings for ever": for_ever(b"\xd0\x00" * 1000),
    "acknowledgements of nothing for ever": for_ever(b"\x40\x02\x00\x09" * 1000),
    "noise for ever": for_ever(bytes(range(256)) * 16),
    "it hangs up at each packet": hang_up,
    "it never welcomes": no_welcome,
    "it acknowledges nothing": then(),
}


class HostileBroker:
    """Serves one client after the other in its way."""

    def __init__(self, attack: Callable[[socket.socket], None]) -> None:
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port = self._server.getsockname()[1]
        self.served = 0
        self._attack = attack
        self._again = threading.Event()
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        with suppress(OSError):
            while True:
                sock, _ = self._server.accept()
                self.served += 1
                if self.served == 3:
                    self._again.set()
                with sock, suppress(OSError):
                    sock.recv(1 << 16)
                    self._attack(sock)

    def wait_for_the_third_client(self) -> None:
        assert self._again.wait(PATIENCE)

    def close(self) -> None:
        self._server.close()


@pytest.fixture
def calls(monkeypatch):
    """How often the library has looked at the socket."""
    counted = []
    read = bounded._BoundedPaho.loop_read  # noqa: SLF001

    def counting(self, *args):
        counted.append(None)
        return read(self, *args)

    monkeypatch.setattr(bounded._BoundedPaho, "loop_read", counting)  # noqa: SLF001
    monkeypatch.setattr(module, "_PAUSE", 0.01)
    monkeypatch.setattr(module, "_ANSWER", 0.3)
    monkeypatch.setattr(module, "_KEPT", 0.3)
    return counted


@pytest.mark.parametrize("attack", ATTACKS)
def test_a_hostile_broker_is_left_and_tried_again(attack, calls):
    broker = HostileBroker(ATTACKS[attack])
    changes: list[BrokerChange] = []
    connection = BrokerConnection(
        Broker("127.0.0.1", broker.port),
        outbox := Outbox(),
        client_id="mikas",
        online=ONLINE,
        offline=OFFLINE,
        on_change=changes.append,
        kept_topic="ha/config",
    )
    tracemalloc.start()
    try:
        connection.open(patient=True)
        for number in range(100):
            connection.send([Message("car/t", b"1", MessageKind.EVENT, time=float(number))])
        broker.wait_for_the_third_client()
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
        connection.close()
        broker.close()
    assert changes
    assert all(it.error is not None or it.is_connected for it in changes)
    assert len(calls) < 3 * (BURST // PIECE)
    assert peak < 16 * LARGEST
    assert outbox.unsent.events == 100


def test_a_packet_is_refused_before_its_first_byte_is_read():
    allowance = Allowance(lambda: 0.0)
    allowance.ask(LARGEST)
    with pytest.raises(BrokerTooLoud):
        allowance.ask(LARGEST + 1)
    assert allowance.exceeded


def test_what_a_broker_answers_is_never_too_much():
    """A week of values with QoS 1, after an outage: as quick as the broker acknowledges."""
    allowance = Allowance(lambda: 0.0)
    for _ in range(200_000):
        allowance.more(ANSWER)
        for piece in (1, 1, 2):
            allowance.took(piece)
    time = 0.0
    allowance = Allowance(lambda: time)
    for _ in range(100_000):
        time += 15
        allowance.took(1)
        allowance.took(1)
    assert not allowance.exceeded


def test_what_comes_for_ever_is_too_much():
    time = 0.0
    allowance = Allowance(lambda: time)
    seconds = 0
    with suppress(BrokerTooLoud):
        while seconds < 10 * BURST / RATE:
            time = seconds = seconds + 1
            allowance.took(2 * RATE)
    assert allowance.exceeded
    assert seconds == pytest.approx(BURST / RATE, abs=2)
