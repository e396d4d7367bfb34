"""The ways in which a client comes, stays and goes; each is a function of a `Network`.

What the server says is only read here: `World` judges what others notice of it.
"""

from __future__ import annotations

import socket
import ssl
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from random import Random
from typing import Final

from fuzz.clients.caller import BINARY, CLOSE, PING, TEXT, Caller, Cut, End, frame
from fuzz.clients.world import HOST, TOKEN, World

_LATE: Final = (0, 1, 2, 10)  # sweeps, ten a second here, after which TLS is ended
_IN_A_ROW: Final = 400
_CONNECTIONS: Final = 600
_MOST_KEPT: Final = 100
_ENDS: Final = tuple(End)
_KEY: Final = 22 * "A" + "=="


@dataclass
class Network:
    """The clients of a case. `context`: None without TLS; `token`: empty without one."""

    world: World
    context: ssl.SSLContext | None
    token: str
    random: Random
    kept: list[socket.socket] = field(default_factory=list)

    def reach(self) -> socket.socket:
        """Return a connection from any address of the network."""
        host = f"127.0.{self.random.randrange(1, 200)}.{self.random.randrange(1, 250)}"
        own = socket.create_connection(("127.0.0.2", self.world.port), 60, (host, 0))
        own.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.kept.append(own)
        return own

    def call(self, budget: int | None = None) -> Caller:
        """Return a caller that has shaken hands."""
        caller = Caller(self.reach(), self.context, budget)
        caller.shake_hands()
        return caller

    def close(self) -> None:
        """Close what is left."""
        for own in self.kept:
            own.close()

    def request(self, path: str = "/api/about", *more: str, method: str = "GET") -> bytes:
        """Return a request, with the token."""
        lines = [f"{method} {path} HTTP/1.1", f"Host: {HOST}:{self.world.port}", *more]
        if self.token:
            lines.append(f"Authorization: Bearer {self.token}")
        return "\r\n".join([*lines, "", ""]).encode()

    def upgrade(self, *more: str) -> bytes:
        """Return the request of a WebSocket."""
        name = f"client-{self.random.getrandbits(40)}"
        return self.request(
            f"/api/live?client={name}", "Connection: Upgrade", "Upgrade: websocket",
            "Sec-WebSocket-Version: 13", f"Sec-WebSocket-Key: {_KEY}", *more,
        )  # fmt: skip

    def websocket(self, *frames: bytes) -> Caller:
        """Return a caller that knows whether it has its WebSocket, and has sent `frames`."""
        caller = self.call()
        with left():
            caller.send(self.upgrade())
            caller.read_until(b"\r\n\r\n")
            for data in frames:
                caller.send(data)
        return caller


Manner = Callable[[Network], None]
MANNERS: Final[dict[str, Manner]] = {}
STAGES: Final[dict[str, Callable[[Network], Caller]]] = {
    "tcp": lambda net: Caller(net.reach(), None),
    "handshake": lambda net: net.call(),
    "head": lambda net: _sent(net, net.request()[:20]),
    "request": lambda net: _sent(net, net.request()),
    "response": lambda net: _sent(net, net.request(), answer=b"}"),
    "no request": lambda net: _sent(net, b"\x16\x03\x01\r\n\r\n"),
    "no second request": lambda net: _sent(net, net.request() + b"\x16\x03\x01\r\n\r\n"),
    "body": lambda net: _sent(
        net, net.request("/api/connect", "Content-Length: 20", method="POST"), b'{"port":'
    ),
    "upgrade": lambda net: _sent(net, net.upgrade()),
    "foreign page": lambda net: _sent(net, net.upgrade("Origin: http://a.example"), answer=b"}"),
    "websocket": lambda net: net.websocket(),
    "frame": lambda net: net.websocket(frame(TEXT, b'{"ping":1}')),
    "part of a frame": lambda net: net.websocket(frame(TEXT, b"{}")[:3]),
    "closed": lambda net: net.websocket(frame(CLOSE, b"\x03\xe8")),
    "violation": lambda net: net.websocket(frame(TEXT, b"no")),
}
"""How far a client comes before it goes."""


def _manner(function: Manner) -> Manner:
    MANNERS[function.__name__] = function
    return function


def left() -> suppress:
    """Return the `with` of acts on a connection that the server may have closed."""
    return suppress(ConnectionError, ssl.SSLError, Cut)


def _sent(network: Network, *parts: bytes, answer: bytes = b"") -> Caller:
    """Return a caller that has sent `parts`, and read until `answer`, if there is one."""
    caller = network.call()
    with left():
        for part in parts:
            caller.send(part)
        if answer:
            caller.read_until(answer)
    return caller


@_manner
def closes_at_each_byte(network: Network) -> None:
    """The handshake of TLS, the request of a WebSocket and a frame, cut after each byte."""

    def visit(message: bytes, budget: int | None) -> Caller:
        caller = Caller(network.reach(), network.context, budget)
        with left():
            caller.shake_hands()
            caller.send(message)
        return caller

    message = network.upgrade() + frame(TEXT, b'{"ping":1}')
    for length in range(visit(message, None).sent):
        visit(message, length).leave(network.random.choice(_ENDS))
        _keep_few(network)


@_manner
def goes_at_each_stage(network: Network) -> None:
    """In every way: with a goodbye or without, reset, half closed, silent for ever."""
    for stage in STAGES.values():
        for end in _ENDS:
            with left():
                stage(network).leave(end)
    network.world.sweep(2)


@_manner
def says_goodbye_late(network: Network) -> None:
    """TLS is ended some sweeps after the server has ended it, or never."""
    stages = ("closed", "violation", "foreign page", "websocket", "response", "no request")
    late = [(sweeps, STAGES[name](network)) for sweeps in _LATE for name in stages]
    at = 0
    for sweeps, caller in late:
        network.world.sweep(sweeps - at)
        at = sweeps
        with left():
            caller.say_goodbye()


@_manner
def closes_often_in_a_row(network: Network) -> None:
    """A WebSocket is closed by its client, whose goodbye never comes."""
    for number in range(_IN_A_ROW):
        caller = network.websocket(frame(CLOSE, b"\x03\xe9"))
        caller.leave(End.SILENT if number % 4 else End.RESET)
        _keep_few(network)


@_manner
def floods_with_connections(network: Network) -> None:
    """More than there are places; half of them say something."""
    for number in range(_CONNECTIONS):
        with left():
            network.reach().sendall(b"\x16\x03\x01\x02" if number % 2 else b"")


@_manner
def floods_with_bytes(network: Network) -> None:
    """In place of TLS, of a request, of frames; and behind the end of TLS."""
    noise = network.random.randbytes(1 << 14)
    for begin in (b"", b"\x16\x03\x01\x40\x00", network.request()):
        caller = Caller(network.reach(), None)
        with left():
            caller.send(begin)
            caller.pour(noise, 200)
    for begin in (b"", network.request(), network.upgrade(), network.request("/", method="PUT")):
        caller = _sent(network, begin)
        with left():
            caller.pour(noise, 200)
    caller = network.websocket()
    with left():
        caller.say_goodbye()
        caller.send_raw(noise)


@_manner
def floods_with_frames(network: Network) -> None:
    """Messages, pings whose answers it does not take, pieces without an end, what is no frame."""
    floods = (
        frame(PING, bytes(125)) * 500, frame(TEXT, b'{"ping":"' + bytes(99) + b'"}'),
        frame(BINARY, bytes(9000)), frame(TEXT, b"x" * (1 << 17)),
        frame(TEXT, b"{", final=False) + frame(0, b" ", final=False) * 100,
        frame(0, b"lost"), frame(3), frame(TEXT, b"{}", masked=False), frame(CLOSE, b"\0"),
        frame(TEXT, b"\xff\xfe"), frame(PING, bytes(126)), frame(CLOSE) * 5,
        network.random.randbytes(4000),
    )  # fmt: skip
    for flood in floods:
        at_once = network.call()  # before there is an answer
        for caller, data in ((network.websocket(), flood), (at_once, network.upgrade() + flood)):
            with left():
                caller.pour(data, 200)


@_manner
def floods_with_headers(network: Network) -> None:
    """Slow ones, long ones, many; requests one behind the other; bodies that never end."""
    many = [f"X-{number}: {60 * 'b'}" for number in range(2000)]
    path, post = "/api/connect", "POST"
    chunked = network.request(path, "Transfer-Encoding: chunked", method=post)
    heads = (
        network.request("/", *many), network.request("/" + "a" * 100_000),
        network.request() * 300, chunked + b"1\r\n \r\n", chunked + b"fffffffffff\r\n",
        network.request(path, "Content-Length: 99999999999", method=post),
        network.request(path, "Content-Length: -1", method=post),
        network.request(path, "Expect: 100-continue", "Content-Length: 9", method=post),
        network.request("/", "Upgrade: h2c", "Connection: Upgrade"), network.upgrade(*many[:200]),
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", b"\r\n" * 9000, bytes(9000), b"GET /\r\n\r\n",
    )  # fmt: skip
    for head in heads:
        caller = network.call()
        with left():
            caller.pour(head, 3)
    slow = [network.call() for _ in range(10)]
    for number in range(len(network.request()) - 1):
        for caller in slow:
            with left():
                caller.send(network.request()[number : number + 1])


def _keep_few(network: Network) -> None:
    if len(network.kept) > _MOST_KEPT:
        network.kept.pop(0).close()


@dataclass
class Crowd:
    """Clients of all stages at a time, each of which then does anything, and goes."""

    network: Network
    done: list[str] = field(default_factory=list)
    """What they did, in words."""

    def visit(self, steps: int) -> None:
        """Come, act and go, so many times."""
        random, callers = self.network.random, []
        for _ in range(steps):
            name = random.choice(tuple(STAGES))
            self.done.append(name)
            with left():
                callers.append(STAGES[name](self.network))
            if callers and random.random() < 0.7:
                caller, end = callers.pop(random.randrange(len(callers))), random.choice(_ENDS)
                self._act(caller)
                self.done.append(f"goes: {end.name}")
                caller.leave(end)
            _keep_few(self.network)

    def _act(self, caller: Caller) -> None:
        random = self.network.random
        act = random.choice(("noise", "frames", "request", "goodbye", "sweep", ""))
        self.done.append(act)
        kind, size = random.choice((TEXT, BINARY, PING, CLOSE, 0, 5)), random.choice((2, 125, 300))
        with left():
            if act == "noise":
                caller.pour(random.randbytes(random.randrange(3000)), 5)
            elif act == "frames":
                caller.pour(frame(kind, random.randbytes(size)), random.randrange(1, 40))
            elif act == "request":
                caller.send(self.network.request()[: random.randrange(400)])
            elif act == "goodbye":
                caller.say_goodbye()
            elif act == "sweep" and random.random() < 0.2:
                self.network.world.sweep(1)


def run(network: Network, manner: Manner) -> None:
    """Let the clients of one manner come and go, and check the world."""
    world = network.world
    world.record()
    try:
        with left():
            manner(network)
        world.check()
    finally:
        network.close()
    world.free()
    world.more_samples(3)
    world.check()
    world.check_recording()


def network_of(world: World, context: ssl.SSLContext, random: Random, *, token: bool) -> Network:
    """Return the network before `world`, whose clients have the token or not."""
    return Network(world, context if world.tls else None, TOKEN if token else "", random)
