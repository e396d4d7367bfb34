"""The server's TCP connections: how many there are, of whom, and how long one may wait.

A connection counts from the moment it is accepted until its socket is closed, also during a TLS
handshake. A full server makes room: it drops the connection that has waited longest for its
client, so half-open ones never keep anyone out. Only if all are at work is a new one refused.
Some places are kept for this computer, and each address in the network has a limit of its own.

    waits for a request, or for TLS and a request    10 s
    waits for the rest of a request's body           30 s
    at work, or a WebSocket                          no limit here
    was closed, and has nothing to send any more      2 s
    the client takes none of what was sent           30 s, in each of these

`sweep` ends what has waited too long; the server calls it every second. What a connection waits for
comes from `server.PhaseReports`. All of it runs in the event loop. `clock`: seconds that never
run back, a `TurnClock`.
"""

from __future__ import annotations

import asyncio
import errno
import logging
import os
import socket
import sys
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum
from ipaddress import IPv6Network
from typing import TYPE_CHECKING, Any, Final

from mikas.dashboard.network.addresses import is_ipv6
from mikas.dashboard.network.listening import is_loopback
from mikas.files import allow_open

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

HEAD_SECONDS: Final = 10.0
BODY_SECONDS: Final = 30.0
GOODBYE_SECONDS: Final = (
    2.0  # for the other side to end TLS; a phone that left the Wi-Fi never does
)
STALL_SECONDS: Final = 30.0
LONGEST_TURN: Final = 2.0
MAX_TOTAL: Final = 256
MAX_NEW: Final = 50  # of an address in the network, each second
_MIN_TOTAL = 64
_OTHER_FILES = 256  # descriptors of recordings, exports, ports, and of connections being closed
_DESCRIPTORS = 1024  # more would not do: pyserial waits by select()
_REFUSED_AT_ONCE = 64
_log = logging.getLogger("mikas.dashboard")

End = tuple[str, int]
"""The address and port of one end of a connection."""

_EXHAUSTED = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)


class TcpPhase(Enum):
    """What a connection waits for."""

    REQUEST = HEAD_SECONDS
    BODY = BODY_SECONDS
    END = GOODBYE_SECONDS
    NOTHING = None


class TurnClock:
    """Seconds in which the event loop had its turns, by `clock`; it is read ten times a second.

    A program that was stopped or starved, or whose computer slept, did not wait for its clients in
    that time: their requests may be in the system's buffers. So such a stall does not count.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock, self._read, self._now = clock, clock(), 0.0

    def __call__(self) -> float:
        before, self._read = self._read, self._clock()
        step = self._read - before
        if step <= LONGEST_TURN:
            self._now += step
        return self._now


@dataclass(frozen=True, slots=True)
class TcpLimits:
    """Connections at once: of all, those of them kept for this computer, of another address."""

    total: int = MAX_TOTAL

    @property
    def kept(self) -> int:
        """The connections that only this computer may have."""
        return self.total // 4

    @property
    def each(self) -> int:
        """The connections of one address in the network."""
        return self.total // 8

    @classmethod
    def of_this_process(cls) -> TcpLimits:
        """Return the limits that the system's limit of open files allows."""
        return cls(max(_MIN_TOTAL, min(MAX_TOTAL, allow_open(_DESCRIPTORS) - _OTHER_FILES)))


@dataclass(eq=False, slots=True, weakref_slot=True)
class TcpConnection:
    """An accepted connection. `address`: of an address in the network; None: of this computer.

    `here`: the address of this computer at which it came in.
    """

    address: str | None
    here: str
    _socket: AcceptedSocket
    since: float
    phase: TcpPhase = TcpPhase.REQUEST
    _transport: asyncio.Transport | None = None
    _protocol: asyncio.BaseProtocol | None = None
    dropped: bool = False
    """Whether it was dropped; its socket may still be open for a moment."""
    _moved: float = 0.0  # when the client last took something of the unsent
    _unsent: int = 0
    _refused: bool = False

    def attach(self, transport: asyncio.Transport, protocol: asyncio.BaseProtocol) -> None:
        """Set the transport and its HTTP, once there are; for TLS after the handshake."""
        self._transport, self._protocol = transport, protocol

    def enter(self, phase: TcpPhase, now: float) -> None:
        """Set the phase; its time begins, unless it is the present one."""
        if phase is not self.phase:
            self.phase, self.since = phase, now

    @property
    def unsent(self) -> int:
        """Bytes that the client has not taken; the system's own buffer is not counted.

        A transport of TLS counts only those that it has not passed to the transport below it; of
        those without TLS some are counted twice.
        """
        waiting = self._transport.get_write_buffer_size() if self._transport else 0
        return waiting + self._socket.unsent

    @property
    def is_closing(self) -> bool:
        """Whether the server has closed it, and the client has not yet."""
        return self._transport is not None and self._transport.is_closing()

    @property
    def waits(self) -> bool:
        """Whether it has waited for its client since `since`, and may be dropped for another."""
        return not self.dropped and self.phase is not TcpPhase.NOTHING and not self.unsent

    def is_late(self, now: float) -> bool:
        """Return whether the client has kept the server waiting for too long."""
        before, self._unsent = self._unsent, self.unsent
        if not before or self._unsent < before:
            self._moved = now
        if self._unsent:
            self.since = now  # the client is still taking the last response
            return now - self._moved >= STALL_SECONDS
        if self.is_closing:
            self.enter(TcpPhase.END, now)
        before, self._refused = self._refused, self._is_websocket_without_a_request()
        if before and self._refused:
            return True
        return self.phase.value is not None and now - self.since >= self.phase.value

    def _is_websocket_without_a_request(self) -> bool:
        """Return whether HTTP gave way to a WebSocket that the application has not been asked for:
        it may be about to be, or was refused without an answer, for more headers than are read."""
        transport = self._transport
        if transport is None or self.phase is not TcpPhase.REQUEST:
            return False
        return transport.get_protocol() is not self._protocol

    def drop(self) -> None:
        """End the connection at once; its socket is closed in one of the next turns."""
        if self.dropped:
            return
        self.dropped = True
        try:
            if self._transport is not None:
                self._transport.abort()
            else:  # the end of a handshake
                self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            return  # the client has gone already
        except Exception:  # of one connection; the server and the others go on
            _log.exception("a connection could not be closed")


class TcpConnections:
    """All connections of a server."""

    def __init__(self, limits: TcpLimits, clock: Callable[[], float]) -> None:
        self.limits = limits
        self.clock = clock
        self._open: dict[tuple[End, End], TcpConnection] = {}
        """By the ends: the client's, and the one here."""
        self._new: Counter[str] = Counter()
        self._second = 0.0
        self._spare: int | None = None

    def __len__(self) -> int:
        """Return the number of connections whose sockets are open."""
        return len(self._open)

    def between(self, client: End, here: End) -> TcpConnection | None:
        """Return the connection with these ends; None: it has gone already."""
        return self._open.get((client, here))

    def accept(self, listening: socket.socket) -> AcceptedSocket:
        """Accept a connection. Raises `BlockingIOError` if none that may come in is waiting."""
        if self._spare is None:
            self._spare = _spare()
        for _ in range(_REFUSED_AT_ONCE):
            try:
                own, peer = listening.accept()
            except OSError as error:
                if not is_exhausted(error) or self._spare is None:
                    raise
                self._refuse_by_spare(listening)
                continue
            accepted = AcceptedSocket(own.family, own.type, own.proto, fileno=own.detach())
            try:
                if self.admit(accepted, peer):
                    return accepted
            except OSError as error:
                _log.debug("a client has gone already, and has no name: %s", error)
            except BaseException:
                accepted.close()
                raise
            accepted.close()
        raise BlockingIOError

    def admit(self, accepted: AcceptedSocket, peer: End) -> bool:
        """Return whether a new connection of `peer` may come in, and count it."""
        address, now = _address(peer), self.clock()
        if address is not None and not (self._is_fair(address, now) and self._fits(address)):
            return False
        live = self._live()
        if len(live) >= self.limits.total:
            others = [it for it in live if it.address is not None]
            if not (self._make_room(others) or self._make_room(live)):
                return False
        here = accepted.getsockname()
        ends = peer[:2], here[:2]  # as ASGI names them: of IPv6 there are four parts
        connection = TcpConnection(address, str(here[0]), accepted, now)
        self._open[ends] = accepted.connection = connection
        accepted.left = lambda: self._open.pop(ends, None)
        return True

    def sweep(self) -> None:
        """Drop the connections that have kept the server waiting for too long."""
        now = self.clock()
        for connection in self._live():
            try:
                is_late = connection.is_late(now)
            except Exception:  # of one connection; the server and the others go on
                _log.exception("a connection could not be checked, and was closed")
                is_late = True
            if is_late:
                connection.drop()

    def drop_closing(self) -> None:
        """Drop the connections that wait for their other side to be closed."""
        for connection in self._live():
            if connection.is_closing:
                connection.drop()

    def _live(self) -> list[TcpConnection]:
        return [it for it in self._open.values() if not it.dropped]

    def _is_fair(self, address: str, now: float) -> bool:
        if now - self._second >= 1:
            self._new.clear()
            self._second = now
        self._new[address] += 1
        return self._new[address] <= MAX_NEW

    def _fits(self, address: str) -> bool:
        others = [it for it in self._live() if it.address is not None]
        same = [it for it in others if it.address == address]
        if len(same) >= self.limits.each:
            return self._make_room(same)
        return len(others) < self.limits.total - self.limits.kept or self._make_room(others)

    @staticmethod
    def _make_room(among: Iterable[TcpConnection]) -> bool:
        """Drop the one that has waited longest, of the address that has most; False: none waits."""
        waiting = [it for it in among if it.waits]
        if not waiting:
            return False
        many = Counter(it.address for it in waiting)
        min(waiting, key=lambda it: (-many[it.address], it.since)).drop()
        return True

    def _refuse_by_spare(self, listening: socket.socket) -> None:
        """Close one waiting connection, with no descriptor left but the spare one."""
        assert self._spare is not None
        self._make_room(self._live())
        os.close(self._spare)
        self._spare = None
        try:
            listening.accept()[0].close()
        finally:
            self._spare = _spare()


def is_exhausted(error: object) -> bool:
    """Return whether the system had no descriptor or memory for a connection."""
    return isinstance(error, OSError) and error.errno in _EXHAUSTED


class AcceptedSocket(socket.socket):
    """A connection's socket; `left` is called when it is closed.

    `unsent`: of the bytes last given to it, those that the system did not take.
    """

    connection: TcpConnection
    left: Callable[[], object] | None = None
    unsent: int = 0

    def send(self, data: ReadableBuffer, flags: int = 0, /) -> int:
        """Send, as `socket.send`."""
        self.unsent = memoryview(data).nbytes
        sent = super().send(data, flags)
        self.unsent -= sent
        return sent

    if sys.platform != "win32":

        def sendmsg(self, buffers: Iterable[ReadableBuffer], *other: Any) -> int:
            """Send, as `socket.sendmsg`; asyncio does from Python 3.12 on."""
            parts = [memoryview(part) for part in buffers]
            self.unsent = sum(part.nbytes for part in parts)
            sent = super().sendmsg(parts, *other)
            self.unsent -= sent
            return sent

    def close(self) -> None:
        """Close the socket, and count it no longer."""
        left, self.left = self.left, None
        if left is not None:
            left()
        super().close()


def _address(peer: End) -> str | None:
    address = str(peer[0]) if peer else ""  # of one that has gone already, macOS gives none
    if is_loopback(address):
        return None
    if is_ipv6(address):  # one computer may have all of a /64
        return str(IPv6Network((address.partition("%")[0], 64), strict=False))
    return address


def _spare() -> int | None:
    try:
        return os.open(os.devnull, os.O_RDONLY)
    except OSError:
        return None
